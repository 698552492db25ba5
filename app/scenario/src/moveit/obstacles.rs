//! The obstacles of a planning scene.

use super::constraints::is_base;
use super::messages::{CollisionObject, Pose, Primitive, Scene};
use crate::keys::obstacles::unit_quaternion;
use crate::{Obstacle, ObstacleShape};
use aghf::error::{Error, Result};
use aghf::model::Model;
use nalgebra::{UnitQuaternion, Vector3};

/// The obstacles of a scene. `file` names the scene in errors.
pub(super) fn obstacles_of(scene: &Scene, model: &Model, file: &str) -> Result<Vec<Obstacle>> {
    let mut obstacles = Vec::new();
    for (i, object) in scene.world.collision_objects.iter().enumerate() {
        let element = format!("world.collision_objects[{i}] '{}'", object.id);
        let refuse = |element: String, condition: &str| Err(Error::input(file, element, condition));
        let CollisionObject { primitives, primitive_poses, .. } = object;
        let frame = &object.header.frame_id;
        if !is_base(frame, model) {
            let condition = format!("the frame '{frame}' is not the base, in which the pose of an object is needed");
            return refuse(format!("{element}.header.frame_id"), &condition);
        }
        if primitives.is_empty() {
            return refuse(element, "it has no primitives");
        }
        if primitives.len() != primitive_poses.len() {
            let (shapes, poses) = (primitives.len(), primitive_poses.len());
            let condition = format!("it has {shapes} primitives, but {poses} primitive_poses");
            return refuse(element, &condition);
        }
        for (j, (primitive, pose)) in primitives.iter().zip(primitive_poses).enumerate() {
            let element = format!("{element}.primitives[{j}]");
            let name = match primitives.len() {
                1 => object.id.clone(),
                _ => format!("{}[{j}]", object.id),
            };
            let made = obstacle(primitive, name, object.pose.as_ref(), pose);
            let made = made.map_err(|condition| Error::input(file, element, condition))?;
            obstacles.push(made);
        }
    }
    Ok(obstacles)
}

/// The pose of a primitive of an object in the frame of the scene.
fn pose_of(object: Option<&Pose>, primitive: &Pose) -> std::result::Result<crate::Pose, String> {
    let parts = |pose: &Pose| {
        let turn = unit_quaternion(pose.orientation.into())?;
        Ok::<_, String>((Vector3::from(pose.position), turn))
    };
    let (mut position, mut turn) = parts(primitive)?;
    if let Some(object) = object {
        let (outer, outer_turn) = parts(object)?;
        (position, turn) = (outer + outer_turn * position, outer_turn * turn);
    }
    Ok(crate::Pose {
        position_m: position.into(),
        orientation_xyzw: (turn != UnitQuaternion::identity()).then(|| turn.coords.into()),
    })
}

/// The obstacle of a primitive; an error describes its fault.
fn obstacle(
    primitive: &Primitive,
    name: String,
    object: Option<&Pose>,
    pose: &Pose,
) -> std::result::Result<Obstacle, String> {
    let dimensions = primitive.dimensions.as_slice();
    let kind = primitive.kind.name();
    let numbers = |wanted: &str| {
        let found = dimensions.len();
        format!("dimensions of a {kind} are {wanted}, but {found} numbers are given")
    };
    let pose = pose_of(object, pose)?;
    let shape = match kind.as_str() {
        "box" => {
            let size = dimensions.try_into();
            ObstacleShape::Box { size_m: size.map_err(|_| numbers("its three lengths"))? }
        }
        "cylinder" => {
            let size = dimensions.try_into();
            let [length_m, radius_m] = size.map_err(|_| numbers("its length and radius"))?;
            ObstacleShape::Cylinder { radius_m, length_m }
        }
        "sphere" => {
            let size = dimensions.try_into();
            let [radius_m] = size.map_err(|_| numbers("its radius"))?;
            ObstacleShape::Sphere { radius_m }
        }
        other => {
            return Err(format!("type is '{other}'; boxes, cylinders and spheres alone are read"));
        }
    };
    let obstacle = Obstacle { name: Some(name), shape, pose, clearance_m: None };
    obstacle.solid()?;
    Ok(obstacle)
}
