//! Motions as messages of ROS 2.

use crate::Quantity;
use crate::keys::yaml::read_yaml;
use aghf::error::{Error, Result, plain};
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
        Self::from_nanoseconds((t * Self::PER_SECOND as f64).round() as u64)
    }

    /// The stamp of a time in ns.
    fn from_nanoseconds(nanoseconds: u64) -> Self {
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

    /// The largest difference between the end of a motion and the start of the next one, rad or m, per s, per s^2.
    const JUMP: f64 = 1e-6;

    /// Appends a motion that continues this one, without its first point; `file` names it in errors. The header of
    /// several motions names none of them.
    ///
    /// # Errors
    /// It is of other joints, or begins with a position, a velocity or an acceleration that differs by more than 1e-6.
    pub fn append(&mut self, next: Self, file: &str) -> Result<()> {
        if self.joint_names != next.joint_names {
            return Err(Error::input(file, "joints", "they are not those of the motion before"));
        }
        let mut points = next.points.into_iter();
        let (Some(last), Some(first)) = (self.points.last(), points.next()) else { return Ok(()) };
        for (quantity, before, after) in [
            (Quantity::Position, &last.positions, &first.positions),
            (Quantity::Velocity, &last.velocities, &first.velocities),
            (Quantity::Acceleration, &last.accelerations, &first.accelerations),
        ] {
            let pairs = self.joint_names.iter().zip(before.iter().zip(after));
            let mut jumps = pairs.filter(|(_, (before, after))| (*before - *after).abs() > Self::JUMP);
            if let Some((joint, (before, after))) = jumps.next() {
                let (name, [before, after]) =
                    (quantity.name(), [before, after].map(|x| plain((x * 1e9).round() / 1e9)));
                let condition =
                    format!("its {name} at the start is {after}, and {before} at the end of the motion before");
                return Err(Error::input(file, format!("joint '{joint}'"), condition));
            }
        }
        let begin = last.time_from_start.nanoseconds();
        self.points.extend(points.map(|point| {
            let time_from_start = Stamp::from_nanoseconds(begin + point.time_from_start.nanoseconds());
            JointTrajectoryPoint { time_from_start, ..point }
        }));
        self.header.frame_id.clear();
        Ok(())
    }

    /// Parses a message in YAML or JSON; `file` names it in errors.
    ///
    /// # Errors
    /// Names the key and its fault.
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        read_yaml(text, file, "trajectory")
    }
}
