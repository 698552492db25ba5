//! MoveIt's `joint_limits.yaml`.

use crate::Quantity;
use crate::keys::json::by_name;
use crate::keys::yaml::{of_value, yaml_value};
use crate::moveit::check_fields;
use aghf::error::{Error, Result, plain};
use aghf::input::read_text;
use aghf::model::Joint;
use aghf::urdf::{LoadNote, LoadReport};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// The largest distance by which a limit of position may lie within that of the URDF as its rounding, rad or m.
const ROUNDING: f64 = 1e-5;

/// A file of limits.
pub(crate) struct JointLimitsFile {
    file: String,
    read: Contents,
}

#[derive(Deserialize)]
struct Contents {
    #[serde(default)]
    default_velocity_scaling_factor: Option<f64>,
    #[serde(default)]
    default_acceleration_scaling_factor: Option<f64>,
    #[serde(deserialize_with = "by_name")]
    joint_limits: BTreeMap<String, JointLimits>,
}

/// The limits of a joint in that file. A limit holds where its flag says so, or where it has a number and no flag.
#[derive(Default, Deserialize)]
#[serde(default)]
struct JointLimits {
    has_position_limits: Option<bool>,
    min_position: Option<f64>,
    max_position: Option<f64>,
    has_velocity_limits: Option<bool>,
    max_velocity: Option<f64>,
    has_acceleration_limits: Option<bool>,
    max_acceleration: Option<f64>,
    has_deceleration_limits: Option<bool>,
    /// Pilz writes it with a negative sign.
    max_deceleration: Option<f64>,
    has_jerk_limits: Option<bool>,
    max_jerk: Option<f64>,
    has_effort_limits: Option<bool>,
    max_effort: Option<f64>,
}

/// The key of a limit, whether it holds, and its number.
type Written = (&'static str, bool, Option<f64>);

fn written(key: &'static str, flag: Option<bool>, number: Option<f64>) -> Written {
    (key, flag.unwrap_or(number.is_some()), number)
}

impl JointLimits {
    /// The limits of a kind, acceleration before deceleration.
    fn of(&self, limit: Quantity) -> Vec<Written> {
        let deceleration = self.max_deceleration.map(f64::abs);
        match limit {
            Quantity::Velocity => vec![written("max_velocity", self.has_velocity_limits, self.max_velocity)],
            Quantity::Jerk => vec![written("max_jerk", self.has_jerk_limits, self.max_jerk)],
            _ => vec![
                written("max_acceleration", self.has_acceleration_limits, self.max_acceleration),
                written("max_deceleration", self.has_deceleration_limits, deceleration),
            ],
        }
    }
}

impl JointLimitsFile {
    /// Reads a file, and refuses keys that are not read and limits of `joints` that no scenario can have.
    ///
    /// # Errors
    /// Names the file, the element and the fault.
    pub fn load(path: &Path, joints: &[&Joint<f64>]) -> Result<Self> {
        let (file, what) = (path.display().to_string(), "joint limits");
        let value = yaml_value(&read_text(path)?, &file, what)?;
        check_fields(&value, "joint_limits.yaml", [&file, ""])?;
        let of_joints = value.get("joint_limits").and_then(Value::as_object);
        for (name, joint) in of_joints.into_iter().flatten() {
            let key = format!("joint_limits.{name}");
            check_fields(joint, "a joint of joint_limits.yaml", [&file, &key])?;
        }
        let read = Self { read: of_value(value, &file, what)?, file };
        for limit in [Quantity::Velocity, Quantity::Acceleration] {
            read.factor(limit)?;
        }
        for joint in joints {
            if let Some(limits) = read.read.joint_limits.get(joint.name()) {
                read.check_position(limits, joint)?;
                read.check_effort(limits, joint)?;
            }
        }
        Ok(read)
    }

    /// The default factor of a kind of limit; 1 without one.
    ///
    /// # Errors
    /// A factor that is not above 0 and at most 1.
    pub fn factor(&self, limit: Quantity) -> Result<f64> {
        let (key, factor) = match limit {
            Quantity::Velocity => ("default_velocity_scaling_factor", self.read.default_velocity_scaling_factor),
            Quantity::Acceleration => {
                ("default_acceleration_scaling_factor", self.read.default_acceleration_scaling_factor)
            }
            _ => return Ok(1.0),
        };
        let factor = factor.unwrap_or(1.0);
        if factor > 0.0 && factor <= 1.0 {
            return Ok(factor);
        }
        let condition = format!("it is {}, a factor is above 0 and at most 1", plain(factor));
        Err(Error::input(&self.file, key, condition))
    }

    /// The limits of joints, each times `factor`, in rad or m per s, per s^2 or per s^3. A velocity that the file does
    /// not limit is that of the robot if it is scaled.
    ///
    /// # Errors
    /// A limit that holds without a number, and one that is not positive.
    pub fn limits(
        &self,
        limit: Quantity,
        joints: &[&Joint<f64>],
        factor: f64,
        notes: &mut LoadReport,
    ) -> Result<Vec<Option<f64>>> {
        let of = |joint: &&Joint<f64>| {
            let name = joint.name();
            let of_file = match self.read.joint_limits.get(name) {
                Some(limits) => self.least(limits.of(limit), name, notes)?,
                None => None,
            };
            let velocity = joint.limits().velocity;
            let of_robot = limit == Quantity::Velocity && factor < 1.0 && velocity.is_finite();
            let number = of_file.or(of_robot.then_some(velocity));
            Ok(number.map(|number| factor * number))
        };
        joints.iter().map(of).collect()
    }

    /// The smallest of the limits of a joint that hold.
    fn least(&self, all: Vec<Written>, name: &str, notes: &mut LoadReport) -> Result<Option<f64>> {
        let mut numbers = Vec::new();
        for (key, _, number) in all.into_iter().filter(|(_, holds, _)| *holds) {
            let refuse = |condition: String| {
                let element = format!("joint_limits.{name}.{key}");
                Err(Error::input(&self.file, element, condition))
            };
            match number {
                Some(number) if number > 0.0 => numbers.push(number),
                Some(number) => {
                    let number = plain(number);
                    return refuse(format!("it is {number} and must be a positive number"));
                }
                None => return refuse("it is missing".to_owned()),
            }
        }
        if let [acceleration, deceleration] = numbers.as_slice()
            && acceleration != deceleration
        {
            let [a, b] = [acceleration, deceleration].map(|number| plain(*number));
            notes.push(LoadNote::Deceleration { joint: name.to_owned(), least: format!("{a} and {b}") });
        }
        Ok(numbers.into_iter().reduce(f64::min))
    }

    /// Refuses positions within those of the URDF: a scenario has no others than these and shares of them.
    fn check_position(&self, limits: &JointLimits, joint: &Joint<f64>) -> Result<()> {
        let (lower, upper) = (limits.min_position, limits.max_position);
        let given = lower.or(upper);
        let element = format!("joint_limits.{}", joint.name());
        let refuse = |condition: &str| Err(Error::input(&self.file, element, condition));
        if !limits.has_position_limits.unwrap_or(given.is_some()) {
            return Ok(());
        }
        if given.is_none() {
            return refuse("it has position limits, but no min_position and no max_position");
        }
        let of_robot = joint.limits();
        if lower.is_some_and(|lower| lower > of_robot.lower + ROUNDING)
            || upper.is_some_and(|upper| upper < of_robot.upper - ROUNDING)
        {
            let range = |lower: f64, upper: f64| format!("[{}, {}]", plain(lower), plain(upper));
            let of_file = range(lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY));
            return refuse(&format!(
                "its positions {of_file} are within those of the URDF, {}, which alone can be enforced; write them \
                 there, as lower and upper of a revolute or prismatic joint, or leave them out here",
                range(of_robot.lower, of_robot.upper)
            ));
        }
        Ok(())
    }

    /// Refuses efforts below those of the URDF.
    fn check_effort(&self, limits: &JointLimits, joint: &Joint<f64>) -> Result<()> {
        let (key, holds, number) = written("max_effort", limits.has_effort_limits, limits.max_effort);
        let of_robot = joint.limits().effort;
        let condition = match number {
            None if holds => "it is missing".to_owned(),
            Some(number) if holds && number < of_robot => format!(
                "{} is less than the effort of the URDF, {}, which alone can be enforced; write it there, or leave it \
                 out here",
                plain(number),
                plain(of_robot)
            ),
            _ => return Ok(()),
        };
        let element = format!("joint_limits.{}.{key}", joint.name());
        Err(Error::input(&self.file, element, condition))
    }
}
