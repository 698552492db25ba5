//! The times that the parts of a step take.

use std::time::{Duration, Instant};

/// The shares of the latest time in an estimate, if that time is shorter and if it is longer: a late step is worse than
/// one without an iteration.
const SHARES: [f64; 2] = [0.05, 0.5];
/// The largest factor by which a time counts above its estimate, so that a single interruption by the system has a
/// small effect.
const MAX_FACTOR: f64 = 2.0;
/// The time that has to be left relative to an estimate: one in a hundred steps takes 1.5 times as long as its estimate
/// on a virtual machine.
const MARGIN: f64 = 1.25;
/// The factor of all estimates after a step without an iteration, so that times under a load are forgotten.
const FORGET: f64 = 0.99;

/// The times of the parts of a step, s; NaN for one that is not known.
#[derive(Clone, Copy)]
pub(super) struct Times {
    pub preparation: f64,
    pub iteration: f64,
    pub look: f64,
}

/// The estimated times of the parts of a step, and the time at which it has to end.
pub(super) struct Pace {
    /// Those of a step in known constraints, and of the first one in others.
    times: [Times; 2],
    /// True until the first iteration with new constraints, which determines the rows that are near.
    pub is_first: bool,
    end: Option<Instant>,
}

impl Pace {
    /// No estimates and no end.
    pub fn unknown() -> Self {
        let unknown = Times { preparation: f64::NAN, iteration: f64::NAN, look: f64::NAN };
        Self { times: [unknown; 2], is_first: true, end: None }
    }

    /// The estimates for this step.
    pub fn times(&mut self) -> &mut Times {
        &mut self.times[usize::from(self.is_first)]
    }

    /// Begins a step.
    pub fn begin(&mut self, deadline: Option<Duration>) {
        self.end = deadline.map(|deadline| Instant::now() + deadline);
    }

    /// Returns true if more than this time, s, is left; any is enough if it is not known.
    pub fn fits(&self, time: f64) -> bool {
        let left = |end: Instant| end.saturating_duration_since(Instant::now());
        (self.end).is_none_or(|end| left(end).as_secs_f64() > MARGIN * time.max(0.0))
    }

    /// Lowers the estimates for this step a little.
    pub fn forget(&mut self) {
        let times = self.times();
        for time in [&mut times.preparation, &mut times.iteration, &mut times.look] {
            *time *= FORGET;
        }
    }
}

/// Moves an estimate towards a time, s; the first time is the estimate.
pub(super) fn learn(estimate: &mut f64, time: f64) {
    if estimate.is_nan() {
        *estimate = time;
    }
    let by = time.min(MAX_FACTOR * *estimate) - *estimate;
    *estimate += SHARES[usize::from(by > 0.0)] * by;
}
