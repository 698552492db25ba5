//! The terms of an augmented Lagrangian for rows of constraints.

use super::{ControlPoint, LagrangianDerivatives, StateGrid, StatePoints};
use crate::constraint::{Constraint, Constraints, Evaluator, Side, Weights};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{LANES, Lanes, Wide};

/// The condition on a row at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The inequality $h \le 0$.
    Inequality,
    /// The equality $h = 0$.
    Equality,
    /// None: an equality between the points at which a polynomial can satisfy it.
    Idle,
}

/// The duals of a row at given times, with its penalty and margin.
#[derive(Clone, Debug)]
pub struct RowDuals {
    /// The penalty of the row.
    pub penalty: f64,
    /// The margin of the row.
    pub margin: f64,
    /// Times with the duals there.
    pub duals: Vec<(f64, f64)>,
}

/// Interpolates known values linearly in time; beyond them the nearest value is used.
fn interpolate(known: &[(f64, f64)], time: f64) -> f64 {
    let after = known.partition_point(|(t, _)| *t < time);
    match (after.checked_sub(1).map(|i| known[i]), known.get(after)) {
        (Some((t0, a)), Some((t1, b))) => a + (b - a) * (time - t0) / (t1 - t0),
        (Some((_, a)), None) => a,
        (None, Some((_, b))) => *b,
        (None, None) => 0.0,
    }
}

/// Rows of constraints with their duals, at the points of a grid.
#[derive(Clone, Debug)]
pub struct RowTerms<'a, K> {
    constraints: &'a Constraints<K>,
    kinds: Vec<Kind>,
    /// The factor of each row.
    scales: Vec<f64>,
    /// One unit of the scaled row: rad, rad/s, m, N m or N.
    pub units: Vec<f64>,
    /// The margin of each row.
    pub margins: Vec<f64>,
    /// The penalty $\rho$ of each row.
    pub penalties: Vec<f64>,
    /// The duals $z$, row by row for each point.
    pub duals: Vec<f64>,
    /// The rows $h$ at the last evaluation, in the same order.
    pub h: Vec<f64>,
    evaluator: Evaluator<'a, f64, Wide<f64>>,
    state: Vec<Wide<f64>>,
    wide: Vec<Wide<f64>>,
    slopes: Vec<Wide<f64>>,
    curvatures: Vec<Wide<f64>>,
}

impl<'a, K: Constraint> RowTerms<'a, K> {
    /// The rows of `constraints`, with all duals zero.
    pub fn new(
        model: &'a Model,
        constraints: &'a Constraints<K>,
        grid: &StateGrid<f64>,
    ) -> Result<Self> {
        let states = constraints.state.dim();
        if constraints.torque.dim() > 0 {
            constraints.torque.check(model)?;
        }
        let [scales, units] = constraints.factors_and_units();
        let count = scales.len();
        let kind = |at: usize| match (
            constraints.is_passive(at % count),
            grid.is_collocated(at / count),
        ) {
            (true, true) => Kind::Equality,
            (true, false) | (false, true) => Kind::Idle,
            (false, false) if constraints.is_equality(at % count) => Kind::Equality,
            (false, false) => Kind::Inequality,
        };
        let all = count * grid.times.len();
        let zero = Wide::splat(0.0);
        Ok(Self {
            constraints,
            kinds: (0..all).map(kind).collect(),
            scales,
            units,
            margins: vec![0.0; count],
            penalties: vec![1.0; count],
            duals: vec![0.0; all],
            h: vec![0.0; all],
            evaluator: Evaluator::new(model),
            state: vec![zero; 4 * model.dof()],
            wide: vec![zero; states],
            slopes: vec![zero; states],
            curvatures: vec![zero; states],
        })
    }

    /// The number of rows.
    pub fn count(&self) -> usize {
        self.scales.len()
    }

    /// Computes $\psi$ and its first two derivatives in $h$ for row `at`.
    pub fn term(&self, at: usize) -> [f64; 3] {
        let (h, z, rho) = (
            self.h[at],
            self.duals[at],
            self.penalties[at % self.count()],
        );
        let pushed = z + rho * h;
        match self.kinds[at] {
            Kind::Equality => [z * h + 0.5 * rho * h * h, pushed, rho],
            Kind::Inequality if pushed > 0.0 => {
                [(pushed * pushed - z * z) / (2.0 * rho), pushed, rho]
            }
            Kind::Inequality => [-z * z / (2.0 * rho), 0.0, 0.0],
            Kind::Idle => [0.0; 3],
        }
    }

    /// Updates the duals, $z \leftarrow \psi'(h)$.
    pub fn update_duals(&mut self) {
        for at in 0..self.h.len() {
            self.duals[at] = self.term(at)[1];
        }
    }

    /// The duals of each row over time, at the points at which it is enforced, and its penalty.
    pub fn over_time(&self, times: &[f64]) -> Vec<RowDuals> {
        let count = self.count();
        let of_row = |row: usize| {
            let held = (0..times.len()).filter(|g| self.kinds[g * count + row] != Kind::Idle);
            RowDuals {
                penalty: self.penalties[row],
                margin: self.margins[row],
                duals: held
                    .map(|g| (times[g], self.duals[g * count + row]))
                    .collect(),
            }
        };
        (0..count).map(of_row).collect()
    }

    /// Sets the duals to those found at other points, interpolated linearly in time.
    pub fn take_over(&mut self, rows: &[RowDuals], times: &[f64]) {
        let count = self.count();
        for (row, known) in rows.iter().enumerate() {
            self.penalties[row] = known.penalty;
            self.margins[row] = known.margin;
            for (g, time) in times.iter().enumerate() {
                if self.kinds[g * count + row] != Kind::Idle {
                    self.duals[g * count + row] = interpolate(&known.duals, *time);
                }
            }
        }
    }

    /// The largest violation of each row at the points, in its unit.
    pub fn largest(&self) -> Vec<f64> {
        let count = self.count();
        let mut largest = vec![0.0_f64; count];
        for (at, h) in self.h.iter().enumerate() {
            let violation = match self.kinds[at] {
                Kind::Inequality => h.max(-self.duals[at] / self.penalties[at % count]),
                Kind::Equality => h.abs(),
                Kind::Idle => 0.0,
            };
            let row = &mut largest[at % count];
            *row = row.max(violation.abs() * self.units[at % count]);
        }
        largest
    }

    /// Evaluates the rows of the state at all points of a segment.
    pub fn place(&mut self, at: StatePoints<'_, f64>) -> Result<()> {
        let (states, count) = (self.constraints.state.dim(), self.count());
        if states == 0 {
            return Ok(());
        }
        let own = 2 * at.dof();
        for start in (0..at.count()).step_by(LANES) {
            let found = Lanes::gather(at.states.as_slice(), start, &mut self.state);
            let placed = self.evaluator.at(&self.state[..own])?;
            placed.value(&self.constraints.state, &mut self.wide)?;
            for lane in 0..found {
                let first = (at.first + start + lane) * count;
                for j in 0..states {
                    self.h[first + j] = self.wide[j].0[lane] * self.scales[j] + self.margins[j];
                }
            }
        }
        Ok(())
    }

    /// Evaluates the rows of the control at a point and adds their terms to `point`.
    pub fn add_control(&mut self, index: usize, point: &mut ControlPoint<f64>) {
        let (states, count) = (self.constraints.state.dim(), self.count());
        let constraints = self.constraints;
        for (row, (i, limit, side)) in (states..).zip(constraints.torque.rows()) {
            let (scale, at) = (self.scales[row], index * count + row);
            let slope = if side == Some(Side::Lower) {
                -scale
            } else {
                scale
            };
            self.h[at] = slope * point.u[i] - scale * limit + self.margins[row];
            let [value, first, second] = self.term(at);
            point.value += value;
            point.slopes[i] += slope * first;
            point.curvatures[i] += slope * slope * second;
        }
    }

    /// The sum of the state terms at a point.
    pub fn state_value(&self, index: usize) -> f64 {
        let first = index * self.count();
        let own = first..first + self.constraints.state.dim();
        own.map(|at| self.term(at)[0]).sum()
    }

    /// Adds the derivatives of the state terms at the points from `start` on, side by side.
    pub fn add_state(
        &mut self,
        at: StatePoints<'_, f64>,
        start: usize,
        out: &mut LagrangianDerivatives<f64>,
    ) -> Result<()> {
        let (states, count, size) = (self.constraints.state.dim(), self.count(), 2 * at.dof());
        let found = Lanes::gather(at.states.as_slice(), start, &mut self.state);
        let mut any = false;
        for j in 0..states {
            for lane in 0..LANES {
                let point = at.first + start + lane.min(found - 1);
                let [_, first, second] = self.term(point * count + j);
                self.slopes[j].0[lane] = first * self.scales[j];
                self.curvatures[j].0[lane] = second * self.scales[j].powi(2);
                any |= first != 0.0 || second != 0.0;
            }
        }
        if !any {
            return Ok(());
        }
        let zeros;
        let first_order = if out.convex {
            zeros = vec![Wide::splat(0.0); states];
            &zeros
        } else {
            &self.slopes
        };
        let state = &self.constraints.state;
        let weights = Weights {
            first_order: &self.slopes,
            gauss_newton: None,
        };
        let pull = self
            .evaluator
            .weighted_derivatives_at(&self.state[..size], state, weights)?;
        for (i, slope) in pull.gradient().iter().enumerate() {
            for lane in 0..found {
                out.gradients[(i, start + lane)] += slope.0[lane];
            }
        }
        let weights = Weights {
            first_order,
            gauss_newton: Some(&self.curvatures),
        };
        let pull = self
            .evaluator
            .weighted_derivatives_at(&self.state[..size], state, weights)?;
        for (i, row) in pull.hessian().row_iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                for lane in 0..found {
                    out.add(start + lane, i, j, entry.0[lane]);
                }
            }
        }
        Ok(())
    }
}
