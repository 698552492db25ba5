//! Limits of velocity, acceleration, jerk and power that a scenario gives.

use crate::keys::joint_limits::JointLimitsFile;
use crate::{EnforcedLimits, Quantity};
use aghf::error::{Error, Result, plain};
use aghf::model::Model;
use aghf::urdf::{LoadReport, RobotSource};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use urdf_rs::Robot;

/// The largest velocities, accelerations, jerks or powers of the joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "a number is needed, a list with a number or null for each joint, \"urdf\" or {\"file\": PATH}"
)]
pub enum RateLimits {
    /// The same number for all joints.
    Same(f64),
    /// A number for each joint, in their order; null for none.
    Each(Vec<Option<f64>>),
    /// Those of the URDF, which has no powers. They become a list when the scenario is read, as those of a file do.
    Urdf(Urdf),
    /// Those of a file.
    File {
        /// The path of a `joint_limits.yaml` of MoveIt, relative to the scenario, whose limits of velocity,
        /// acceleration, deceleration and jerk are read, times its default scaling factors.
        file: PathBuf,
    },
}

/// The URDF as the source of limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Urdf {
    /// The attributes `velocity` and, of URDF 1.2, `acceleration`, `deceleration` and `jerk` of its `limit` elements.
    #[serde(rename = "urdf")]
    Urdf,
}

impl RateLimits {
    /// The same limits for a robot whose joint `i` is joint `order[i]` of this one.
    fn in_order(&self, order: &[usize]) -> Self {
        match self {
            Self::Each(numbers) if numbers.len() == order.len() => {
                Self::Each(order.iter().map(|joint| numbers[*joint]).collect())
            }
            other => other.clone(),
        }
    }

    /// The limit of a joint.
    pub(crate) fn of(&self, joint: usize) -> Option<f64> {
        match self {
            Self::Same(number) => Some(*number),
            Self::Each(numbers) => numbers.get(joint).copied().flatten(),
            Self::Urdf(_) | Self::File { .. } => None,
        }
    }

    /// Refuses numbers that are not positive, and a list of another length than `dof`; `key` names them in `path`.
    pub(crate) fn check(&self, dof: usize, key: &str, path: &str) -> Result<()> {
        let refuse = |condition: String| Err(Error::input(path, key, condition));
        let numbers = match self {
            Self::Same(number) => vec![*number],
            Self::Each(numbers) if numbers.len() != dof => {
                let found = numbers.len();
                return refuse(format!("it has {found} entries, {dof} are needed"));
            }
            Self::Each(numbers) => numbers.iter().flatten().copied().collect(),
            Self::Urdf(_) | Self::File { .. } => {
                return refuse("a path to limits is allowed in a scenario file only".to_owned());
            }
        };
        match numbers.iter().find(|x| !(x.is_finite() && **x > 0.0)) {
            Some(limit) => refuse(format!("it is {} and must be a positive number", plain(*limit))),
            None => Ok(()),
        }
    }

    /// Replaces a source by its numbers for the joints of `model`, so that the scenario depends on no other file.
    fn read(
        &mut self,
        limit: Quantity,
        model: &Model,
        source: &RobotSource,
        folder: &Path,
        notes: &mut LoadReport,
    ) -> Result<()> {
        let (file, numbers) = match self {
            Self::Same(_) | Self::Each(_) => return Ok(()),
            Self::Urdf(_) | Self::File { .. } if limit == Quantity::Power => {
                let condition = "files of robots have no limits of power; a number is needed, or a list";
                return Err(Error::input(source.name(), "joints", condition));
            }
            Self::Urdf(_) => (source.name(), of_urdf(&source.elements()?, limit, model)),
            Self::File { file } => {
                let path = folder.join(file);
                let joints: Vec<_> = model.joints().iter().collect();
                let read = JointLimitsFile::load(&path, &joints)?;
                let factor = read.factor(limit)?;
                let numbers = read.limits(limit, &joints, factor, notes)?;
                (path.display().to_string(), numbers)
            }
        };
        let named = model.joints().iter().zip(&numbers);
        for (joint, number) in named {
            if let Some(number) = number.filter(|x| !(x.is_finite() && *x > 0.0)) {
                let condition =
                    format!("its limit of {} is {}, a positive number is needed", limit.name(), plain(number));
                let element = format!("joint '{}'", joint.name());
                return Err(Error::input(file, element, condition));
            }
        }
        if numbers.iter().all(Option::is_none) {
            let condition = format!("no joint that is planned has a limit of {}", limit.name());
            return Err(Error::input(file, "joints", condition));
        }
        *self = Self::Each(numbers);
        Ok(())
    }
}

/// The limits of the joints of a model in its URDF; the smaller one of acceleration and deceleration.
fn of_urdf(robot: &Robot, limit: Quantity, model: &Model) -> Vec<Option<f64>> {
    let of = |name: &str| {
        let joint = robot.joints.iter().find(|joint| joint.name == name)?;
        let written = &joint.limit;
        let numbers = match limit {
            Quantity::Velocity => [written.velocity; 2],
            Quantity::Jerk => [written.jerk; 2],
            _ => [written.acceleration, written.deceleration],
        };
        smallest(numbers.into_iter().filter(|x| *x != f64::INFINITY))
    };
    model.joints().iter().map(|joint| of(joint.name())).collect()
}

/// The smallest number, NaN if one is.
fn smallest(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    numbers.reduce(|a, b| if a < b || a.is_nan() { a } else { b })
}

impl EnforcedLimits {
    /// The same limits for a robot whose joint `i` is joint `order[i]` of this one.
    pub(crate) fn in_order(&self, order: &[usize]) -> Self {
        let mut sorted = self.clone();
        for numbers in sorted.numbers_mut().into_iter().filter_map(|(.., numbers)| numbers.as_mut()) {
            *numbers = numbers.in_order(order);
        }
        sorted
    }

    /// Replaces limits that come with the robot by their numbers. `folder` is that of the scenario, called `path`.
    pub(crate) fn read(
        &mut self,
        model: &Model,
        source: &RobotSource,
        (path, folder): (&str, &Path),
        notes: &mut LoadReport,
    ) -> Result<()> {
        for (limit, key, limits) in self.numbers_mut() {
            if let Some(limits) = limits {
                let key = format!("enforced_limits.{key}");
                let read = limits.read(limit, model, source, folder, notes);
                read.map_err(|e| Error::input(path, key, e.to_string()))?;
            }
        }
        Ok(())
    }
}
