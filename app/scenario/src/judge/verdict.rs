//! The judgement of a trajectory, check by check.

use crate::{Promise, Quantity, Scope, promise_in_words};
use serde::{Serialize, Serializer};
use std::fmt;

/// The accepted deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tolerances {
    /// The accepted deviation of everything but clearances: absolute for rad, m, rad/s, m/s, rad/s^2, m/s^2 and s;
    /// relative to the largest torque or force of the motion for torques and forces, to the largest power for powers.
    pub tolerance: f64,
    /// The accepted depth of a ball in an obstacle or another ball, m. Clearances are proved to within a tenth of it.
    pub overlap_m: f64,
}

impl Default for Tolerances {
    /// One thousandth, about the tracking accuracy of a good arm; and a tenth of a millimetre.
    fn default() -> Self {
        Self { tolerance: 1e-3, overlap_m: 1e-4 }
    }
}

/// The verdict on a trajectory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It keeps everything that the scenario promises.
    Valid,
    /// No check fails, and some promises of the scenario are not checked.
    ValidInPart,
    /// A check fails or is undecided.
    NotValid,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Valid => "valid",
            Self::ValidInPart => "valid in part",
            Self::NotValid => "not valid",
        })
    }
}

/// The judgement of a trajectory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// True if all of it is valid.
    pub valid: bool,
    /// The scenario.
    pub scenario: String,
    /// The number of samples of the trajectory.
    pub samples: usize,
    /// The time from the first to the last sample, s.
    pub duration_s: f64,
    /// The motion between samples that the table means, in words.
    pub between_samples: String,
    /// The accepted deviations.
    pub tolerances: Tolerances,
    /// The checks.
    pub checks: Vec<Row>,
}

impl Judgement {
    /// The check that fails or is undecided with the largest excess as a multiple of its tolerance; `None` if the
    /// trajectory is valid, at least in part.
    #[must_use]
    pub fn worst(&self) -> Option<&Row> {
        let failed = self.checks.iter().filter(|row| !row.outcome.is_good());
        failed.max_by(|a, b| a.severity().total_cmp(&b.severity()))
    }
}

/// The result of a kind of check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The kind of check.
    pub check: Check,
    /// The outcome.
    pub outcome: Outcome,
    /// The worst place; `None` if nothing was checked. The value is one that the motion has; if the check is passed,
    /// all others are within the bounds and the tolerance.
    #[serde(flatten)]
    pub worst: Option<Worst>,
    /// The accepted excess over the bound, in the unit of `worst`.
    pub tolerance: f64,
    /// For clearances: the proved lower bound at all times, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proved_at_least: Option<f64>,
    /// A remark in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// The place that is nearest to its bound, or farthest beyond it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// The value.
    pub value: f64,
    /// The lower bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    /// The upper bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    /// The unit of these.
    pub unit: &'static str,
    /// The time after the start, s.
    pub at_s: f64,
    /// The joint, or the names of the closest pair.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
}

impl Worst {
    /// A value between two bounds, each of which may be infinite.
    pub(super) fn between(value: f64, [least, most]: [f64; 2], unit: &'static str, at_s: f64) -> Self {
        Self {
            value,
            at_least: least.is_finite().then_some(least),
            at_most: most.is_finite().then_some(most),
            unit,
            at_s,
            place: None,
        }
    }

    /// The excess over a bound, negative within; infinite if the value is NaN.
    fn excess(&self) -> f64 {
        let below = self.at_least.map(|least| least - self.value);
        let above = self.at_most.map(|most| self.value - most);
        let excess = [below, above].into_iter().flatten();
        let excess = excess.fold(f64::NEG_INFINITY, f64::max);
        if self.value.is_nan() { f64::INFINITY } else { excess }
    }
}

/// The outcome of a check, in the order of severity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The scenario, or the table, has no such condition.
    NotApplicable,
    /// The condition is satisfied.
    Pass,
    /// The condition is not checked, because the table does not determine its quantity or the judge cannot evaluate it.
    NotChecked,
    /// The condition could be neither proved nor refuted.
    Undecided,
    /// The condition is violated.
    Fail,
}

impl Outcome {
    /// Returns true if the outcome is compatible with a trajectory that is valid, at least in part.
    #[must_use]
    pub fn is_good(self) -> bool {
        self <= Self::NotChecked
    }
}

/// The kinds of checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// The first positions.
    StartPosition,
    /// The first velocities.
    StartVelocity,
    /// The last positions.
    GoalPosition,
    /// The last velocities.
    GoalVelocity,
    /// Continuous accelerations that are zero at rest.
    Continuity,
    /// Velocities as rates of positions.
    VelocityIsRate,
    /// Accelerations as rates of velocities.
    AccelerationIsRate,
    /// Torques as those of inverse dynamics.
    Dynamics,
    /// Points on the way.
    Waypoints,
    /// The bounds of a quantity along the way.
    Bounds(Quantity),
}

impl Check {
    /// The check of a promise.
    pub(super) fn of(promise: &Promise) -> Self {
        match (promise.scope, promise.quantity) {
            (Scope::Waypoint(_), _) => Self::Waypoints,
            (Scope::Start, Quantity::Velocity) => Self::StartVelocity,
            (Scope::Start, _) => Self::StartPosition,
            (Scope::Goal, Quantity::Duration) => Self::Bounds(Quantity::Duration),
            (Scope::Goal, Quantity::Velocity) => Self::GoalVelocity,
            (Scope::Goal, _) => Self::GoalPosition,
            (Scope::Between(_), Quantity::Acceleration) if promise.index.is_none() => Self::Continuity,
            (Scope::Between(_), quantity) => Self::Bounds(quantity),
        }
    }

    /// The name of the check for readers; that in JSON has underscores.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::StartPosition => "start position",
            Self::StartVelocity => "start velocity",
            Self::GoalPosition => "goal position",
            Self::GoalVelocity => "goal velocity",
            Self::Continuity => "continuity",
            Self::VelocityIsRate => "velocity is rate",
            Self::AccelerationIsRate => "acceleration is rate",
            Self::Dynamics => "dynamics",
            Self::Waypoints => "waypoints",
            Self::Bounds(of) => promise_in_words(of),
        }
    }
}

impl Serialize for Check {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&self.name().replace([' ', '-'], "_"))
    }
}

impl Row {
    /// The row of distances from which margins were subtracted: `kept` from the worst, and at least `least` from all.
    pub(super) fn beyond(mut self, kept: f64, least: f64) -> Self {
        if let Some(worst) = &mut self.worst {
            worst.value += kept;
            worst.at_least = worst.at_least.map(|bound| bound + kept);
        }
        self.proved_at_least = self.proved_at_least.map(|proved| proved + least);
        self
    }

    /// A check without a value yet.
    pub(super) fn new(check: Check, tolerance: f64) -> Self {
        Self { check, outcome: Outcome::NotApplicable, worst: None, tolerance, proved_at_least: None, note: None }
    }

    /// A check without a value, with the reason.
    pub(super) fn without_value(check: Check, tolerance: f64, outcome: Outcome, note: &str) -> Self {
        Self { outcome, note: Some(note.to_owned()), ..Self::new(check, tolerance) }
    }

    /// The worst excess as a multiple of the tolerance.
    fn severity(&self) -> f64 {
        let excess = self.worst.as_ref().map_or(0.0, Worst::excess);
        excess / self.tolerance.max(f64::MIN_POSITIVE)
    }

    /// Updates the worst value; `place` names its place.
    pub(super) fn take(&mut self, found: Worst, place: impl FnOnce() -> String) {
        self.take_within(found, 0.0, place);
    }

    /// The same with a value that may be off by `error`: the row fails if the value is beyond the tolerance for all of
    /// it.
    pub(super) fn take_within(&mut self, found: Worst, error: f64, place: impl FnOnce() -> String) {
        let excess = found.excess();
        let fails = excess - error > self.tolerance;
        let outcome = if fails { Outcome::Fail } else { Outcome::Pass };
        // The worst of a row that fails is one of those that fail.
        let more_severe = fails && self.outcome < Outcome::Fail;
        let less_severe = !fails && self.outcome == Outcome::Fail;
        let worse = |worst: &Worst| excess > worst.excess() && !less_severe;
        if more_severe || self.worst.as_ref().is_none_or(worse) {
            self.worst = Some(Worst { place: Some(place()), ..found });
        }
        self.outcome = self.outcome.max(outcome);
    }

    /// Notes that nothing is proved at a time after the start, which is due to derived rates or to the limit of work.
    pub(super) fn leave(&mut self, derived: bool, at_s: f64) {
        let (outcome, note) = if derived {
            (Outcome::NotChecked, format!("the positions alone do not determine it at {at_s:.4} s"))
        } else {
            (Outcome::Undecided, format!("not proved at {at_s:.4} s"))
        };
        if outcome > self.outcome {
            (self.outcome, self.note) = (outcome, Some(note));
        }
    }
}
