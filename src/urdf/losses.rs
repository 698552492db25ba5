//! Losses and rotor inertia of the joints of a URDF.

use crate::error::{Error, Result, plain};
use crate::model::{Drive, JointSpec};
use crate::names::instead;
use std::collections::BTreeMap;
use urdf_rs::Dynamics;

/// The width of the change of sign of dry friction unless another is given, rad/s or m/s: friction is then within 1 %
/// of its bound beyond 0.15 rad/s, a tenth of the velocity of an ordinary motion.
pub const FRICTION_VELOCITY: f64 = 0.02;

/// A number for all joints, or numbers for some of them by name.
#[derive(Clone, Debug, PartialEq)]
pub enum PerJoint {
    /// The same number for all joints.
    Same(f64),
    /// Numbers by the names of joints; the others have that of the file or, where a URDF has none, the default.
    Named(BTreeMap<String, f64>),
}

impl Default for PerJoint {
    /// Numbers of no joint.
    fn default() -> Self {
        Self::Named(BTreeMap::new())
    }
}

/// The constants of the [drives](Drive) of a robot: by default the `damping` and `friction` of the `dynamics` elements
/// of its URDF, no rotor inertia, and the width [`FRICTION_VELOCITY`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Losses {
    /// Viscous damping, N m s/rad or N s/m, in place of that of the URDF.
    pub damping: PerJoint,
    /// Dry friction, N m or N, in place of that of the URDF.
    pub friction: PerJoint,
    /// The width of the change of sign of the friction, rad/s or m/s.
    pub friction_velocity: PerJoint,
    /// The inertia of the rotor times the square of the gear ratio, kg m^2 or kg.
    pub armature: PerJoint,
}

impl Losses {
    /// The drives of joints with these `dynamics` elements; `file` names the robot in errors.
    pub(super) fn drives(&self, joints: &[JointSpec<f64>], written: &[Dynamics], file: &str) -> Result<Vec<Drive>> {
        let keys = ["damping", "friction", "friction_velocity", "armature"];
        let all = [&self.damping, &self.friction, &self.friction_velocity, &self.armature];
        for (key, numbers) in keys.iter().zip(all) {
            let PerJoint::Named(numbers) = numbers else {
                continue;
            };
            let unknown = |name: &&String| joints.iter().all(|joint| joint.name != **name);
            if let Some(name) = numbers.keys().find(unknown) {
                let names = instead(name, joints.iter().map(|joint| joint.name.as_str()));
                let condition = format!("the robot has no such joint that moves{names}");
                return Err(Error::input(file, format!("losses.{key}.{name}"), condition));
            }
        }
        let drive = |(joint, written): (&JointSpec<f64>, &Dynamics)| {
            let mut found = [written.damping, written.friction, FRICTION_VELOCITY, 0.0];
            for ((key, numbers), found) in keys.iter().zip(all).zip(&mut found) {
                match numbers {
                    PerJoint::Same(number) => *found = *number,
                    PerJoint::Named(numbers) => {
                        *found = numbers.get(&joint.name).copied().unwrap_or(*found);
                    }
                }
                let positive = *found > 0.0 || *found == 0.0 && *key != "friction_velocity";
                if !(positive && found.is_finite()) {
                    let wanted = match *key {
                        "friction_velocity" => "a positive number",
                        _ => "a number that is not negative",
                    };
                    let condition = format!("its {key} is {}, {wanted} is needed", plain(*found));
                    let element = format!("joint '{}'", joint.name);
                    return Err(Error::input(file, element, condition));
                }
            }
            let [damping, friction, friction_velocity, armature] = found;
            Ok(Drive { damping, friction, friction_velocity, armature })
        };
        joints.iter().zip(written).map(drive).collect()
    }
}
