//! The homotopy variable of a flow to rest.

use super::RestRecord;
use crate::nlp::Progress;

/// The size of a Newton step, which is infinite, as a multiple of the largest step before it.
const NEWTON: f64 = 10.0;

/// The homotopy variable $s$, with the work up to it.
///
/// A step of Newton's method with the multiple $1 / h$ of the norm added to the Hessian is one of the implicit Euler
/// method of size $h$, in units of the metric relative to the action.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    s: f64,
    /// The largest step in `s`.
    largest: f64,
    pub steps: usize,
    pub factorisations: usize,
}

impl Default for Clock {
    fn default() -> Self {
        Self { s: 0.0, largest: 1.0, steps: 0, factorisations: 0 }
    }
}

impl Clock {
    /// Counts an iteration on this number of segments of this degree. Returns its record if it made a step.
    pub fn tick(&mut self, progress: &Progress, (segments, degree): (usize, usize)) -> Option<RestRecord> {
        self.factorisations += progress.factorisations;
        if progress.alpha <= 0.0 {
            return None;
        }
        let step = match progress.regularisation {
            0.0 => NEWTON * self.largest,
            multiple => progress.alpha / multiple,
        };
        self.largest = self.largest.max(step);
        self.s += step;
        self.steps += 1;
        Some(RestRecord {
            s: self.s,
            action: progress.objective,
            gradient_norm: progress.stationarity,
            segments,
            degree,
        })
    }
}
