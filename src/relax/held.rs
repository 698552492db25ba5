//! What holds a curve within its constraints.

use super::ladder::Path;
use crate::motion::Problem;

/// A curve with the multipliers that hold it.
#[derive(Clone, Debug)]
pub(super) struct Held {
    pub path: Path,
    pub times: Vec<f64>,
    pub multipliers: Vec<f64>,
    pub rho: f64,
    pub effort: f64,
    pub violation: f64,
    pub gradient_norm: f64,
    pub smallest_curvature: f64,
    pub points: usize,
    pub quadrature_error: f64,
    pub converged: bool,
}

impl Held {
    /// Nothing holds it yet.
    pub fn free(path: Path) -> Self {
        Self {
            path,
            times: Vec::new(),
            multipliers: Vec::new(),
            rho: 0.0,
            effort: f64::NAN,
            violation: f64::NAN,
            gradient_norm: f64::NAN,
            smallest_curvature: f64::NAN,
            points: 0,
            quadrature_error: f64::NAN,
            converged: false,
        }
    }

    /// The effort, those that are far outside after the others.
    pub fn rank(&self) -> f64 {
        self.effort * (1.0 + 1e3 * (self.violation - 0.01).max(0.0))
    }

    /// The multipliers at other times, interpolated.
    pub fn multipliers_at(&self, times: &[f64], rows: usize) -> Vec<f64> {
        let mut found = vec![0.0; times.len() * rows];
        if self.times.is_empty() {
            return found;
        }
        let last = self.times.len() - 1;
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
                let [x, y] = [a, b].map(|i| self.multipliers[i * rows + row]);
                *to = x + share * (y - x);
            }
        }
        found
    }

    /// The same shape on another horizon, longer by a factor. What held it holds it to begin with if that was of any use; the weight
    /// is another one, since the last rounds may have made it large.
    pub fn on_horizon(&self, problem: &Problem<'_>, factor: f64) -> Self {
        let path = self.path.clone().between_ends_of(problem);
        if !self.converged {
            return Self::free(path);
        }
        Self {
            path,
            times: self.times.iter().map(|t| t * factor).collect(),
            rho: 0.0,
            ..self.clone()
        }
    }
}
