//! A standing foot: the force of the ground by the laws of Newton and Euler, body by body.

use super::{Check, Intervals, Row, Trajectory, Worst};
use crate::{Scenario, Stand};
use aghf::dynamics::forward_kinematics;
use aghf::error::{Error, Result};
use aghf::model::{JointKind, Model};
use aghf::spatial::{Inertia, Placement};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Checks the force of the ground at the samples, with their accelerations, and halfway between them; `None` without a
/// foot.
pub(super) fn standing(
    scenario: &Scenario,
    trajectory: &Trajectory,
    intervals: &Intervals,
    tolerance: f64,
) -> Result<Option<Row>> {
    let Some(stand) = &scenario.file.stand else {
        return Ok(None);
    };
    let model = &scenario.model;
    let (middle, axes) = sole(stand, model)?;
    let mut row = Row::new(Check::Foot, tolerance);
    let mut take = |q: &[f64], v: &[f64], a: &[f64], at_s: f64| -> Result<()> {
        let (force, moment) = ground(model, q, v, a)?;
        let moment = axes.transpose() * (moment - middle.cross(&force));
        for (name, value, bounds, unit) in measures(stand, &(axes.transpose() * force), &moment) {
            let place = || format!("{name} of foot '{}'", stand.frame);
            row.take(Worst::between(value, bounds, unit, at_s), place);
        }
        Ok(())
    };
    let Trajectory { times, q, v, a, .. } = trajectory;
    for k in 0..times.len() {
        take(&q[k], &v[k], &a[k], times[k] - times[0])?;
    }
    for (k, cubics) in intervals.cubics.iter().enumerate() {
        let [q, v, a]: [Vec<f64>; 3] = [
            cubics.iter().map(|c| c.position(0.5)).collect(),
            cubics.iter().map(|c| c.velocity(0.5)).collect(),
            cubics.iter().map(|c| c.acceleration(0.5)).collect(),
        ];
        take(&q, &v, &a, intervals.time(k, 0.5))?;
    }
    Ok(Some(row))
}

/// The middle of the sole and its axes in the base frame.
fn sole(stand: &Stand, model: &Model) -> Result<(Vector3<f64>, Matrix3<f64>)> {
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
fn measures(
    stand: &Stand,
    force: &Vector3<f64>,
    moment: &Vector3<f64>,
) -> Vec<(&'static str, f64, [f64; 2], &'static str)> {
    let (up, none) = (force.z, f64::NEG_INFINITY);
    let (l, b) = (stand.half_length_m, stand.half_width_m);
    let slip = force.xy().norm() / up;
    let mut all = vec![
        ("normal force", up, [0.0, f64::INFINITY], "N"),
        ("centre of pressure along", -moment.y / up, [-l, l], "m"),
        ("centre of pressure across", moment.x / up, [-b, b], "m"),
        ("friction", slip, [none, stand.friction], ""),
    ];
    if let Some(most) = stand.torsion {
        all.push(("torsion", (moment.z / up).abs(), [none, most], "m"));
    }
    all
}

/// The motion of a body: its angular velocity and acceleration, and the acceleration of its origin.
#[derive(Clone, Copy, Default)]
struct Moving {
    turn: Vector3<f64>,
    turn_rate: Vector3<f64>,
    acceleration: Vector3<f64>,
}

impl Moving {
    /// The acceleration of a point of the body at `r` from its origin.
    fn at(&self, r: &Vector3<f64>) -> Vector3<f64> {
        self.acceleration + self.turn_rate.cross(r) + self.turn.cross(&self.turn.cross(r))
    }
}

/// The force of the ground and its moment about the origin of the base: the sums over all bodies of mass times
/// acceleration less gravity, and of the moments of these with the rates of the angular momenta.
fn ground(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> Result<(Vector3<f64>, Vector3<f64>)> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements)?;
    let still = Placement::identity();
    let (mut force, mut moment) = of_body(model, &Moving::default(), model.base_inertia(), &still);
    let mut moving: Vec<Moving> = Vec::with_capacity(model.dof());
    for (i, joint) in model.joints().iter().enumerate() {
        let (parent, from) = match joint.parent() {
            Some(parent) => (moving[parent], placements[parent].translation),
            None => Default::default(),
        };
        let axis = placements[i].rotation * joint.axis();
        let rate = axis * v[i];
        let mut own = Moving {
            acceleration: parent.at(&(placements[i].translation - from)),
            ..parent
        };
        match joint.kind() {
            JointKind::Prismatic => {
                own.acceleration += axis * a[i] + parent.turn.cross(&rate) * 2.0;
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
    model: &Model,
    moving: &Moving,
    inertia: &Inertia<f64>,
    placement: &Placement<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let Inertia {
        mass,
        first_moment,
        rotational,
    } = inertia;
    let c = if *mass > 0.0 {
        first_moment / *mass
    } else {
        Vector3::zeros()
    };
    // Steiner's theorem, backwards.
    let about_centre = rotational - (Matrix3::identity() * c.dot(&c) - c * c.transpose()) * *mass;
    let about_centre = placement.rotation * about_centre * placement.rotation.transpose();
    let r = placement.rotation * c;
    let force = (moving.at(&r) - model.gravity()) * *mass;
    let spin = about_centre * moving.turn_rate + moving.turn.cross(&(about_centre * moving.turn));
    (force, (placement.translation + r).cross(&force) + spin)
}
