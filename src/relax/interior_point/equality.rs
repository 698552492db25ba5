//! The terms of equalities: an augmented Lagrangian.

use super::barrier::Term;
use super::row::Kind;
use crate::relax::Grid;
use crate::relax::tuning::{
    FIRST_PENALTY, LARGEST_MOTOR, LARGEST_PENALTY, MOTOR, PENALTY_FACTOR, PROGRESS,
};

/// The duals $\lambda_j$ and the penalties $\rho_j$ of the terms $\lambda_j h_j + \tfrac12 \rho_j h_j^2$ of equalities $h_j = 0$.
///
/// A barrier of an equality would have to become as steep as a wall on either side, along which a minimiser creeps; with duals penalties
/// stay moderate. The collocated points have small weights, by which both are larger.
#[derive(Clone, Debug)]
pub struct Equalities {
    /// $\lambda$, row by row for each point; zero where nothing is asked of a row or it is an inequality.
    pub duals: Vec<f64>,
    /// $\rho$ of each row.
    pub penalties: Vec<f64>,
    /// The largest $|h|$ of each row at the update before.
    before: Vec<f64>,
    /// True if a row is the torque of a passive joint.
    passive: Vec<bool>,
}

impl Equalities {
    /// No duals, and penalties of one, for rows of which some are torques of passive joints, at so many points.
    pub(super) fn new(passive: Vec<bool>, points: usize) -> Self {
        Self {
            duals: vec![0.0; passive.len() * points],
            penalties: vec![1.0; passive.len()],
            before: vec![f64::INFINITY; passive.len()],
            passive,
        }
    }

    /// The penalties of rows that nothing is known of, where the cost per second is `density`. A passive joint begins as a motor, since nothing
    /// is as simple as that.
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

    /// Takes known multipliers of rows of these kinds for duals.
    pub(super) fn take(&mut self, known: &[f64], kinds: &[Kind]) {
        for ((dual, known), kind) in self.duals.iter_mut().zip(known).zip(kinds) {
            if *kind == Kind::Equality {
                *dual = *known;
            }
        }
    }

    /// The term of an equality at `at`, of the value `h`.
    pub(super) fn term(&self, at: usize, h: f64) -> Term {
        Term::Dual {
            dual: self.duals[at],
            penalty: self.penalties[at % self.penalties.len()],
            h,
        }
    }

    /// Takes the duals that the rows `h` ask for, and larger penalties for those that are still violated by more than `feasible` and not much
    /// less so than at the update before. `units` is one of each row.
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
