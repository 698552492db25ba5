//! The times that the parts of a step take.

use std::time::{Duration, Instant};

/// The shares of the latest time in an estimate, if it is shorter and if it is longer: a late step is worse than one
/// without an iteration.
const SHARES: [f64; 2] = [0.05, 0.5];
/// The largest factor by which a time counts above its estimate, so that one interruption by the system is no rule.
const MOST: f64 = 2.0;
/// The factor of all estimates after a step without an iteration, so that times under a load are forgotten.
const FORGET: f64 = 0.99;

/// The estimated times of the parts of a step, s, and the time at which it has to end.
pub(super) struct Pace {
    pub preparation: f64,
    pub iteration: f64,
    pub look: f64,
    end: Option<Instant>,
}

impl Pace {
    /// Without estimates and without an end.
    pub fn unknown() -> Self {
        Self {
            preparation: f64::NAN,
            iteration: f64::NAN,
            look: f64::NAN,
            end: None,
        }
    }

    /// Begins a step.
    pub fn begin(&mut self, deadline: Option<Duration>) {
        self.end = deadline.map(|deadline| Instant::now() + deadline);
    }

    /// Returns true if this time, s, is left.
    pub fn fits(&self, time: f64) -> bool {
        let left = |end: Instant| end.saturating_duration_since(Instant::now());
        self.end.is_none_or(|end| left(end).as_secs_f64() >= time)
    }

    /// Lowers all estimates a little.
    pub fn forget(&mut self) {
        for time in [&mut self.preparation, &mut self.iteration, &mut self.look] {
            *time *= FORGET;
        }
    }
}

/// Moves an estimate towards a time, s; the first time is the estimate.
pub(super) fn learn(estimate: &mut f64, time: f64) {
    if estimate.is_nan() {
        *estimate = time;
    }
    let by = time.min(MOST * *estimate) - *estimate;
    *estimate += SHARES[usize::from(by > 0.0)] * by;
}
