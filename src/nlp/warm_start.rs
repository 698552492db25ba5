//! Starts with known multipliers.
//!
//! The barrier parameter begins at the error of the conditions of optimality, so that a solution is found again at once
//! and a search after a small change is short (Nocedal and Wright, *Numerical Optimization*, 19.3).

use super::{Nlp, Options, Row, State, Tightened};
use crate::error::Result;

impl State {
    /// The change of the objective, relative to it, that the distances of the rows from their bounds predict to first
    /// order with known multipliers.
    fn change(&self, known: &[f64], penalty: f64) -> f64 {
        let term = |row: &Row| {
            let (h, z) = (self.h[row.at], known.get(row.at).map_or(0.0, |z| z.abs()));
            row.weight * (z * h.abs()).max(penalty * row.violation(h))
        };
        self.measure * self.rows.iter().map(term).sum::<f64>() / self.scale()
    }

    /// Returns true if the start with known multipliers is a solution: if the errors of stationarity, feasibility and
    /// complementarity are within the tolerances. Otherwise the barrier parameter is that of the last of these errors.
    pub(super) fn is_solution<P: Nlp>(&mut self, problem: &mut P, options: &Options) -> Result<bool> {
        let known = self.known.as_ref().filter(|_| options.min_warm_barrier < options.warm_barrier);
        let Some(known) = known else {
            return Ok(false);
        };
        let change = self.change(known, self.iterate.barrier.nu);
        if change <= options.tolerance && self.has_kkt_point(problem, options)? {
            return Ok(true);
        }
        self.set_first_barrier(change.clamp(options.min_warm_barrier, options.warm_barrier), options);
        Ok(false)
    }

    /// Returns true if the Newton decrement with the gradient of the Lagrangian is within the tolerance, without a
    /// multiple of the norm, and the rows are kept, between the points too.
    fn has_kkt_point<P: Nlp>(&mut self, problem: &mut P, options: &Options) -> Result<bool> {
        self.iterate.is_lagrangian = true;
        let derived = self.derive(problem);
        self.iterate.is_lagrangian = false;
        derived?;
        self.iterations = 0;
        let Some(step) = self.kkt.step(self.scale(), &mut self.progress, options) else {
            return Ok(false);
        };
        self.kkt.reuse(step);
        let is_minimum = self.progress.regularisation == 0.0 && self.progress.stationarity <= options.tolerance;
        Ok(is_minimum && self.is_kept(problem, options)?)
    }

    /// Returns true if the rows are kept between the points too.
    fn is_kept<P: Nlp>(&mut self, problem: &mut P, options: &Options) -> Result<bool> {
        let found = problem.tighten(&self.x, &mut self.h, 1)?;
        let is_kept = match found {
            Tightened::Violation(violation) => violation <= options.feasible,
            Tightened::Beyond | Tightened::QuadratureTooCoarse => false,
        };
        self.reset(problem, options)?;
        Ok(is_kept)
    }

    /// Raises the first barrier parameter with known multipliers, once, if the first step predicts a larger decrease
    /// than it allows; returns true if it does.
    pub(super) fn raise_first_barrier(&mut self, options: &Options) -> bool {
        let decrease = 0.5 * self.progress.stationarity.powi(2);
        let first = decrease.min(options.warm_barrier);
        let is_first = self.iterations == 1 && self.known.is_some() && !self.iterate.working.is_empty();
        let raises = is_first && first > 1.1 * self.complementarity();
        if raises {
            self.set_first_barrier(first, options);
        }
        raises
    }
}
