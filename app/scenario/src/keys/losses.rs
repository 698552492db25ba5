//! The losses and the rotor inertia of the robot of a scenario.

use crate::keys::json::by_name;
use aghf::error::{Result, plain};
use aghf::model::{Drive, JointKind, Model};
use aghf::urdf::{self, FRICTION_VELOCITY, LoadNote};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The forces of the drives of the joints beside those of rigid bodies: `true` for the damping and the friction in
/// the URDF, `false` for nothing, or an object of numbers that stand in place of those.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "true, false or an object with some of the keys damping, friction, friction_velocity and armature is \
                 needed, each of which is a number or an object of numbers by the names of joints"
)]
pub enum Losses {
    /// The damping and the friction in the URDF, or none.
    Counted(bool),
    /// Numbers in place of those of the URDF.
    Given(LossNumbers),
}

/// Numbers in place of those of the URDF: each is the same for all joints, or an object of numbers by the names of
/// joints, locked ones among them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LossNumbers {
    /// Viscous damping `D`, N m s/rad or N s/m; by default that of the URDF.
    #[serde(skip_serializing_if = "is_default")]
    pub damping: JointNumbers,
    /// Dry friction at large velocities, N m or N; by default that of the URDF.
    #[serde(skip_serializing_if = "is_default")]
    pub friction: JointNumbers,
    /// The width of the change of sign of the friction, rad/s or m/s; 0.02 by default.
    #[serde(skip_serializing_if = "is_default")]
    pub friction_velocity: JointNumbers,
    /// The inertia of the rotor times the square of the gear ratio, kg m^2 or kg; zero by default.
    #[serde(skip_serializing_if = "is_default")]
    pub armature: JointNumbers,
}

/// A number for all joints, or numbers for some by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum JointNumbers {
    /// The same number for all joints.
    Same(f64),
    /// Numbers by the names of joints.
    Named(#[serde(deserialize_with = "by_name")] BTreeMap<String, f64>),
}

impl Default for Losses {
    /// None.
    fn default() -> Self {
        Self::Counted(false)
    }
}

impl Default for JointNumbers {
    /// Numbers of no joint.
    fn default() -> Self {
        Self::Named(BTreeMap::new())
    }
}

fn is_default(numbers: &JointNumbers) -> bool {
    *numbers == JointNumbers::default()
}

impl Losses {
    /// The losses as an option of reading a robot.
    #[must_use]
    pub fn options(&self) -> Option<urdf::Losses> {
        let given = match self {
            Self::Counted(counted) => return counted.then(urdf::Losses::default),
            Self::Given(given) => given,
        };
        let numbers = |numbers: &JointNumbers| match numbers {
            JointNumbers::Same(number) => urdf::PerJoint::Same(*number),
            JointNumbers::Named(numbers) => urdf::PerJoint::Named(numbers.clone()),
        };
        Some(urdf::Losses {
            damping: numbers(&given.damping),
            friction: numbers(&given.friction),
            friction_velocity: numbers(&given.friction_velocity),
            armature: numbers(&given.armature),
        })
    }
}

/// Gives the joints that move nothing with inertia the [substitutes](Model::substitute_rotors) of rotors, in the model
/// and in the losses, with a note for each.
pub(crate) fn substitute_rotors(model: Model, losses: &mut Losses, notes: &mut Vec<LoadNote>) -> Result<Model> {
    let rotors = model.substitute_rotors()?;
    if rotors.is_empty() {
        return Ok(model);
    }
    let mut drives = match model.drives() {
        [] => vec![
            Drive { damping: 0.0, friction: 0.0, friction_velocity: FRICTION_VELOCITY, armature: 0.0 };
            model.dof()
        ],
        drives => drives.to_vec(),
    };
    // From the first joint to the last.
    for (i, inertia) in rotors.into_iter().rev() {
        drives[i].armature = inertia;
        let joint = &model.joints()[i];
        let unit = match joint.kind() {
            JointKind::Prismatic => "kg",
            JointKind::Revolute | JointKind::Continuous => "kg m^2",
        };
        notes.push(LoadNote::SubstituteRotor {
            joint: joint.name().to_owned(),
            armature: format!("{} {unit}", plain(inertia)),
        });
    }
    let all = model.joints().iter().zip(&drives);
    let armature = all.map(|(joint, drive)| (joint.name().to_owned(), drive.armature));
    let given = match losses {
        // `false` counts no losses of the URDF either.
        Losses::Counted(false) => LossNumbers {
            damping: JointNumbers::Same(0.0),
            friction: JointNumbers::Same(0.0),
            ..LossNumbers::default()
        },
        Losses::Counted(true) => LossNumbers::default(),
        Losses::Given(given) => given.clone(),
    };
    *losses = Losses::Given(LossNumbers { armature: JointNumbers::Named(armature.collect()), ..given });
    model.with_drives(drives)
}
