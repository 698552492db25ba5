//! What a motion keeps clear of, and which limits it breaks.

use super::Scenario;
use crate::error::Result;
use crate::motion::Sample;
use serde::Serialize;
use std::fmt;

/// A report on whether a motion can be carried out, from a fine grid of times.
#[derive(Clone, Debug, Serialize)]
pub struct Feasibility {
    /// The smallest distance of the robot's shape from an obstacle, m; negative in a collision, `None` without obstacles.
    pub smallest_clearance_m: Option<f64>,
    /// The worst violation of each kind of limit by each joint that breaks one.
    pub limit_violations: Vec<LimitViolation>,
}

/// A limit of a joint that is broken.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitViolation {
    /// The joint.
    pub joint: String,
    /// The kind of the limit.
    pub limit: Limit,
    /// The amount by which the limit is exceeded at worst, in rad or m, rad/s or m/s, N m or N.
    pub by: f64,
    /// The time of the worst, s.
    pub at_s: f64,
}

impl fmt::Display for LimitViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limit = match self.limit {
            Limit::Position => "position",
            Limit::Velocity => "velocity",
            Limit::Torque => "torque",
        };
        let Self {
            joint, by, at_s, ..
        } = self;
        write!(f, "{limit} of joint '{joint}' by {by:.3} at {at_s:.2} s")
    }
}

/// The kind of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Limit {
    /// The position.
    Position,
    /// The speed.
    Velocity,
    /// The torque or force.
    Torque,
}

impl Feasibility {
    /// That of a motion given by `samples`.
    ///
    /// # Errors
    /// The samples are those of another robot.
    pub fn of(scenario: &Scenario, samples: &[Sample]) -> Result<Self> {
        let configurations = samples.iter().map(|s| s.q.as_slice());
        let model = &scenario.model;
        let mut limit_violations = Vec::new();
        for (i, joint) in model.joints().iter().enumerate() {
            let limits = joint.limits();
            let excess = |limit: Limit, s: &Sample| match limit {
                Limit::Position => (s.q[i] - limits.upper).max(limits.lower - s.q[i]),
                Limit::Velocity => s.v[i].abs() - limits.velocity,
                Limit::Torque => s.u[i].abs() - limits.effort,
            };
            for limit in [Limit::Position, Limit::Velocity, Limit::Torque] {
                let all = samples.iter().map(|s| (excess(limit, s), s.t));
                let worst = all.max_by(|(a, _), (b, _)| a.total_cmp(b));
                if let Some((by, at_s)) = worst.filter(|(by, _)| *by > 0.0) {
                    limit_violations.push(LimitViolation {
                        joint: joint.name().to_owned(),
                        limit,
                        by,
                        at_s,
                    });
                }
            }
        }
        Ok(Self {
            smallest_clearance_m: (scenario.environment)
                .smallest_clearance(model, configurations)?,
            limit_violations,
        })
    }

    /// Tells whether nothing is hit by more than `depth` and the limits that the scenario enforces are kept within `tolerance`.
    #[must_use]
    pub fn holds(&self, scenario: &Scenario, depth: f64, tolerance: f64) -> bool {
        let enforced = scenario.file.enforced_limits;
        let broken = |violation: &LimitViolation| {
            let enforced = match violation.limit {
                Limit::Position => enforced.position,
                Limit::Velocity => enforced.velocity,
                Limit::Torque => enforced.torque,
            };
            enforced && violation.by > tolerance
        };
        self.smallest_clearance_m.is_none_or(|m| m >= -depth)
            && !self.limit_violations.iter().any(broken)
    }
}
