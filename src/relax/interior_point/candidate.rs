//! A curve with its multipliers.

use super::row::Kind;
use crate::motion::Path;
use crate::motion::Problem;
use crate::relax::tuning::{FIRST_BARRIER, STRONG_BARRIER};

/// The start or the end of a minimisation.
#[derive(Clone, Debug)]
pub(in crate::relax) struct Candidate {
    pub path: Path,
    pub multipliers: Multipliers,
    /// The initial weight of the barriers of all rows, relative to the cost per second, if nothing else is known.
    pub first_barrier: f64,
    /// The final $\mu$ and $\nu$ of the barriers, relative to the cost per second; `None` before a minimisation.
    pub barrier: Option<[f64; 2]>,
    /// The final $\rho$ of the equalities, relative in the same way; those of inequalities are unused.
    pub penalties: Option<Vec<f64>>,
    /// The integral of the running cost by a quadrature finer than that of the minimisation.
    pub cost: f64,
    /// The largest excess of a row, in its unit; negative in the interior.
    pub violation: f64,
    /// The largest torque of a passive joint between its collocated points, relative to the largest torque.
    pub passive_share: f64,
    pub gradient_norm: f64,
    pub smallest_curvature: f64,
    pub points: usize,
    /// The relative difference between the quadrature and the finer one.
    pub quadrature_error: f64,
    /// The derivative of the cost with respect to the horizon, if requested.
    pub horizon_slope: f64,
    /// True if all convergence criteria are met.
    pub converged: bool,
    /// True if the curve satisfies the constraints but not all other criteria.
    pub kept: bool,
}

/// Multipliers of all rows at given times.
#[derive(Clone, Debug, Default)]
pub(in crate::relax) struct Multipliers {
    pub times: Vec<f64>,
    /// The multipliers, row by row for each time.
    pub values: Vec<f64>,
}

impl Candidate {
    /// An untested curve.
    pub fn new(path: Path) -> Self {
        Self {
            path,
            multipliers: Multipliers::default(),
            first_barrier: FIRST_BARRIER,
            barrier: None,
            penalties: None,
            cost: f64::NAN,
            violation: f64::NAN,
            passive_share: 0.0,
            gradient_norm: f64::NAN,
            smallest_curvature: f64::NAN,
            points: 0,
            quadrature_error: f64::NAN,
            horizon_slope: f64::NAN,
            converged: false,
            kept: false,
        }
    }

    /// The same shape on a horizon scaled by `factor`. Warm start: keeps the multipliers if the candidate was nearly
    /// feasible.
    pub fn on_horizon(&self, problem: &Problem<'_>, factor: f64) -> Self {
        let path = self.path.clone().between_ends_of(problem);
        let mut moved = match self.converged {
            true => self.clone(),
            false => Self::new(self.path.clone()),
        };
        moved.path = path;
        moved.first_barrier = STRONG_BARRIER;
        for time in &mut moved.multipliers.times {
            *time *= factor;
        }
        moved
    }
}

impl Multipliers {
    /// The multipliers of rows of these kinds, row by row for each time. The multiplier of an idle row is interpolated
    /// between the neighbouring times at which the row is not idle.
    pub(super) fn new(times: &[f64], values: &[f64], kinds: &[Kind]) -> Self {
        let rows = values.len() / times.len().max(1);
        let (times, mut values) = (times.to_vec(), values.to_vec());
        for row in 0..rows {
            let idle = |g: &usize| kinds[g * rows + row] == Kind::Idle;
            let (without, with): (Vec<usize>, Vec<usize>) = (0..times.len()).partition(idle);
            if without.is_empty() {
                continue;
            }
            let held = Self {
                times: with.iter().map(|g| times[*g]).collect(),
                values: with.iter().map(|g| values[g * rows + row]).collect(),
            };
            for g in without {
                let between = held.at(&times[g..=g], 1);
                values[g * rows + row] = between.map_or(0.0, |z| z[0]);
            }
        }
        Self { times, values }
    }

    /// The multipliers at other times, interpolated linearly; `None` without multipliers.
    pub fn at(&self, times: &[f64], rows: usize) -> Option<Vec<f64>> {
        let last = self.times.len().checked_sub(1)?;
        let mut found = vec![0.0; times.len() * rows];
        for (time, to) in times.iter().zip(found.chunks_exact_mut(rows.max(1))) {
            let after = self.times.partition_point(|t| t < time);
            let (a, b) = (after.saturating_sub(1), after.min(last));
            let span = self.times[b] - self.times[a];
            let share = if span > 0.0 {
                (time - self.times[a]) / span
            } else {
                0.0
            };
            for (row, to) in to.iter_mut().enumerate() {
                let [x, y] = [a, b].map(|i| self.values[i * rows + row]);
                *to = x + share * (y - x);
            }
        }
        Some(found)
    }
}
