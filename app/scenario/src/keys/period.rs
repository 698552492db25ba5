//! Periodic walks.

use crate::ScenarioFile;
use crate::keys::phases::{PhaseTerms, WalkPhase, robot_of_phase};
use aghf::direct::Period;
use aghf::dynamics::{Data, forward_kinematics, rnea};
use aghf::error::{Error, Result};
use aghf::model::{JointKind, Model};
use aghf::spatial::Placement;
use nalgebra::Vector3;
use std::path::Path;

/// The accepted difference of two mirrored joints, m and rad: that of numbers in files, far below a joint's size.
const MIRRORED: f64 = 1e-3;

/// The accepted relative difference of the torques on both sides of a robot: inertias are rarely known better.
const ALIKE: f64 = 0.05;

/// A joint at zero positions: the kind, a point of its axis, and the axis, in the frame of the foot.
struct Axis {
    kind: JointKind,
    point: Vector3<f64>,
    axis: Vector3<f64>,
}

/// The relation between the ends of a periodic walk, completed by those of its keys that follow from it; `path` names
/// the scenario in errors, and the robot is looked for in `folder`. `None` for a walk that is not periodic.
///
/// With the first foot on the ground again the motion ends as it starts. With another one it ends in the mirror image
/// of its start: with the positions and velocities of the joints of the other side, relative to the other foot.
pub(crate) fn period_of(
    file: &mut ScenarioFile,
    model: &Model,
    phases: &[PhaseTerms],
    (path, folder): (&str, &Path),
) -> Result<Option<Period>> {
    let (true, Some(first)) = (file.periodic, file.phases.first()) else {
        return Ok(None);
    };
    let refuse = |key: &str, condition: &str| Err(Error::input(path, key, condition));
    let Some(land) = file.phases.last().and_then(|last| last.land.as_ref()) else {
        return refuse("periodic", "the last phase has no landing");
    };
    let n = model.dof();
    let period = if land.frame == first.stand.frame {
        Period { joints: (0..n).collect(), signs: vec![1.0; n] }
    } else {
        let lands = |phase: &&WalkPhase| phase.stand.frame == land.frame;
        let known = file.phases.iter().position(|phase| lands(&phase));
        let (other, order) = match known.and_then(|k| phases.get(k)) {
            Some(terms) => (terms.model.clone(), terms.order.clone()),
            None => {
                let mut stand = first.stand.clone();
                stand.frame.clone_from(&land.frame);
                robot_of_phase(file, model, &stand, (path, folder))?
            }
        };
        let of_key = |condition: String| Error::input(path, "periodic", condition);
        let period = mirrored(model, (&other, &order)).map_err(of_key)?;
        if file.q_start.len() == n {
            let off = asymmetry(model, (&other, &order), &period, &file.q_start)?;
            if off > ALIKE {
                return Err(of_key(format!(
                    "the torques that hold q_start and its mirror image differ by {:.0} %, at most {:.0} % are \
                     accepted, as the next step would be another motion; steps of both feet need no mirror image",
                    100.0 * off,
                    100.0 * ALIKE
                )));
            }
        }
        period
    };
    for (key, start, end) in [("q_goal", &file.q_start, &mut file.q_goal), ("v_goal", &file.v_start, &mut file.v_goal)]
    {
        if start.len() != n {
            // A start of the wrong length is refused elsewhere, by its own key.
            return Ok(None);
        }
        let follows = period.end_of(start);
        if !end.is_empty() && *end != follows {
            return refuse(key, "that of a periodic walk follows from its start");
        }
        *end = follows;
    }
    Ok(Some(period))
}

/// The relation by which each joint takes over the position of its mirror image, from the robot on its first foot to
/// that on another one, whose joints are in another order.
fn mirrored(model: &Model, (other, order): (&Model, &[usize])) -> std::result::Result<Period, String> {
    let of_robot = |model: &Model| axes(model).map_err(|e| e.to_string());
    let (own, others) = (of_robot(model)?, of_robot(other)?);
    let n = model.dof();
    let mut period = Period { joints: vec![n; n], signs: vec![1.0; n] };
    for (from, joint) in own.iter().enumerate() {
        let point = reflected(&joint.point);
        // A rotation is reversed by a reflection, a translation is not.
        let axis = match joint.kind {
            JointKind::Prismatic => reflected(&joint.axis),
            _ => -reflected(&joint.axis),
        };
        let alike = others.iter().enumerate().filter_map(|(k, of)| {
            let between = of.point - point;
            let off = match of.kind {
                JointKind::Prismatic => 0.0,
                _ => between.cross(&of.axis).norm(),
            };
            let sign = of.axis.dot(&axis).signum();
            let turned = (of.axis * sign - axis).norm();
            let is_free = period.joints[order[k]] == n;
            let is_alike = is_free && of.kind == joint.kind && off.max(turned) <= MIRRORED;
            is_alike.then_some((between.norm(), order[k], sign))
        });
        let nearest = alike.min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, to, sign)) = nearest else {
            let name = model.joints()[from].name();
            return Err(format!("joint '{name}' has no mirror image on the other side"));
        };
        (period.joints[to], period.signs[to]) = (from, sign);
    }
    Ok(period)
}

/// The difference of the torques that hold a configuration and its mirror image, relative to their norm.
fn asymmetry(model: &Model, (other, order): (&Model, &[usize]), period: &Period, q: &[f64]) -> Result<f64> {
    let still = vec![0.0; model.dof()];
    let held = |model: &Model, q: &[f64]| {
        let mut torques = still.clone();
        let found = rnea(model, &mut Data::new(model), q, &still, &still, &mut torques);
        found.map(|()| torques)
    };
    let mirrored = period.end_of(q);
    let sorted: Vec<_> = order.iter().map(|joint| mirrored[*joint]).collect();
    let (own, others) = (held(model, q)?, held(other, &sorted)?);
    let expected = period.end_of(&own);
    let pairs = order.iter().zip(&others);
    let squares: f64 = pairs.map(|(joint, u)| (u - expected[*joint]).powi(2)).sum();
    let norm = own.iter().map(|u| u * u).sum::<f64>();
    Ok((squares / norm.max(f64::MIN_POSITIVE)).sqrt())
}

/// The mirror image of a vector in the plane between the sides of a robot that faces along `x`.
fn reflected(of: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(of.x, -of.y, of.z)
}

/// The joints of a robot at zero positions.
fn axes(model: &Model) -> Result<Vec<Axis>> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, &vec![0.0; model.dof()], &mut placements)?;
    let joints = model.joints().iter().zip(&placements);
    let all = joints.map(|(joint, placement)| Axis {
        kind: joint.kind(),
        point: placement.translation,
        axis: placement.rotation * joint.axis(),
    });
    Ok(all.collect())
}
