//! A standing foot: the force of the ground by the laws of Newton and Euler, body by body.

use super::hermite::Model;
use super::intervals::{Bounded, Measured, Proof};
use super::{Check, Intervals, Row};
use crate::{Quantity, Scenario, Stand};
use aghf::dynamics::forward_kinematics;
use aghf::error::{Error, Result};
use aghf::model::{JointKind, Model as Robot};
use aghf::scalar::Zero;
use aghf::spatial::{Inertia, Placement};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Proves the bounds on the force of the ground at all times; `None` without a foot.
pub(super) fn standing(scenario: &Scenario, intervals: &Intervals, tolerance: f64) -> Result<Option<Row>> {
    let Some(stand) = &scenario.file.stand else {
        return Ok(None);
    };
    let model = &scenario.model;
    let (middle, axes) = sole(stand, model)?;
    let (middle, axes) = (middle.map(Model::constant), axes.transpose().map(Model::constant));
    let mut proof = Proof::new(Row::new(Check::Bounds(Quantity::Foot), tolerance), intervals);
    let throughout = [f64::NEG_INFINITY, f64::INFINITY];
    let place = |name: &str| format!("{name} of foot '{}'", stand.frame);
    proof.enclose(throughout, place, |[q, v, a]| {
        let (force, moment) = ground(model, q, v, a)?;
        let moment = axes * (moment - middle.cross(&force));
        Ok(measures(stand, &(axes * force), &moment))
    })?;
    Ok(Some(proof.row))
}

/// The middle of the sole and its axes in the base frame.
fn sole(stand: &Stand, model: &Robot) -> Result<(Vector3<f64>, Matrix3<f64>)> {
    let mut frames = model.frames().iter();
    let missing = || Error::input(model.name(), &*stand.frame, "the robot has no such link");
    let link = frames.find(|frame| frame.name == stand.frame);
    let link = link.ok_or_else(missing)?.placement;
    let Some(pose) = &stand.sole else {
        return Ok((link.translation, link.rotation));
    };
    let [x, y, z, w] = pose.orientation_xyzw.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    Ok((
        link.translation + link.rotation * Vector3::from(pose.position_m),
        link.rotation * turn.to_rotation_matrix().matrix(),
    ))
}

/// The quantities of a force and a moment in the axes of the sole with their bounds and units.
fn measures(stand: &Stand, force: &Vector3<Model>, moment: &Vector3<Model>) -> Vec<Measured<'static>> {
    let (up, none) = (Bounded::of(&force.z), f64::NEG_INFINITY);
    let over = |of: Model| Bounded::of(&(of / force.z));
    let (l, b) = (stand.half_length_m, stand.half_width_m);
    let slip = Bounded::of_length(&Vector3::new(force.x / force.z, force.y / force.z, Model::zero()));
    let all = [
        Some(("normal force", up, [0.0, f64::INFINITY], "N")),
        Some(("centre of pressure along", over(-moment.y), [-l, l], "m")),
        Some(("centre of pressure across", over(moment.x), [-b, b], "m")),
        Some(("friction", slip, [none, stand.friction], "")),
        (stand.torsion).map(|most| ("torsion", over(moment.z), [-most, most], "m")),
    ];
    let all = all.into_iter().flatten();
    all.map(|(place, of, bounds, unit)| Measured { of, bounds, unit, place }).collect()
}

/// The motion of a body: its angular velocity and acceleration, and the acceleration of its origin.
#[derive(Clone, Copy)]
struct Moving {
    turn: Vector3<Model>,
    turn_rate: Vector3<Model>,
    acceleration: Vector3<Model>,
}

impl Moving {
    /// The base at rest.
    fn base() -> Self {
        Self { turn: Vector3::zeros(), turn_rate: Vector3::zeros(), acceleration: Vector3::zeros() }
    }

    /// The acceleration of a point of the body at `r` from its origin.
    fn at(&self, r: &Vector3<Model>) -> Vector3<Model> {
        self.acceleration + self.turn_rate.cross(r) + self.turn.cross(&self.turn.cross(r))
    }
}

/// The force of the ground and its moment about the origin of the base: the sums over all bodies of mass times
/// acceleration less gravity, and of the moments of these with the rates of the angular momenta.
fn ground(model: &Robot, q: &[Model], v: &[Model], a: &[Model]) -> Result<(Vector3<Model>, Vector3<Model>)> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements)?;
    let still = Placement::identity();
    let (mut force, mut moment) = of_body(model, &Moving::base(), model.base_inertia(), &still);
    let mut moving: Vec<Moving> = Vec::with_capacity(model.dof());
    for (i, joint) in model.joints().iter().enumerate() {
        let (parent, from) = match joint.parent() {
            Some(parent) => (moving[parent], placements[parent].translation),
            None => (Moving::base(), Vector3::zeros()),
        };
        let axis = placements[i].rotation * joint.axis().map(Model::constant);
        let rate = axis * v[i];
        let mut own = Moving { acceleration: parent.at(&(placements[i].translation - from)), ..parent };
        match joint.kind() {
            JointKind::Prismatic => {
                own.acceleration += axis * a[i] + parent.turn.cross(&rate) * Model::constant(2.0);
            }
            JointKind::Revolute | JointKind::Continuous => {
                own.turn += rate;
                own.turn_rate += axis * a[i] + parent.turn.cross(&rate);
            }
        }
        let (of_body, about) = of_body(model, &own, &model.inertias()[i], &placements[i]);
        force += of_body;
        moment += about;
        moving.push(own);
    }
    Ok((force, moment))
}

/// The force on a body and its moment about the origin of the base.
fn of_body(
    model: &Robot,
    moving: &Moving,
    inertia: &Inertia<f64>,
    placement: &Placement<Model>,
) -> (Vector3<Model>, Vector3<Model>) {
    let Inertia { mass, first_moment, rotational } = inertia;
    let c = if *mass > 0.0 { first_moment / *mass } else { Vector3::zeros() };
    // Steiner's theorem, backwards.
    let about_centre = rotational - (Matrix3::identity() * c.dot(&c) - c * c.transpose()) * *mass;
    let constant = Model::constant;
    let about_centre = placement.rotation * about_centre.map(constant) * placement.rotation.transpose();
    let r = placement.rotation * c.map(constant);
    let force = (moving.at(&r) - model.gravity().map(constant)) * constant(*mass);
    let spin = about_centre * moving.turn_rate + moving.turn.cross(&(about_centre * moving.turn));
    (force, (placement.translation + r).cross(&force) + spin)
}
