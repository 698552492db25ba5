//! Limits on the torque of each joint, and the set of all constraints of a motion.

use super::{Constraint, Quantity, RowForm, RowLabel, Side, StageConstraints};
use crate::error::{Error, Result, check_length};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};

/// Limits $|u_i| \le \bar u_i$, in N m or N; `None` for a joint without a limit, and zero for a passive joint.
///
/// A limit is two linear rows, $u_i - \bar u_i$ and $-u_i - \bar u_i$, and not one in $u_i^2 - \bar u_i^2$: the slope
/// of a linear row in the excess is one for every joint, whereas that of the square is $2 \bar u_i$, so that a weight
/// would act differently on a strong and on a weak joint. A limit of zero is one row, the equality $u_i = 0$: two
/// opposite inequalities would have no interior and linearly dependent gradients.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueLimits<C: Scalar = f64>(pub Vec<Option<C>>);

impl<C: Scalar> TorqueLimits<C> {
    /// The finite effort limits of the joints.
    #[must_use]
    pub fn of(model: &Model<C>) -> Self {
        let efforts = model.joints().iter().map(|joint| joint.limits().effort);
        Self(efforts.map(|effort| effort.is_finite().then(|| C::from_f64(effort))).collect())
    }

    /// The joint, the limit and the bounded side of each row; `None` for the equality of a passive joint.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (usize, C, Option<Side>)> {
        let limited = self.0.iter().enumerate();
        let limited = limited.filter_map(|(i, limit)| limit.map(|limit| (i, limit)));
        limited.flat_map(|(i, limit)| {
            let sides: &[Option<Side>] =
                if limit.is_zero() { &[None] } else { &[Some(Side::Upper), Some(Side::Lower)] };
            sides.iter().map(move |side| (i, limit, *side))
        })
    }

    /// Returns true if a joint is passive, that is, if its limit is zero.
    #[must_use]
    pub fn is_passive(&self, joint: usize) -> bool {
        let limit = self.0.get(joint).copied().flatten();
        limit.is_some_and(|limit| limit.is_zero())
    }

    /// Returns true if any joint is passive.
    #[must_use]
    pub fn has_passive(&self) -> bool {
        (0..self.0.len()).any(|joint| self.is_passive(joint))
    }

    /// The number of rows: two for each limit, one for each passive joint.
    #[must_use]
    pub fn dim(&self) -> usize {
        self.rows().count()
    }

    /// Computes the rows $u_i - \bar u_i$ and $-u_i - \bar u_i$ for each limit, or $u_i$ for a passive joint, into `g`,
    /// [`dim`](Self::dim) entries. `u` has one entry per joint.
    ///
    /// # Errors
    /// `u` does not have one entry per joint, or `g` not [`dim`](Self::dim) entries.
    pub fn value<S: AlgebraOver<C>>(&self, u: &[S], g: &mut [S]) -> Result<()> {
        check_length("u", self.0.len(), u.len())?;
        check_length("g", self.dim(), g.len())?;
        for ((i, limit, side), g) in self.rows().zip(g) {
            *g = match side {
                None => u[i],
                Some(Side::Upper) => u[i] - S::lift(limit),
                Some(Side::Lower) => -u[i] - S::lift(limit),
            };
        }
        Ok(())
    }

    /// Returns true if a row is the equality $u_i = 0$ of a passive joint.
    #[must_use]
    pub fn is_equality(&self, row: usize) -> bool {
        self.rows().nth(row).is_some_and(|(.., side)| side.is_none())
    }

    /// The name of a row and its unit, N m or N.
    #[must_use]
    pub fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        match self.rows().nth(row) {
            Some((joint, _, side)) => {
                let quantity = if side.is_some() { Quantity::Torque } else { Quantity::Passive };
                RowLabel::limit(quantity, (joint, side), row, model)
            }
            None => RowLabel::numbered(row),
        }
    }
}

/// All constraints of a motion, at every time.
#[derive(Clone, Debug)]
pub struct Constraints<K, C: Scalar = f64> {
    /// Constraints on $x = [q; v]$.
    pub state: K,
    /// Limits on $u$; no entries if there are none.
    pub torque: TorqueLimits<C>,
    /// Limits of acceleration and jerk, a standing foot, and rows in $(t, q, v, a, u)$, which the
    /// [direct method](crate::direct) keeps.
    pub stage: StageConstraints,
}

/// No constraints.
pub(crate) static NONE: Constraints<()> =
    Constraints { state: (), torque: TorqueLimits(Vec::new()), stage: StageConstraints::NONE };

impl<K: Constraint<C>, C: Scalar> Constraints<K, C> {
    /// The number of rows at each time: those of the state, then those of the control, then those of the stage.
    #[must_use]
    pub fn dim(&self) -> usize {
        self.first_of_stage() + self.stage.dim()
    }

    /// The number of rows of the state and the control.
    pub(crate) fn first_of_stage(&self) -> usize {
        self.state.dim() + self.torque.dim()
    }

    /// The scales of all rows, [`dim`](Self::dim) entries: those of the [state](super::RowSet::scale), then one for
    /// each row of the torque, which is in N m or N, and of the stage.
    #[must_use]
    pub fn row_scales(&self) -> Vec<C> {
        let mut scales = self.state.row_scales();
        scales.resize(self.dim(), C::one());
        scales
    }

    /// Returns true if a row is an equality; see [`RowSet::is_equality`](super::RowSet::is_equality).
    #[must_use]
    pub fn is_equality(&self, row: usize) -> bool {
        match row.checked_sub(self.state.dim()) {
            None => self.state.row_set(row).is_equality,
            Some(row) => self.torque.is_equality(row),
        }
    }
}

impl<K: Constraint> Constraints<K> {
    /// The name of a row and its unit; see [`Constraint::label`].
    #[must_use]
    pub fn label(&self, row: usize, model: &Model) -> RowLabel {
        if let Some(row) = row.checked_sub(self.first_of_stage()) {
            return self.stage.label(row, model);
        }
        match row.checked_sub(self.state.dim()) {
            None => self.state.label(row, model),
            Some(row) => self.torque.label(row, model),
        }
    }

    /// The excess of the quantity that a row limits over its bound, in the unit of the label, negative within, for a
    /// [violation](crate::motion::Violation) of the row.
    #[must_use]
    pub fn excess(&self, row: usize, by: f64, model: &Model) -> f64 {
        let form = self.label(row, model).form;
        if form == RowForm::Linear {
            return by;
        }
        match row.checked_sub(self.first_of_stage()) {
            None => form.excess(by, self.row_scales()[row]),
            // Rows of the stage are not divided by their scales.
            Some(row) => {
                let scale = self.stage.scales()[row];
                form.excess(by / scale, scale)
            }
        }
    }

    fn check_scales(&self, model: &Model) -> Result<()> {
        let scales = self.stage.scales().into_iter().enumerate();
        for (row, scale) in scales {
            if !(scale > 0.0 && scale.is_finite()) {
                let RowLabel { name, .. } = self.stage.label(row, model);
                let condition = format!("it is {scale} and must be a positive number");
                return Err(Error::input("constraints", format!("scale of {name}"), condition));
            }
        }
        Ok(())
    }

    /// Checks the limits of torque, acceleration and jerk for `model`, and the scales of rows of the stage.
    ///
    /// # Errors
    /// Those of [`TorqueLimits::check`] and [`StageConstraints::check`], or a scale is not positive and finite.
    pub fn check(&self, model: &Model) -> Result<()> {
        if self.torque.dim() > 0 {
            self.torque.check(model)?;
        }
        self.stage.check(model)?;
        self.check_scales(model)?;
        let StageConstraints { foot, phases, .. } = &self.stage;
        let refuse = |condition: &str| Err(Error::input("constraints", "phases", condition));
        if !phases.is_empty() && self.torque.has_passive() {
            return refuse("a joint is passive, whose torque differs from phase to phase");
        }
        for phase in phases {
            let Some(foot) = foot else {
                return refuse("no foot stands");
            };
            phase.check(model, self.state.dim(), foot)?;
            if phase.rows.clone().any(|row| self.state.row_set(row).is_equality) {
                return refuse("a row that is kept in one of them is an equality");
            }
        }
        Ok(())
    }

    /// The factor of each row, with which a badly violated row is of the order of 0.1, and one unit of the scaled row
    /// in the unit of its label. A torque is scaled by its limit, that of a passive joint by one.
    pub(crate) fn factors_and_units(&self) -> [Vec<f64>; 2] {
        let mut scales = self.row_scales();
        let mut units = vec![1.0; scales.len()];
        for (row, (_, limit, _)) in (self.state.dim()..).zip(self.torque.rows()) {
            if limit > 0.0 {
                (scales[row], units[row]) = (limit, limit);
            }
        }
        for (row, scale) in (self.first_of_stage()..).zip(self.stage.scales()) {
            (scales[row], units[row]) = (scale, scale);
        }
        [scales.into_iter().map(f64::recip).collect(), units]
    }
}

impl TorqueLimits {
    /// Checks the limits for `model`.
    ///
    /// # Errors
    /// The number of entries is not the number of joints, or a limit is negative or not finite; the error names the
    /// joint.
    pub fn check(&self, model: &Model) -> Result<()> {
        check_length("torque limits", model.dof(), self.0.len())?;
        for (joint, limit) in model.joints().iter().zip(&self.0) {
            if let Some(limit) = limit.filter(|limit| !(limit.is_finite() && *limit >= 0.0)) {
                let element = format!("joint '{}': torque limit", joint.name());
                let condition = format!("it is {limit} and must be zero or a positive number");
                return Err(Error::input(model.name(), element, condition));
            }
        }
        Ok(())
    }
}
