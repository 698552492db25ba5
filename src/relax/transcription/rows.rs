//! The rows of constraints at the points of a curve.

use super::{CostWithControl, Points};
use crate::constraint::{
    Constraint, Constraints, Evaluator, RowKind, WeightedDerivatives, Weights,
};
use crate::error::Result;
use crate::model::Model;
use crate::relax::tuning::FAR;
use crate::scalar::{LANES, Wide};
use nalgebra::DMatrix;

/// The rows of constraints at single points, in their own units and relative to their scales, with the running cost.
#[derive(Debug)]
pub(in crate::relax) struct Rows<'a, K, P> {
    pub constraints: &'a Constraints<K>,
    /// The running cost.
    pub cost: P,
    /// The controls at the points.
    controls: DMatrix<f64>,
    evaluator: Evaluator<'a, f64, Wide<f64>>,
    /// $[q; v; a]$ and the rows of the state at points that are evaluated side by side.
    z: Vec<Wide<f64>>,
    wide: Vec<Wide<f64>>,
    /// The index of each listed row among those of the constraints, ascending.
    pub ids: Vec<usize>,
    /// The number of listed rows of the state; those of the torque follow.
    pub states: usize,
    /// The attributes of all rows, listed or not.
    all: Attributes,
    /// The unlisted rows of the state, and the largest value of one since the last reset.
    unlisted: Vec<usize>,
    pub unlisted_highest: f64,
    /// The attributes of the listed rows.
    of: Attributes,
}

/// The attributes of rows, one entry per row.
#[derive(Clone, Debug, Default)]
pub(in crate::relax) struct Attributes {
    /// The factor of a row, with which a badly violated row is of the order of 0.1.
    pub scales: Vec<f64>,
    /// True if a row is an equality.
    pub equalities: Vec<bool>,
    /// One unit of the scaled row: rad, rad/s, m, N m or N.
    pub units: Vec<f64>,
    /// The value of a scaled row below which its barrier is constant; minus infinity if it never is.
    pub floors: Vec<f64>,
}

// By hand, since a derived `Clone` would require it of the constraints, which are a reference.
impl<K, P: Clone> Clone for Rows<'_, K, P> {
    fn clone(&self) -> Self {
        Self {
            constraints: self.constraints,
            cost: self.cost.clone(),
            controls: self.controls.clone(),
            evaluator: self.evaluator.clone(),
            z: self.z.clone(),
            wide: self.wide.clone(),
            ids: self.ids.clone(),
            states: self.states,
            all: self.all.clone(),
            unlisted: self.unlisted.clone(),
            unlisted_highest: self.unlisted_highest,
            of: self.of.clone(),
        }
    }
}

impl<'a, K: Constraint, P: CostWithControl> Rows<'a, K, P> {
    pub fn new(model: &'a Model, constraints: &'a Constraints<K>, cost: P) -> Result<Self> {
        let Constraints { state, torque } = constraints;
        if torque.dim() > 0 {
            torque.check(model)?;
        }
        let n = model.dof();
        let [scales, units] = constraints.factors_and_units();
        let equalities = (0..scales.len()).map(|row| constraints.is_equality(row));
        let floor = |row| match constraints.label(row, model).kind {
            RowKind::Clearance if !constraints.is_equality(row) => -FAR,
            _ => f64::NEG_INFINITY,
        };
        let all = Attributes {
            floors: (0..scales.len()).map(floor).collect(),
            units,
            equalities: equalities.collect(),
            scales,
        };
        Ok(Self {
            constraints,
            cost,
            controls: DMatrix::zeros(n, 0),
            evaluator: Evaluator::new(model),
            z: vec![Wide::splat(0.0); 3 * n],
            wide: vec![Wide::splat(0.0); state.dim()],
            ids: (0..all.scales.len()).collect(),
            states: state.dim(),
            of: all.clone(),
            all,
            unlisted: Vec::new(),
            unlisted_highest: f64::NEG_INFINITY,
        })
    }

    /// The number of listed rows.
    pub fn count(&self) -> usize {
        self.ids.len()
    }

    /// The attributes of the listed rows.
    pub fn of(&self) -> &Attributes {
        &self.of
    }

    /// The running cost, to be evaluated, and the attributes of the listed rows.
    pub fn cost_and_attributes(&mut self) -> (&mut P, &Attributes) {
        (&mut self.cost, &self.of)
    }

    /// The number of all rows.
    pub fn count_all(&self) -> usize {
        self.all.scales.len()
    }

    /// Lists these rows of the state, ascending, and all of the torque. Only the largest value of the others is
    /// computed.
    pub fn list(&mut self, rows: &[usize]) {
        let states = self.constraints.state.dim();
        let mut listed = vec![false; states];
        for row in rows {
            listed[*row] = true;
        }
        self.unlisted = (0..states).filter(|row| !listed[*row]).collect();
        self.unlisted_highest = f64::NEG_INFINITY;
        self.states = rows.len();
        self.ids = rows
            .iter()
            .copied()
            .chain(states..self.count_all())
            .collect();
        let (ids, all) = (&self.ids, &self.all);
        self.of = Attributes {
            scales: ids.iter().map(|row| all.scales[*row]).collect(),
            equalities: ids.iter().map(|row| all.equalities[*row]).collect(),
            units: ids.iter().map(|row| all.units[*row]).collect(),
            floors: ids.iter().map(|row| all.floors[*row]).collect(),
        };
    }

    /// Computes all rows at all points into `h`, row by row for each point, and the running cost there into `costs`.
    pub fn at(&mut self, points: Points<'_, f64>, h: &mut [f64], costs: &mut [f64]) -> Result<()> {
        self.of_state(points, h)?;
        let torque = &self.constraints.torque;
        if torque.dim() == 0 {
            return self.cost.values(points, costs);
        }
        let (states, count) = (self.states, self.count());
        if self.controls.ncols() < points.count() {
            self.controls = DMatrix::zeros(points.states.nrows(), points.count());
        }
        self.cost
            .values_with_control(points, costs, &mut self.controls)?;
        for (h, u) in h.chunks_exact_mut(count).zip(self.controls.column_iter()) {
            let h = &mut h[states..];
            torque.value(u.as_slice(), h)?;
            for (h, scale) in h.iter_mut().zip(&self.of.scales[states..]) {
                *h *= scale;
            }
        }
        Ok(())
    }

    /// Computes the rows without the running cost, which is skipped if only the state has constraints.
    pub fn of_all(&mut self, points: Points<'_, f64>, h: &mut [f64]) -> Result<()> {
        if self.constraints.torque.dim() > 0 {
            self.at(points, h, &mut vec![0.0; points.count()])
        } else {
            self.of_state(points, h)
        }
    }

    /// Computes the rows of the state alone and leaves those of the control unchanged.
    pub fn of_state(&mut self, points: Points<'_, f64>, h: &mut [f64]) -> Result<()> {
        let (states, count) = (self.states, self.count());
        if self.wide.is_empty() {
            return Ok(());
        }
        let own = 2 * points.states.nrows();
        for start in (0..points.count()).step_by(LANES) {
            let found = points.gather(start, &mut self.z);
            let placed = self.evaluator.at(&self.z[..own])?;
            placed.value(&self.constraints.state, &mut self.wide)?;
            for lane in 0..found {
                let first = (start + lane) * count;
                let h = &mut h[first..first + states];
                for ((h, row), scale) in h.iter_mut().zip(&self.ids).zip(&self.of.scales) {
                    *h = self.wide[*row].0[lane] * scale;
                }
            }
            for row in &self.unlisted {
                let [a, b, c, d] = self.wide[*row].0;
                let highest = a.max(b).max(c.max(d)) * self.all.scales[*row];
                self.unlisted_highest = self.unlisted_highest.max(highest);
            }
        }
        Ok(())
    }

    /// Computes the weighted derivatives of the rows of the state at the points from `start` on, side by side.
    pub fn weighted_derivatives(
        &mut self,
        points: Points<'_, f64>,
        start: usize,
        weights: Weights<'_, Wide<f64>>,
    ) -> Result<&WeightedDerivatives<Wide<f64>>> {
        points.gather(start, &mut self.z);
        let own = 2 * points.states.nrows();
        self.evaluator
            .weighted_derivatives_at(&self.z[..own], &self.constraints.state, weights)
    }
}
