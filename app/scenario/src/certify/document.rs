//! The document of a certificate.

use serde::{Deserialize, Serialize};

/// A proof that a motion keeps the promises of a scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// The name and version of the format.
    pub format: String,
    /// The name of the scenario.
    pub scenario: String,
    /// The 64-bit xxHash of the text of the robot, in hexadecimal digits.
    pub robot_xxh64: String,
    /// True if every promise of the scenario is certified.
    pub complete: bool,
    /// The parts of the scenario without a proof.
    pub not_certified: Vec<NotCertified>,
    /// The accepted shortfall of a reserve.
    pub tolerance: f64,
    /// The largest deviation of the position of a joint from the motion for which the intervals hold, rad or m.
    pub tracking_error: f64,
    /// The limits of the joints.
    pub limits: Vec<LimitRow>,
    /// Pairs of links that may overlap, about which nothing is claimed.
    pub may_overlap: Vec<[String; 2]>,
    /// Bounds on deviations at the ends and between segments.
    pub deviations: Deviations,
    /// The least reserve of one of the sets of poses that are the goal; `None` if it is a configuration.
    pub goal: Option<f64>,
    /// The places at which the motion passes the waypoints, in their order.
    pub waypoints: Vec<Passage>,
    /// The promises for which each interval has a reserve.
    pub promises: Vec<Promise>,
    /// The intervals, which cover each segment from -1 to 1 in order.
    pub intervals: Vec<Interval>,
    /// The horizon `T`, s.
    pub horizon_s: f64,
    /// The names of the joints.
    pub joints: Vec<String>,
    /// The Chebyshev coefficients of the positions per segment and joint.
    pub coefficients: Vec<Vec<Vec<f64>>>,
}

/// A kind of promise that is kept at all times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Promise {
    /// Limits of positions.
    Position,
    /// Limits of velocities.
    Velocity,
    /// Limits of accelerations.
    Acceleration,
    /// Limits of jerks.
    Jerk,
    /// Limits of torques and forces.
    Torque,
    /// Poses and speeds along the way.
    Keep,
    /// The force of the ground on a standing foot.
    Stand,
    /// Clearances from obstacles.
    Obstacles,
    /// Clearances between links.
    SelfCollision,
}

impl Promise {
    /// The name for readers.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "position limits",
            Self::Velocity => "velocity limits",
            Self::Acceleration => "acceleration limits",
            Self::Jerk => "jerk limits",
            Self::Torque => "torque limits",
            Self::Keep => "conditions along the way",
            Self::Stand => "standing foot",
            Self::Obstacles => "clearance from obstacles",
            Self::SelfCollision => "clearance between links",
        }
    }
}

/// A limit of a joint, in rad or m, per s, s^2 or s^3, N m or N.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimitRow {
    /// The kind.
    pub promise: Promise,
    /// The index of the joint.
    pub joint: usize,
    /// The lower bound; `None` without one.
    pub at_least: Option<f64>,
    /// The upper bound.
    pub at_most: Option<f64>,
}

impl LimitRow {
    /// The unit of reserves: the larger absolute value of the bounds, or one if that is zero.
    #[must_use]
    pub fn scale(&self) -> f64 {
        let bounds = [self.at_least, self.at_most].into_iter().flatten();
        let largest = bounds.fold(0.0, |scale: f64, bound| scale.max(bound.abs()));
        if largest > 0.0 { largest } else { 1.0 }
    }
}

/// Bounds on deviations of states, rad or m and their derivatives; `None` where the scenario promises nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Deviations {
    /// Of the first positions.
    pub start_position: Option<f64>,
    /// Of the first velocities.
    pub start_velocity: Option<f64>,
    /// Of the last positions.
    pub goal_position: Option<f64>,
    /// Of the last velocities.
    pub goal_velocity: Option<f64>,
    /// Jumps of positions between segments, due to rounding of the coefficients.
    pub jump_position: Option<f64>,
    /// Jumps of velocities.
    pub jump_velocity: Option<f64>,
    /// Jumps of accelerations.
    pub jump_acceleration: Option<f64>,
}

/// An interval of a segment, on which `x` goes from -1 to 1, the reserve of each promise there, and directions that
/// separate shapes of the robot from others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval(
    pub usize,
    pub f64,
    pub f64,
    pub Vec<f64>,
    pub Vec<Direction>,
);

/// A direction from one shape to another. The shapes of the robot are sorted by the names of their links, and the
/// obstacles follow them. Pairs without one are separated in the direction of their centres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Direction(pub usize, pub usize, pub [f64; 3]);

/// A place of the motion: a segment, `x` from -1 to 1, and the least reserve of the conditions there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Passage(pub usize, pub f64, pub f64);

/// A part of the scenario without a proof.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NotCertified {
    /// Its name.
    pub promise: String,
    /// The reason.
    pub reason: String,
}

/// The result of a certification.
#[derive(Clone, Debug, PartialEq)]
pub struct Certification {
    /// The certificate; `None` if a promise was not proved.
    pub certificate: Option<Certificate>,
    /// The first place of each row that was not proved.
    pub failures: Vec<Failure>,
}

/// A row that is broken, or could not be proved.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// The promise in words.
    pub promise: String,
    /// The joint, or the names of a pair.
    pub place: String,
    /// The time, s.
    pub at_s: f64,
    /// A value, in the unit of the row.
    pub value: f64,
    /// Its bound.
    pub bound: f64,
    /// True if the value is proved to be beyond the bound.
    pub is_broken: bool,
}
