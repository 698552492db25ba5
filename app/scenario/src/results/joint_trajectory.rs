//! Motions as messages of ROS 2.

use crate::keys::yaml::read_yaml;
use aghf::error::Result;
use aghf::model::{Joint, Model};
use aghf::motion::Sample;
use serde::{Deserialize, Serialize};

/// A `trajectory_msgs/JointTrajectory`: a motion of `N` joints as points, which a controller of joints interpolates.
/// The order of the fields is that of the message.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointTrajectory {
    /// The time at which it begins and the frame; both may be left out.
    #[serde(default)]
    pub header: Header,
    /// The names of the joints.
    pub joint_names: Vec<String>,
    /// The points, ascending in time.
    pub points: Vec<JointTrajectoryPoint>,
}

/// A `trajectory_msgs/JointTrajectoryPoint`: `N` numbers in the order of the joints per list, in rad or m, per s, per
/// s^2, N m or N. Lists of other tools may be empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JointTrajectoryPoint {
    /// The positions.
    pub positions: Vec<f64>,
    /// The velocities.
    pub velocities: Vec<f64>,
    /// The accelerations.
    pub accelerations: Vec<f64>,
    /// The torques or forces.
    pub effort: Vec<f64>,
    /// The time after the start.
    pub time_from_start: Stamp,
}

/// A `std_msgs/Header`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Header {
    /// The time.
    pub stamp: Stamp,
    /// The frame of reference.
    pub frame_id: String,
}

/// A `builtin_interfaces/Time` or `Duration`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Stamp {
    /// Whole seconds.
    pub sec: i32,
    /// The rest in ns.
    pub nanosec: u32,
}

impl Stamp {
    /// The nanoseconds of a second.
    const PER_SECOND: u64 = 1_000_000_000;

    /// The stamp nearest to a time `t` of a motion, s.
    #[must_use]
    pub fn new(t: f64) -> Self {
        let nanoseconds = (t * Self::PER_SECOND as f64).round() as u64;
        Self { sec: (nanoseconds / Self::PER_SECOND) as i32, nanosec: (nanoseconds % Self::PER_SECOND) as u32 }
    }

    /// The time in ns; zero for a negative one.
    #[must_use]
    pub fn nanoseconds(self) -> u64 {
        u64::try_from(self.sec).unwrap_or_default() * Self::PER_SECOND + u64::from(self.nanosec)
    }

    /// The time, s.
    #[must_use]
    pub fn seconds(self) -> f64 {
        f64::from(self.sec) + f64::from(self.nanosec) / Self::PER_SECOND as f64
    }
}

impl JointTrajectory {
    /// The message with a point for each sample of a motion of `model`.
    #[must_use]
    pub fn of_samples(model: &Model, samples: impl IntoIterator<Item = Sample>) -> Self {
        let point = |sample: Sample| JointTrajectoryPoint {
            positions: sample.q,
            velocities: sample.v,
            accelerations: sample.a,
            effort: sample.u,
            time_from_start: Stamp::new(sample.t),
        };
        let names = model.joints().iter().map(Joint::name);
        Self {
            header: Header::default(),
            joint_names: names.map(str::to_owned).collect(),
            points: samples.into_iter().map(point).collect(),
        }
    }

    /// Parses a message in YAML or JSON; `file` names it in errors.
    ///
    /// # Errors
    /// Names the key and its fault.
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        read_yaml(text, file, "trajectory")
    }
}
