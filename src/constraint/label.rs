//! The names and units of constraint rows.

use crate::model::{Joint, JointKind, Model};
use crate::scalar::Scalar;

/// The name, unit and kind of a row of a constraint, for a report.
#[derive(Clone, Debug, PartialEq)]
pub struct RowLabel {
    /// The limited quantity, such as `upper position limit of joint 'joint_2'`.
    pub name: String,
    /// The unit of the [excess](RowKind::excess); empty if unknown.
    pub unit: &'static str,
    /// The kind of the limited quantity.
    pub kind: RowKind,
}

impl RowLabel {
    /// The default label, which is the number of the row.
    #[must_use]
    pub fn numbered(row: usize) -> Self {
        Self { name: format!("row {row} of the constraint"), unit: "", kind: RowKind::Other }
    }
}

/// The kind of quantity that a row limits, with the index of the joint for limits of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// A length or a speed `x` within a bound `b`, by the row $x^2 - b^2$ of scale $2 b$.
    Square,
    /// An angle within this bound, rad, by the difference of the cosines of both, over the sine of the bound.
    Cosine(f64),
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
            Self::Clearance | Self::Square | Self::Cosine(_) | Self::Other => None,
        }
    }

    /// The excess of the limited quantity over its bound, negative within, for a row divided by its
    /// [scale](super::Constraint::row_scales): the same number, but for squares and cosines, for which it is that to
    /// first order.
    #[must_use]
    pub fn excess(self, scaled: f64, scale: f64) -> f64 {
        match self {
            // A row without a value is violated without bound.
            _ if !scaled.is_finite() => scaled,
            Self::Square => {
                let bound = 0.5 * scale;
                // The row is exact to rounding, so that a square may come out below zero.
                (scaled * scale + bound * bound).max(0.0).sqrt() - bound
            }
            Self::Cosine(bound) => {
                let (sin, cos) = bound.sin_cos();
                (cos - sin * scaled).clamp(-1.0, 1.0).acos() - bound
            }
            _ => scaled,
        }
    }
}

/// The unit of the joint: the first for a revolute joint, the second for a prismatic one.
pub(super) fn unit_of<C: Scalar>(joint: &Joint<C>, turning: &'static str, sliding: &'static str) -> &'static str {
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
