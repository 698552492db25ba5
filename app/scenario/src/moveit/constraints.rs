//! The goal and the conditions along the way of a planning request.

use super::messages::{Constraints, OrientationConstraint, PositionConstraint, Request};
use crate::keys::goal::PositionBox;
use crate::keys::obstacles::{Pose as PoseOfKey, unit_quaternion};
use crate::{AxisDirection, Goal, Kept, PointSpeed};
use aghf::error::{Error, Result, plain};
use aghf::model::Model;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// The goal of a request.
pub(super) enum Target {
    /// The positions of joints by name.
    Joints(BTreeMap<String, f64>),
    /// Sets of poses, of which one is to be reached.
    Poses(Vec<Goal>),
}

impl Target {
    /// Reads the goal: positions of joints, or any of several sets of poses.
    pub fn of(request: &Request, model: &Model, file: &str) -> Result<Self> {
        let goals = "goal_constraints";
        if let [only] = request.goal_constraints.as_slice()
            && !only.has_poses()
        {
            return positions(only, model, file, &format!("{goals}[0]")).map(Self::Joints);
        }
        if request.goal_constraints.is_empty() {
            return Err(Error::input(file, goals, "it has no goal"));
        }
        let sets = request.goal_constraints.iter().enumerate();
        let sets = sets.map(|(i, goal)| {
            let key = format!("{goals}[{i}]");
            let refuse = |condition: &str| Err(Error::input(file, &key, condition));
            if !goal.joint_constraints.is_empty() {
                return refuse("a goal by pose has no positions of joints, and one of several is by pose");
            }
            let mut sets = poses(goal, model, file, &key)?;
            match (sets.pop(), sets.pop()) {
                (Some(only), None) => Ok(only),
                (Some(orientation), Some(position)) if sets.is_empty() && both_fit(&position, &orientation) => {
                    Ok(Goal {
                        orientation_xyzw: orientation.orientation_xyzw,
                        axis: orientation.axis,
                        tolerance_rad: orientation.tolerance_rad,
                        ..position
                    })
                }
                (None, _) => refuse("it has no position and no orientation"),
                _ => refuse("one position and one orientation of one link in one frame are read"),
            }
        });
        sets.collect::<Result<_>>().map(Self::Poses)
    }
}

/// Reads the conditions along the way.
pub(super) fn kept(request: &Request, model: &Model, file: &str) -> Result<Vec<Kept>> {
    let Some(constraints) = &request.path_constraints else {
        return Ok(Vec::new());
    };
    let key = "path_constraints";
    if !constraints.joint_constraints.is_empty() {
        let condition = "joint positions along the path are not supported";
        return Err(Error::input(file, format!("{key}.joint_constraints"), condition));
    }
    let sets = poses(constraints, model, file, key)?.into_iter();
    let kept = sets.map(|poses| throughout(Some(poses), None));
    Ok(kept.collect())
}

/// The speed of a link that a request limits.
pub(super) fn kept_speed(request: &Request, model: &Model, file: &str) -> Result<Option<Kept>> {
    let (most_m_s, link) = (request.max_cartesian_speed, &request.cartesian_speed_limited_link);
    if most_m_s <= 0.0 {
        return Ok(None);
    }
    if model.frames().iter().all(|frame| frame.name != *link) {
        let condition = match link.as_str() {
            "" => "it is needed with a max_cartesian_speed".to_owned(),
            _ => format!("the robot has no link '{link}'"),
        };
        return Err(Error::input(file, "cartesian_speed_limited_link", condition));
    }
    let speed = PointSpeed { frame: link.clone(), point_m: [0.0; 3], most_m_s };
    Ok(Some(throughout(None, Some(speed))))
}

fn throughout(poses: Option<Goal>, speed: Option<PointSpeed>) -> Kept {
    Kept { poses, speed, from_s: None, to_s: None }
}

/// Returns true if a position and an orientation are those of one link in one frame.
fn both_fit(position: &Goal, orientation: &Goal) -> bool {
    let has_position = |of: &Goal| of.position_m.is_some() || of.within.is_some();
    has_position(position)
        && !has_position(orientation)
        && position.frame == orientation.frame
        && position.relative_to == orientation.relative_to
}

/// The sets of poses of constraints at `key`: those of positions, then those of orientations.
fn poses(constraints: &Constraints, model: &Model, file: &str, key: &str) -> Result<Vec<Goal>> {
    let positions = constraints.position_constraints.iter().enumerate();
    let positions = positions.map(|(i, of)| of.set(model, file, &format!("{key}.position_constraints[{i}]")));
    let orientations = constraints.orientation_constraints.iter().enumerate();
    let orientations = orientations.map(|(i, of)| of.set(model, file, &format!("{key}.orientation_constraints[{i}]")));
    positions.chain(orientations).collect()
}

/// Returns true if a frame of this name is the base.
pub(super) fn is_base(name: &str, model: &Model) -> bool {
    let root = model.frames().iter().find(|frame| frame.carrier.is_none());
    name.is_empty() || name == "world" || root.is_some_and(|root| root.name == name)
}

/// Any pose of a link in a frame, which is the base or another link.
fn any_pose(link: &str, frame: &str, model: &Model, file: &str, key: &str) -> Result<Goal> {
    let of_robot = model.frames().iter().any(|known| known.name == frame);
    if !is_base(frame, model) && !of_robot {
        let condition = format!("the frame '{frame}' is neither the base nor a link of the robot");
        return Err(Error::input(file, format!("{key}.header.frame_id"), condition));
    }
    Ok(Goal {
        frame: link.to_owned(),
        relative_to: (!is_base(frame, model)).then(|| frame.to_owned()),
        position_m: None,
        tolerance_m: None,
        within: None,
        orientation_xyzw: None,
        axis: None,
        tolerance_rad: None,
    })
}

impl PositionConstraint {
    fn set(&self, model: &Model, file: &str, key: &str) -> Result<Goal> {
        let refuse = |element: &str, condition: String| Err(Error::input(file, format!("{key}.{element}"), condition));
        let any = any_pose(&self.link_name, &self.header.frame_id, model, file, key)?;
        let offset: Vector3<f64> = self.target_point_offset.map_or_else(Vector3::zeros, Vector3::from);
        if offset != Vector3::zeros() {
            let condition = "the origin of the link is meant, without an offset".to_owned();
            return refuse("target_point_offset", condition);
        }
        let region = &self.constraint_region;
        let element = "constraint_region";
        let ([primitive], [pose]) = (region.primitives.as_slice(), region.primitive_poses.as_slice()) else {
            return refuse(element, "one primitive with its pose is read".to_owned());
        };
        let position_m: [f64; 3] = Vector3::from(pose.position).into();
        match (primitive.kind.name().as_str(), primitive.dimensions.as_slice()) {
            ("sphere", [radius]) => {
                Ok(Goal { position_m: Some(position_m), tolerance_m: (*radius != 0.0).then_some(*radius), ..any })
            }
            ("box", [x, y, z]) => Ok(Goal {
                within: Some(PositionBox {
                    size_m: [*x, *y, *z].map(Some),
                    pose: PoseOfKey { position_m, orientation_xyzw: Some(pose.orientation.into()) },
                }),
                ..any
            }),
            (kind, dimensions) => {
                let count = dimensions.len();
                let condition = format!("a sphere or a box is read, not a {kind} of {count} dimensions");
                refuse(element, condition)
            }
        }
    }
}

impl OrientationConstraint {
    /// All rotations within the smallest tolerance. About an axis with a tolerance of half a turn or more the link
    /// turns freely, so that the axis keeps its direction.
    fn set(&self, model: &Model, file: &str, key: &str) -> Result<Goal> {
        let any = any_pose(&self.link_name, &self.header.frame_id, model, file, key)?;
        let refuse = |element: &str, condition: String| Err(Error::input(file, format!("{key}.{element}"), condition));
        let by_axis = [
            ("absolute_x_axis_tolerance", self.absolute_x_axis_tolerance),
            ("absolute_y_axis_tolerance", self.absolute_y_axis_tolerance),
            ("absolute_z_axis_tolerance", self.absolute_z_axis_tolerance),
        ];
        if let Some((element, by)) = by_axis.iter().find(|(_, by)| by.is_nan() || *by < 0.0) {
            let condition = format!("it is {} and must be at least zero", plain(*by));
            return refuse(element, condition);
        }
        // A rotation vector within the tolerances is no turn about the free axis and a small one about the others.
        let most = u8::from(by_axis.iter().all(|(_, by)| *by < PI));
        if self.parameterization > most {
            let number = self.parameterization;
            let condition = format!("it is {number}; 0 is read, and 1 where no tolerance is half a turn");
            return refuse("parameterization", condition);
        }
        let free: Vec<usize> = (0..3).filter(|i| by_axis[*i].1 >= PI).collect();
        let least = by_axis.iter().map(|(_, by)| *by).fold(f64::INFINITY, f64::min);
        let tolerance_rad = (least > 0.0).then_some(least);
        let orientation: [f64; 4] = self.orientation.into();
        match free.as_slice() {
            [] => Ok(Goal { orientation_xyzw: Some(orientation), tolerance_rad, ..any }),
            [axis] => {
                let rotation = match unit_quaternion(orientation) {
                    Ok(rotation) => rotation,
                    Err(condition) => return refuse("orientation", condition),
                };
                let of_frame = Vector3::ith(*axis, 1.0);
                Ok(Goal {
                    axis: Some(AxisDirection { of_frame: of_frame.into(), direction: (rotation * of_frame).into() }),
                    tolerance_rad,
                    ..any
                })
            }
            _ => refuse(by_axis[free[1]].0, "at most one axis is free".to_owned()),
        }
    }
}

/// The positions of joints at the goal.
fn positions(goal: &Constraints, model: &Model, file: &str, key: &str) -> Result<BTreeMap<String, f64>> {
    if goal.joint_constraints.is_empty() {
        let condition = "it has no joint_constraints, position_constraints or orientation_constraints";
        return Err(Error::input(file, key, condition));
    }
    let mut positions = BTreeMap::new();
    for (i, joint) in goal.joint_constraints.iter().enumerate() {
        let key = format!("{key}.joint_constraints[{i}]");
        let name = &joint.joint_name;
        if model.joints().iter().all(|joint| joint.name() != name) {
            return Err(Error::input(file, key, model.no_moving_joint(name)));
        }
        if positions.insert(name.clone(), joint.position).is_some() {
            return Err(Error::input(file, key, format!("joint '{name}' is named twice")));
        }
    }
    Ok(positions)
}
