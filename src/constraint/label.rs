//! The names and units of constraint rows.

use crate::model::{Joint, JointKind, Model};
use crate::scalar::Scalar;

/// The name, unit and kind of a row of a constraint, for a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowLabel {
    /// The limited quantity, such as `upper position limit of joint 'joint_2'`.
    pub name: String,
    /// The unit of the row divided by its [scale](super::Constraint::row_scales); empty if unknown.
    pub unit: &'static str,
    /// The kind of the limited quantity.
    pub kind: RowKind,
}

impl RowLabel {
    /// The default label, which is the number of the row.
    #[must_use]
    pub fn numbered(row: usize) -> Self {
        Self {
            name: format!("row {row} of the constraint"),
            unit: "",
            kind: RowKind::Other,
        }
    }
}

/// The kind of quantity that a row limits, with the index of the joint for limits of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowKind {
    /// The position of a joint.
    Position(usize),
    /// The velocity of a joint.
    Velocity(usize),
    /// The torque or force of a joint.
    Torque(usize),
    /// The acceleration of a joint.
    Acceleration(usize),
    /// The rate of the acceleration of a joint.
    Jerk(usize),
    /// The distance of the robot from an obstacle.
    Clearance,
    /// Any other quantity.
    Other,
}

impl RowKind {
    /// The index of the joint.
    #[must_use]
    pub fn joint(self) -> Option<usize> {
        match self {
            Self::Position(joint)
            | Self::Velocity(joint)
            | Self::Torque(joint)
            | Self::Acceleration(joint)
            | Self::Jerk(joint) => Some(joint),
            Self::Clearance | Self::Other => None,
        }
    }
}

/// The unit of the joint: the first for a revolute joint, the second for a prismatic one.
pub(super) fn unit_of<C: Scalar>(
    joint: &Joint<C>,
    turning: &'static str,
    sliding: &'static str,
) -> &'static str {
    match joint.kind() {
        JointKind::Revolute | JointKind::Continuous => turning,
        JointKind::Prismatic => sliding,
    }
}

/// The name of the first link of a body, or of its joint if the body has no link.
pub(super) fn name_of<C: Scalar>(body: Option<usize>, model: &Model<C>) -> String {
    if let Some(frame) = model.frames().iter().find(|f| f.body == body) {
        return format!("link '{}'", frame.name);
    }
    match body {
        None => "the base".to_owned(),
        Some(body) => match model.joints().get(body) {
            Some(joint) => format!("the body of joint '{}'", joint.name()),
            None => format!("body {body}"),
        },
    }
}
