//! The terms of equalities: an augmented Lagrangian.

use super::barrier::Term;
use super::row::Kind;
use crate::relax::Grid;
use crate::relax::tuning::{
    FIRST_PENALTY, LARGEST_MOTOR, LARGEST_PENALTY, MOTOR, PENALTY_FACTOR, PROGRESS,
};

/// The duals $\lambda_j$ and the penalties $\rho_j$ of the terms $\lambda_j h_j + \tfrac12 \rho_j h_j^2$ of equalities
/// $h_j = 0$.
///
/// A barrier of an equality would have to become a steep wall on either side, along which a minimiser makes slow
/// progress; with duals, moderate penalties suffice. The collocated points have small weights, which increases both.
#[derive(Clone, Debug)]
pub struct Equalities {
    /// $\lambda$, row by row for each point; zero for inequalities and idle rows.
    pub duals: Vec<f64>,
    /// $\rho$ of each row.
    pub penalties: Vec<f64>,
    /// The largest $|h|$ of each row at the previous update.
    before: Vec<f64>,
    /// True for the torque of a passive joint.
    passive: Vec<bool>,
}

impl Equalities {
    /// Duals of zero and penalties of one at this number of points. `passive` marks the torques of passive joints.
    pub(super) fn new(passive: Vec<bool>, points: usize) -> Self {
        Self {
            duals: vec![0.0; passive.len() * points],
            penalties: vec![1.0; passive.len()],
            before: vec![f64::INFINITY; passive.len()],
            passive,
        }
    }

    /// Sets the penalties of new rows for a cost per second of `density`. A passive joint starts as a motor, because no
    /// other start is as easy.
    pub(super) fn start(&mut self, density: f64) {
        for (penalty, passive) in self.penalties.iter_mut().zip(&self.passive) {
            let first = if *passive {
                MOTOR
            } else {
                FIRST_PENALTY * density
            };
            *penalty = first / Grid::COLLOCATED;
        }
    }

    /// Uses known multipliers of rows of these kinds as duals.
    pub(super) fn take(&mut self, known: &[f64], kinds: &[Kind]) {
        for ((dual, known), kind) in self.duals.iter_mut().zip(known).zip(kinds) {
            if *kind == Kind::Equality {
                *dual = *known;
            }
        }
    }

    /// The term of the equality at index `at` for its value `h`.
    pub(super) fn term(&self, at: usize, h: f64) -> Term {
        Term::Dual {
            dual: self.duals[at],
            penalty: self.penalties[at % self.penalties.len()],
            h,
        }
    }

    /// Updates the duals for the rows `h`, and increases the penalty of each row that is still violated by more than
    /// `feasible` and hardly less than at the previous update. `units` is the value of one unit per row.
    pub(super) fn update(
        &mut self,
        h: &[f64],
        kinds: &[Kind],
        units: &[f64],
        (feasible, density): (f64, f64),
    ) {
        let count = self.penalties.len();
        let mut largest = vec![0.0_f64; count];
        for (at, (h, kind)) in h.iter().zip(kinds).enumerate() {
            if *kind == Kind::Equality {
                let row = at % count;
                self.duals[at] += self.penalties[row] * h;
                largest[row] = largest[row].max(h.abs());
            }
        }
        for (row, largest) in largest.into_iter().enumerate() {
            let most = if self.passive[row] {
                LARGEST_MOTOR
            } else {
                LARGEST_PENALTY * density
            };
            if largest * units[row] > feasible && largest > PROGRESS * self.before[row] {
                let larger = self.penalties[row] * PENALTY_FACTOR;
                self.penalties[row] = larger.min(most / Grid::COLLOCATED);
            }
            self.before[row] = largest;
        }
    }
}
