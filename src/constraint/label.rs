//! The names and units of constraint rows.

use super::Side;
use crate::model::{JointKind, Model};
use crate::scalar::Scalar;
use serde::{Deserialize, Serialize};

/// The name, unit and quantity of a row of a constraint, for a report.
#[derive(Clone, Debug, PartialEq)]
pub struct RowLabel {
    /// The limited quantity in words, such as `upper position limit of joint 'joint_2'`.
    pub name: String,
    /// The unit of the [excess](RowForm::excess); empty if unknown.
    pub unit: &'static str,
    /// The limited quantity.
    pub quantity: Quantity,
    /// The index of the joint, for a quantity of a joint.
    pub joint: Option<usize>,
    /// The function of the quantity that the row is.
    pub form: RowForm,
}

impl RowLabel {
    /// The label of a row that is linear in a quantity that is not of a joint.
    #[must_use]
    pub fn new(name: String, unit: &'static str, quantity: Quantity) -> Self {
        Self { name, unit, quantity, joint: None, form: RowForm::Linear }
    }

    /// The default label, which is the number of the row.
    #[must_use]
    pub fn numbered(row: usize) -> Self {
        Self::new(format!("row {row} of the constraint"), "", Quantity::Other)
    }

    /// The label of the limit of a quantity of a joint on one side, or on none if it is zero; the number of the row if
    /// there is no such joint.
    pub(super) fn limit<C: Scalar>(
        quantity: Quantity,
        (joint, side): (usize, Option<Side>),
        row: usize,
        model: &Model<C>,
    ) -> Self {
        let Some(of) = model.joints().get(joint) else {
            return Self::numbered(row);
        };
        let (what, name) = (quantity.name_for(of.kind()), of.name());
        let words = match side {
            Some(side) => format!("{} {what} limit of joint '{name}'", side.name()),
            None => format!("{what} of the passive joint '{name}'"),
        };
        Self { joint: Some(joint), ..Self::new(words, quantity.unit(of.kind()), quantity) }
    }
}

/// A quantity of a motion that is limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// The time from the start to the end.
    Duration,
    /// The position of a joint.
    Position,
    /// The velocity of a joint.
    Velocity,
    /// The acceleration of a joint.
    Acceleration,
    /// The rate of the acceleration of a joint.
    Jerk,
    /// The torque or force of a joint.
    Torque,
    /// The torque or force of a joint without a motor, which is zero.
    Passive,
    /// The mechanical power of the motor of a joint, torque times velocity.
    Power,
    /// The pose of a frame, or the speed of a point.
    Frame,
    /// The force of the ground on a foot.
    Foot,
    /// The distance of the robot from an obstacle.
    Obstacles,
    /// The distance of parts of the robot from each other.
    SelfCollision,
    /// Any other quantity.
    Other,
}

impl Quantity {
    /// The quantities of a joint: its position with the derivatives in order, torque and power.
    pub const JOINT: [Self; 6] =
        [Self::Position, Self::Velocity, Self::Acceleration, Self::Jerk, Self::Torque, Self::Power];

    /// The name, which is that of keys.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Duration => "duration",
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
            Self::Torque => "torque",
            Self::Passive => "passive",
            Self::Power => "power",
            Self::Frame => "frame",
            Self::Foot => "foot",
            Self::Obstacles => "obstacles",
            Self::SelfCollision => "self_collision",
            Self::Other => "other",
        }
    }

    /// The name for a joint of this kind.
    #[must_use]
    pub fn name_for(self, kind: JointKind) -> &'static str {
        match self {
            Self::Torque | Self::Passive if kind == JointKind::Prismatic => "force",
            Self::Passive => Self::Torque.name(),
            other => other.name(),
        }
    }

    /// The unit for a joint of this kind; empty for a quantity without one, or with several.
    #[must_use]
    pub fn unit(self, kind: JointKind) -> &'static str {
        let [turns, slides] = match self {
            Self::Duration => ["s"; 2],
            Self::Position => ["rad", "m"],
            Self::Velocity => ["rad/s", "m/s"],
            Self::Acceleration => ["rad/s^2", "m/s^2"],
            Self::Jerk => ["rad/s^3", "m/s^3"],
            Self::Torque | Self::Passive => ["N m", "N"],
            Self::Power => ["W"; 2],
            Self::Obstacles | Self::SelfCollision => ["m"; 2],
            Self::Frame | Self::Foot | Self::Other => [""; 2],
        };
        if kind == JointKind::Prismatic { slides } else { turns }
    }

    /// The order of the derivative of the position that it is.
    #[must_use]
    pub fn order(self) -> Option<usize> {
        Self::JOINT[..4].iter().position(|of| *of == self)
    }

    /// Returns true if it is a distance that is far from its bound most of the time.
    #[must_use]
    pub fn is_clearance(self) -> bool {
        matches!(self, Self::Obstacles | Self::SelfCollision)
    }
}

/// The function of a quantity that a row is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RowForm {
    /// The distance from the bound.
    Linear,
    /// A length or a speed `x` within a bound `b`, by the row $x^2 - b^2$ of scale $2 b$.
    Square,
    /// An angle within this bound, rad, by the difference of the cosines of both, over the sine of the bound.
    Cosine(f64),
}

impl RowForm {
    /// The excess of the limited quantity over its bound, negative within, for a row divided by its
    /// [scale](super::Constraint::row_scales): the same number, but for squares and cosines, for which it is that to
    /// first order.
    #[must_use]
    pub fn excess(self, scaled: f64, scale: f64) -> f64 {
        match self {
            // A row without a value is violated without bound.
            _ if !scaled.is_finite() => scaled,
            Self::Linear => scaled,
            Self::Square => {
                let bound = 0.5 * scale;
                // The row is exact to rounding, so that a square may come out below zero.
                (scaled * scale + bound * bound).max(0.0).sqrt() - bound
            }
            Self::Cosine(bound) => {
                let (sin, cos) = bound.sin_cos();
                (cos - sin * scaled).clamp(-1.0, 1.0).acos() - bound
            }
        }
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
