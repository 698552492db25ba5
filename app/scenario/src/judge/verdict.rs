//! The judgement of a trajectory, check by check.

use crate::Verdict;
use serde::Serialize;

/// The accepted deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tolerances {
    /// The accepted deviation of everything but clearances: absolute for rad, m, rad/s, m/s, rad/s^2, m/s^2 and s;
    /// relative to the largest torque or force of the motion for torques and forces.
    pub tolerance: f64,
    /// The accepted depth of a ball in an obstacle or another ball, m. Clearances are proved to within a tenth of it.
    pub overlap_m: f64,
}

impl Default for Tolerances {
    /// One thousandth, about the tracking accuracy of a good arm; and a tenth of a millimetre.
    fn default() -> Self {
        Self {
            tolerance: 1e-3,
            overlap_m: 1e-4,
        }
    }
}

/// The judgement of a trajectory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// Valid if no check fails or is undecided, otherwise not valid.
    pub verdict: Verdict,
    /// True if it is valid.
    pub valid: bool,
    /// The scenario.
    pub scenario: String,
    /// The number of samples of the trajectory.
    pub samples: usize,
    /// The time from the first to the last sample, s.
    pub duration_s: f64,
    /// The assumed motion between samples, in words.
    pub between_samples: &'static str,
    /// The quantities that were derived because the table lacks them, in words.
    pub derived: Vec<&'static str>,
    /// The accepted deviations.
    pub tolerances: Tolerances,
    /// The checks.
    pub checks: Vec<Row>,
}

impl Judgement {
    /// The check that fails or is undecided with the largest excess as a multiple of its tolerance; `None` if the
    /// trajectory is valid.
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
    /// The worst place; `None` if nothing was checked.
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
    pub(super) fn between(
        value: f64,
        [least, most]: [f64; 2],
        unit: &'static str,
        at_s: f64,
    ) -> Self {
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
        if self.value.is_nan() {
            f64::INFINITY
        } else {
            excess
        }
    }
}

/// The outcome of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The condition is satisfied.
    Pass,
    /// The condition is violated.
    Fail,
    /// The condition could be neither proved nor refuted.
    Undecided,
    /// The condition does not apply.
    NotChecked,
}

impl Outcome {
    /// Returns true if the outcome is compatible with a valid trajectory.
    #[must_use]
    pub fn is_good(self) -> bool {
        matches!(self, Self::Pass | Self::NotChecked)
    }
}

/// The kinds of checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Check {
    /// The duration against the horizon.
    Horizon,
    /// The first positions.
    StartPosition,
    /// The first velocities.
    StartVelocity,
    /// The last positions.
    GoalPosition,
    /// The last velocities.
    GoalVelocity,
    /// Velocities as rates of positions.
    VelocityIsRate,
    /// Accelerations as rates of velocities.
    AccelerationIsRate,
    /// Torques as those of inverse dynamics.
    Dynamics,
    /// The torques of joints without a motor.
    PassiveJoints,
    /// Limits of positions.
    PositionLimits,
    /// Limits of velocities.
    VelocityLimits,
    /// Limits of torques.
    TorqueLimits,
    /// Limits of accelerations.
    AccelerationLimits,
    /// Limits of the rates of accelerations.
    JerkLimits,
    /// Conditions along the way.
    Kept,
    /// Points on the way.
    Waypoints,
    /// The force of the ground on a standing foot.
    Foot,
    /// Clearances from obstacles.
    Obstacles,
    /// Clearances between links.
    SelfCollision,
}

impl Check {
    /// The name of the check for readers.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Horizon => "horizon",
            Self::StartPosition => "start position",
            Self::StartVelocity => "start velocity",
            Self::GoalPosition => "goal position",
            Self::GoalVelocity => "goal velocity",
            Self::VelocityIsRate => "v is the rate of q",
            Self::AccelerationIsRate => "a is the rate of v",
            Self::Dynamics => "u is inverse dynamics",
            Self::PassiveJoints => "passive joints",
            Self::AccelerationLimits => "acceleration limits",
            Self::JerkLimits => "jerk limits",
            Self::PositionLimits => "position limits",
            Self::VelocityLimits => "velocity limits",
            Self::TorqueLimits => "torque limits",
            Self::Kept => "kept along the way",
            Self::Waypoints => "waypoints",
            Self::Foot => "standing foot",
            Self::Obstacles => "obstacles",
            Self::SelfCollision => "self-collision",
        }
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
        Self {
            check,
            outcome: Outcome::NotChecked,
            worst: None,
            tolerance,
            proved_at_least: None,
            note: None,
        }
    }

    /// A check that does not apply, with the reason.
    pub(super) fn not_checked(check: Check, tolerance: f64, why: &str) -> Self {
        Self {
            note: Some(why.to_owned()),
            ..Self::new(check, tolerance)
        }
    }

    /// The worst excess as a multiple of the tolerance.
    fn severity(&self) -> f64 {
        let excess = self.worst.as_ref().map_or(0.0, Worst::excess);
        excess / self.tolerance.max(f64::MIN_POSITIVE)
    }

    /// Updates the worst value; `place` names its place.
    pub(super) fn take(&mut self, found: Worst, place: impl FnOnce() -> String) {
        let excess = found.excess();
        if self
            .worst
            .as_ref()
            .is_none_or(|worst| excess > worst.excess())
        {
            self.outcome = if excess <= self.tolerance {
                Outcome::Pass
            } else {
                Outcome::Fail
            };
            self.worst = Some(Worst {
                place: Some(place()),
                ..found
            });
        }
    }
}
