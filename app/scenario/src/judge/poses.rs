//! Goals and conditions on the way: the poses of frames, at the end or at all times.

use super::hermite::Model as Polynomial;
use super::intervals::{Bounded, Measured, Proof};
use super::{Check, Intervals, Outcome, Reach, Row, Worst, carriers};
use crate::keys::obstacles::Pose;
use crate::{AxisDirection, Goal, Kept, PointSpeed, Quantity, Scenario};
use aghf::dynamics::{forward_kinematics, frame_placement};
use aghf::error::{Error, Result};
use aghf::model::{Frame, JointKind, Model};
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// A quantity of a pose with its bounds.
pub(super) struct Measure {
    pub name: &'static str,
    value: f64,
    bounds: [f64; 2],
    unit: &'static str,
    /// True for an angle, which changes at most as much as the frame turns; otherwise the quantity changes at most as
    /// much as its origin moves.
    turns: bool,
}

impl Measure {
    pub fn worst(&self, at_s: f64) -> Worst {
        Worst::between(self.value, self.bounds, self.unit, at_s)
    }

    /// The excess over a bound.
    pub fn excess(&self) -> f64 {
        (self.bounds[0] - self.value).max(self.value - self.bounds[1])
    }
}

/// A set of poses with its frames on a robot.
pub(super) struct Poses<'a> {
    of: &'a Goal,
    model: &'a Model,
    frame: &'a Frame<f64>,
    /// The frame in whose axes the poses are; `None` for the base.
    reference: Option<&'a Frame<f64>>,
}

impl<'a> Poses<'a> {
    pub fn new(of: &'a Goal, model: &'a Model) -> Result<Self> {
        let reference = of.relative_to.as_ref().map(|name| frame_of(model, name));
        Ok(Self { of, model, frame: frame_of(model, &of.frame)?, reference: reference.transpose()? })
    }

    /// The joints that move the frame against the reference.
    fn path(&self) -> Vec<usize> {
        let one = carriers(self.model, self.frame.body);
        let other = carriers(self.model, self.reference.and_then(|frame| frame.body));
        let alone = |of: &[usize], beside: &[usize]| -> Vec<usize> {
            of.iter().filter(|i| !beside.contains(i)).copied().collect()
        };
        [alone(&one, &other), alone(&other, &one)].concat()
    }

    /// The origin of the frame in the base frame, and the quantities of its pose.
    pub fn at(&self, placements: &[Placement<f64>]) -> Result<(Vector3<f64>, Vec<Measure>)> {
        let frame = frame_placement(self.frame, placements)?;
        let reference = match self.reference {
            Some(reference) => frame_placement(reference, placements)?,
            None => Placement::identity(),
        };
        let back = reference.rotation.transpose();
        let position = back * (frame.translation - reference.translation);
        let rotation = back * frame.rotation;
        let mut measures = position_measures(self.of, &position);
        measures.extend(angle(self.of, &rotation));
        Ok((frame.translation, measures))
    }
}

fn frame_of<'m>(model: &'m Model, name: &str) -> Result<&'m Frame<f64>> {
    let mut frames = model.frames().iter();
    let missing = || Error::input(model.name(), name, "the robot has no such link");
    frames.find(|frame| frame.name == name).ok_or_else(missing)
}

/// The distance from a position, or the coordinates in a box.
fn position_measures(goal: &Goal, position: &Vector3<f64>) -> Vec<Measure> {
    let metres = |name, value, bounds| Measure { name, value, bounds, unit: "m", turns: false };
    if let Some(centre) = goal.position_m {
        let distance = (position - Vector3::from(centre)).norm();
        let most = goal.tolerance_m.unwrap_or(0.0);
        return vec![metres("distance", distance, [f64::NEG_INFINITY, most])];
    }
    let Some(within) = &goal.within else {
        return Vec::new();
    };
    let Pose { position_m, orientation_xyzw } = within.pose;
    let off = rotation_of(orientation_xyzw).transpose() * (position - Vector3::from(position_m));
    let names = ["x in the box", "y in the box", "z in the box"];
    let sides = names.into_iter().zip(&off).zip(within.size_m);
    sides
        .map(|((name, value), size)| {
            let half = size.map_or(f64::INFINITY, |size| 0.5 * size);
            metres(name, *value, [-half, half])
        })
        .collect()
}

/// The angle from an orientation or of an axis.
fn angle(goal: &Goal, rotation: &Matrix3<f64>) -> Option<Measure> {
    let (name, value) = if goal.orientation_xyzw.is_some() {
        let turn = rotation_of(goal.orientation_xyzw).transpose() * rotation;
        // Twice the sine and cosine of the angle, which is accurate near zero as well as near half a turn.
        let sines = Vector3::new(turn[(2, 1)] - turn[(1, 2)], turn[(0, 2)] - turn[(2, 0)], turn[(1, 0)] - turn[(0, 1)]);
        ("angle", sines.norm().atan2(turn.trace() - 1.0))
    } else {
        let AxisDirection { of_frame, direction } = goal.axis.as_ref()?;
        let (axis, to) = (rotation * Vector3::from(*of_frame), Vector3::from(*direction));
        ("angle of the axis", axis.cross(&to).norm().atan2(axis.dot(&to)))
    };
    Some(Measure {
        name,
        value,
        bounds: [f64::NEG_INFINITY, goal.tolerance_rad.unwrap_or(0.0)],
        unit: "rad",
        turns: true,
    })
}

fn rotation_of(xyzw: Option<[f64; 4]>) -> Matrix3<f64> {
    let Some([x, y, z, w]) = xyzw else {
        return Matrix3::identity();
    };
    let turn = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
    Rotation3::from(turn).into_inner()
}

/// The row of a goal at the last configuration, of the set that it misses least; `None` if the goal is none.
pub(super) fn goal_row(scenario: &Scenario, q: &[f64], at_s: f64, tolerance: f64) -> Result<Option<Row>> {
    let model = &scenario.model;
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements)?;
    let mut best: Option<(f64, Row)> = None;
    for goal in &scenario.file.goal {
        let mut row = Row::new(Check::GoalPosition, tolerance);
        let (_, measures) = Poses::new(goal, model)?.at(&placements)?;
        let mut most = f64::NEG_INFINITY;
        for measure in measures {
            most = most.max(measure.excess());
            row.take(measure.worst(at_s), || place_of(goal, &measure));
        }
        if best.as_ref().is_none_or(|(least, _)| most < *least) {
            best = Some((most, row));
        }
    }
    Ok(best.map(|(_, row)| row))
}

pub(super) fn place_of(goal: &Goal, measure: &Measure) -> String {
    format!("{} of frame '{}'", measure.name, goal.frame)
}

/// The rows of the conditions along the way.
pub(super) fn kept(scenario: &Scenario, intervals: &Intervals, tolerance: f64) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for kept in &scenario.file.keep {
        let mut proof = Proof::new(Row::new(Check::Bounds(Quantity::Frame), tolerance), intervals);
        if let Some(poses) = &kept.poses {
            kept_poses(&mut proof, scenario, kept, poses, intervals)?;
        }
        if let Some(speed) = &kept.speed {
            kept_speed(&mut proof, scenario, kept, speed)?;
        }
        if proof.row.worst.is_none() {
            proof.row.note = Some("the motion ends before it is kept".to_owned());
        }
        rows.push(proof.row);
    }
    Ok(rows)
}

/// Proves a set of poses at all times: in a part of an interval between two samples a quantity differs from the one in
/// its middle at most as much as the [bound](Reach) on the way of the origin, or the sum of the turns of the joints;
/// parts are halved until the quantity is within its bound by this.
fn kept_poses(
    proof: &mut Proof<'_>,
    scenario: &Scenario,
    kept: &Kept,
    goal: &Goal,
    intervals: &Intervals,
) -> Result<()> {
    let model = &scenario.model;
    let poses = Poses::new(goal, model)?;
    let (path, mut reach) = (poses.path(), Reach::new(model));
    let turning = |i: &&usize| model.joints()[**i].kind() != JointKind::Prismatic;
    proof.derived = false;
    for (k, joints) in intervals.joints.iter().enumerate() {
        let Some(part) = intervals.within(k, kept.times()) else {
            continue;
        };
        proof.cover(k, part, |proof, part| {
            let middle = 0.5 * (part[0] + part[1]);
            let ways: Vec<_> = joints.iter().map(|joint| joint.way_from_middle(part)).collect();
            reach.place(&intervals.at(0, k, middle))?;
            let (origin, measures) = poses.at(reach.placements())?;
            let way = reach.way(&origin, &path, &ways);
            let turn: f64 = path.iter().filter(turning).map(|i| ways[*i]).sum();
            let mut proved = true;
            for measure in measures {
                let at_s = intervals.time(k, middle);
                proof.row.take(measure.worst(at_s), || place_of(goal, &measure));
                let by = if measure.turns { turn } else { way };
                proved &= measure.excess() + by <= proof.row.tolerance;
            }
            Ok(proved || proof.row.outcome > Outcome::Pass)
        })?;
    }
    Ok(())
}

/// Proves a bound on the speed of a point.
fn kept_speed(proof: &mut Proof<'_>, scenario: &Scenario, kept: &Kept, bound: &PointSpeed) -> Result<()> {
    let model = &scenario.model;
    let frame = frame_of(model, &bound.frame)?;
    let path = carriers(model, frame.body);
    let constant = Polynomial::constant;
    let mut placements = vec![Placement::identity(); model.dof()];
    let place = |name: &str| format!("speed of frame '{name}'");
    proof.enclose(kept.times(), place, |[q, v, _]| {
        forward_kinematics(model, q, &mut placements)?;
        let of_frame = frame_placement(frame, &placements)?;
        let point = of_frame.rotation * Vector3::from(bound.point_m).map(constant);
        let point = point + of_frame.translation;
        let mut velocity = Vector3::zeros();
        for i in &path {
            let (joint, placement) = (&model.joints()[*i], &placements[*i]);
            let axis = placement.rotation * joint.axis().map(constant) * v[*i];
            velocity += match joint.kind() {
                JointKind::Prismatic => axis,
                _ => axis.cross(&(point - placement.translation)),
            };
        }
        Ok(vec![Measured {
            of: Bounded::of_length(&velocity),
            bounds: [f64::NEG_INFINITY, bound.most_m_s],
            unit: "m/s",
            place: &bound.frame,
        }])
    })
}
