//! Constraints on a motion at one time: limits of acceleration and jerk, a standing foot, and user-defined rows in
//! $(t, q, v, a, u)$.

use super::{MAX_ORDER, Phase, Quantity, RateLimit, RowLabel, StandingFoot, TimeWindow};
use crate::error::{Error, Result, check_length};
use crate::model::Model;
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};
use num_dual::HyperDual64;
use std::fmt;
use std::sync::Arc;

/// A motion at one time, with its control.
#[derive(Clone, Copy, Debug)]
pub struct StageInput<'a, S> {
    /// Time, s.
    pub t: S,
    /// The configuration, rad or m, `N` entries.
    pub q: &'a [S],
    /// The velocity, rad/s or m/s.
    pub v: &'a [S],
    /// The acceleration, rad/s^2 or m/s^2.
    pub a: &'a [S],
    /// The control $u = ID(q, v, a)$, N m or N.
    pub u: &'a [S],
}

impl<'a, S> StageInput<'a, S> {
    /// The parts of $y = [q; v; a; u]$, `4 N` entries, at a time.
    pub(crate) fn of(t: S, y: &'a [S]) -> Self {
        let n = y.len() / 4;
        let [q, v, a, u] = [0, 1, 2, 3].map(|part| &y[part * n..(part + 1) * n]);
        Self { t, q, v, a, u }
    }
}

/// The derivatives of a function of $y = [q; v; a; u]$, with the control as an independent variable.
#[derive(Clone, Debug)]
pub struct StageDerivatives<S: Scalar> {
    /// $\partial l / \partial y$, `4 N` entries.
    pub gradient: DVector<S>,
    /// $\partial^2 l / \partial y^2$, `4 N` by `4 N`, both triangles.
    pub hessian: DMatrix<S>,
}

impl<S: Scalar> StageDerivatives<S> {
    /// Zeros for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { gradient: DVector::zeros(4 * n), hessian: DMatrix::zeros(4 * n, 4 * n) }
    }
}

/// Inequalities $g_j(t, q, v, a, u) \le 0$ along motions of a robot. [`StageRows`] accepts a closure without
/// derivatives.
///
/// A row that concerns a part of the motion alone is a negative constant at other times.
pub trait StageConstraint: fmt::Debug + Send + Sync {
    /// The number of rows $g_j$.
    fn dim(&self) -> usize;

    /// Computes $g$ into `g`, [`dim`](Self::dim) entries. A positive value is a violation.
    ///
    /// # Errors
    /// A slice of the input does not have `N` entries.
    fn value(&self, at: &StageInput<'_, f64>, g: &mut [f64]) -> Result<()>;

    /// Computes the gradient of each row in $y = [q; v; a; u]$ into the columns of `gradients`, `4 N` by
    /// [`dim`](Self::dim), and adds $\sum_j \lambda_j\\, \partial^2 g_j / \partial y^2$ to `hessian`, `4 N` by `4 N`.
    ///
    /// # Errors
    /// A slice of the input does not have `N` entries.
    fn derivatives(
        &self,
        at: &StageInput<'_, f64>,
        multipliers: &[f64],
        gradients: &mut DMatrix<f64>,
        hessian: &mut DMatrix<f64>,
    ) -> Result<()>;

    /// Computes $\partial g_j / \partial t$ into `rates`, [`dim`](Self::dim) entries, which a free horizon needs for
    /// rows that depend explicitly on time. Zero by default.
    ///
    /// # Errors
    /// A slice of the input does not have `N` entries.
    fn time_rates(&self, at: &StageInput<'_, f64>, rates: &mut [f64]) -> Result<()> {
        let _ = at;
        rates.fill(0.0);
        Ok(())
    }

    /// The rows of the state that are kept between two times, at these times too, if that is what they are.
    fn window(&self) -> Option<&TimeWindow> {
        None
    }

    /// The value of each row at a bad violation, in the unit of its label: rows are measured relative to it. One by
    /// default.
    fn scale(&self, row: usize) -> f64 {
        let _ = row;
        1.0
    }

    /// The name of row `row` and its unit, for reports. By default the number of the row, without a unit.
    fn label(&self, row: usize, model: &Model) -> RowLabel {
        let _ = model;
        RowLabel::numbered(row)
    }
}

/// Rows $g_j(t, q, v, a, u) \le 0$ given as a closure over dual numbers, with the number of rows and their scales.
#[derive(Clone)]
pub struct StageRows<F> {
    name: String,
    scales: Vec<f64>,
    value: F,
}

impl<F: Fn(&StageInput<'_, HyperDual64>, &mut [HyperDual64])> StageRows<F> {
    /// Rows computed by `value` into a slice with an entry per scale. A scale is a positive value of its row that is a
    /// bad violation, such as the limit itself. Derivatives come from dual numbers: about $8 N^2$ calls of the closure
    /// per point.
    #[must_use]
    pub fn new(name: &str, scales: Vec<f64>, value: F) -> Self {
        let name = name.to_owned();
        Self { name, scales, value }
    }

    /// Evaluates the closure at time and $y$.
    fn at(&self, t: HyperDual64, y: &[HyperDual64], g: &mut [HyperDual64]) {
        (self.value)(&StageInput::of(t, y), g);
    }

    fn zeros(&self) -> Vec<HyperDual64> {
        vec![HyperDual64::from(0.0); self.scales.len()]
    }
}

impl<F> fmt::Debug for StageRows<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "StageRows({})", self.name)
    }
}

/// Time and $y$ as constants.
pub(crate) fn still(at: &StageInput<'_, f64>) -> (HyperDual64, Vec<HyperDual64>) {
    let parts = [at.q, at.v, at.a, at.u].into_iter().flatten();
    let y = parts.map(|x| HyperDual64::from(*x)).collect();
    (HyperDual64::from(at.t), y)
}

impl<F> StageConstraint for StageRows<F>
where
    F: Fn(&StageInput<'_, HyperDual64>, &mut [HyperDual64]) + Send + Sync,
{
    fn dim(&self) -> usize {
        self.scales.len()
    }

    fn value(&self, at: &StageInput<'_, f64>, g: &mut [f64]) -> Result<()> {
        check_length("g", self.dim(), g.len())?;
        let ((t, y), mut found) = (still(at), self.zeros());
        self.at(t, &y, &mut found);
        for (g, found) in g.iter_mut().zip(found) {
            *g = found.re;
        }
        Ok(())
    }

    fn derivatives(
        &self,
        at: &StageInput<'_, f64>,
        multipliers: &[f64],
        gradients: &mut DMatrix<f64>,
        hessian: &mut DMatrix<f64>,
    ) -> Result<()> {
        let ((t, mut y), mut g) = (still(at), self.zeros());
        for i in 0..y.len() {
            y[i].eps1 = 1.0;
            for j in 0..=i {
                y[j].eps2 = 1.0;
                self.at(t, &y, &mut g);
                y[j].eps2 = 0.0;
                let rows = multipliers.iter().zip(&g);
                let sum: f64 = rows.map(|(multiplier, g)| multiplier * g.eps1eps2).sum();
                hessian[(i, j)] += sum;
                if j < i {
                    hessian[(j, i)] += sum;
                }
            }
            for (row, g) in g.iter().enumerate() {
                gradients[(i, row)] = g.eps1;
            }
            y[i].eps1 = 0.0;
        }
        Ok(())
    }

    fn time_rates(&self, at: &StageInput<'_, f64>, rates: &mut [f64]) -> Result<()> {
        let ((mut t, y), mut g) = (still(at), self.zeros());
        t.eps1 = 1.0;
        self.at(t, &y, &mut g);
        for (rate, g) in rates.iter_mut().zip(g) {
            *rate = g.eps1;
        }
        Ok(())
    }

    fn scale(&self, row: usize) -> f64 {
        self.scales[row]
    }

    fn label(&self, row: usize, _: &Model) -> RowLabel {
        let name = match self.dim() {
            1 => self.name.clone(),
            _ => format!("row {row} of {}", self.name),
        };
        RowLabel { name, ..RowLabel::numbered(row) }
    }
}

/// All constraints on a motion at one time beyond those of state and torque; none by default.
#[derive(Clone, Debug, Default)]
pub struct StageConstraints {
    /// Limits of the acceleration of joints and of its rate.
    pub rates: Vec<RateLimit>,
    /// A foot on which the robot stands, in the first phase if there are several.
    pub foot: Option<StandingFoot>,
    /// The phases, which the direct method alone knows; none for one foot, or none.
    pub phases: Vec<Phase>,
    /// Any other rows.
    pub custom: Vec<Arc<dyn StageConstraint>>,
}

impl StageConstraints {
    /// None.
    pub const NONE: Self = Self { rates: Vec::new(), foot: None, phases: Vec::new(), custom: Vec::new() };

    /// The highest order of a derivative on which a row depends, at least two.
    pub(crate) fn order(&self) -> usize {
        self.rates.iter().map(|rate| rate.order).fold(2, usize::max)
    }

    /// The foot with its first row.
    pub(crate) fn foot(&self) -> Option<(usize, &StandingFoot)> {
        self.foot.as_ref().map(|foot| (self.rates.len(), foot))
    }

    /// The first row of the other constraints.
    fn first_custom_row(&self) -> usize {
        self.rates.len() + self.foot.as_ref().map_or(0, StandingFoot::dim)
    }

    /// The number of rows: one for each limit, then those of the foot, then those of the others.
    #[must_use]
    pub fn dim(&self) -> usize {
        self.first_custom_row() + self.custom.iter().map(|other| other.dim()).sum::<usize>()
    }

    /// The other constraints, each with its first row.
    pub(crate) fn custom_rows(&self) -> impl Iterator<Item = (usize, &dyn StageConstraint)> {
        self.custom.iter().scan(self.first_custom_row(), |next, other| {
            let first = *next;
            *next += other.dim();
            Some((first, &**other))
        })
    }

    /// The scale of each row: limits of acceleration and jerk themselves.
    pub(crate) fn scales(&self) -> Vec<f64> {
        let others = self.custom.iter();
        let others = others.flat_map(|other| (0..other.dim()).map(|row| other.scale(row)));
        let foot = self.foot.iter().flat_map(StandingFoot::scales);
        let rates = self.rates.iter().map(|rate| rate.limit);
        rates.chain(foot).chain(others).collect()
    }

    /// The name of a row and its unit.
    #[must_use]
    pub fn label(&self, row: usize, model: &Model) -> RowLabel {
        let Some(rate) = self.rates.get(row) else {
            if let Some((first, foot)) = self.foot().filter(|_| row < self.first_custom_row()) {
                return foot.label(row - first);
            }
            let other = self.custom_rows().take_while(|(first, _)| *first <= row).last();
            let label = |(first, of): (usize, &dyn StageConstraint)| of.label(row - first, model);
            return other.map_or_else(|| RowLabel::numbered(row), label);
        };
        RowLabel::limit(Quantity::JOINT[rate.order], (rate.joint, Some(rate.side)), row, model)
    }

    /// Refuses any row but those of a foot where it may stand: a flow keeps rows of the state and the torque alone, the
    /// published one those of a foot too.
    pub(crate) fn refuse_in_a_flow(&self, robot: &str, may_stand: bool) -> Result<()> {
        let foot = self.foot.as_ref().filter(|_| may_stand);
        if self.dim() == foot.map_or(0, StandingFoot::dim) {
            return Ok(());
        }
        let condition = "a flow keeps limits of position, velocity and torque, the published one also a foot that \
                         stands, the direct method all";
        Err(Error::input(
            robot,
            "limits of acceleration and jerk, a foot that stands, rows in (t, q, v, a, u)",
            condition,
        ))
    }

    /// Checks the limits for `model`, and the foot.
    ///
    /// # Errors
    /// A limit is not one of acceleration or jerk, of a joint that the robot does not have, or not positive and finite;
    /// the error names the joint. Those of [`StandingFoot::check`].
    pub fn check(&self, model: &Model) -> Result<()> {
        for RateLimit { order, joint, limit, .. } in &self.rates {
            let refuse = |element: &str, condition: String| Err(Error::input(model.name(), element, condition));
            let Some(joint) = model.joints().get(*joint) else {
                return refuse("joints", format!("there is no joint {joint}, whose rate is limited"));
            };
            if !(2..=MAX_ORDER).contains(order) {
                let condition = format!("the order of a derivative is {order} and must be from 2 to {MAX_ORDER}");
                return refuse("limits", condition);
            }
            if !(limit.is_finite() && *limit > 0.0) {
                let element = format!("joint '{}': {} limit", joint.name(), Quantity::JOINT[*order].name());
                return refuse(&element, format!("it is {limit} and must be a positive number"));
            }
        }
        self.foot.as_ref().map_or(Ok(()), StandingFoot::check)
    }
}
