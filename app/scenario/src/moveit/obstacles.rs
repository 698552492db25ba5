//! The obstacles of a planning scene.

use super::messages::{CollisionObject, Pose, Primitive, Scene};
use crate::obstacles::{Obstacle, unit_quaternion};
use crate::{BoxObstacle, CylinderObstacle, ScenarioFile, SphereObstacle};
use aghf::error::{Error, Result};
use nalgebra::{UnitQuaternion, Vector3};

/// Adds the obstacles of a scene to a scenario. `file` names the scene in errors.
pub(super) fn add_obstacles(scene: &Scene, file: &str, to: &mut ScenarioFile) -> Result<()> {
    let octomap = scene.world.octomap.as_ref();
    let data = octomap.and_then(|map| map.pointer("/octomap/data"));
    if data.is_some_and(|data| data.as_array().is_none_or(|cells| !cells.is_empty())) {
        let condition =
            "it is a map of occupied cells; boxes, cylinders and spheres alone are read";
        return Err(Error::input(file, "world.octomap", condition));
    }
    for (i, object) in scene.world.collision_objects.iter().enumerate() {
        let element = format!("world.collision_objects[{i}] '{}'", object.id);
        let refuse = |element: String, condition: &str| Err(Error::input(file, element, condition));
        let CollisionObject {
            primitives,
            primitive_poses,
            ..
        } = object;
        for (list, what) in [(&object.meshes, "meshes"), (&object.planes, "planes")] {
            if !list.is_empty() {
                let condition =
                    format!("it has {what}; boxes, cylinders and spheres alone are read");
                return refuse(element, &condition);
            }
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
            let placed = place(object.pose.as_ref(), pose);
            let added = placed.and_then(|placed| add(primitive, name, placed, to));
            added.or_else(|condition| refuse(element, &condition))?;
        }
    }
    Ok(())
}

/// The pose of a shape in the frame of the scene.
type Placed = (Vector3<f64>, UnitQuaternion<f64>);

fn place(object: Option<&Pose>, primitive: &Pose) -> std::result::Result<Placed, String> {
    let parts = |pose: &Pose| {
        let turn = unit_quaternion(pose.orientation.into())?;
        Ok::<_, String>((Vector3::from(pose.position), turn))
    };
    let (inner, inner_turn) = parts(primitive)?;
    let Some(object) = object else {
        return Ok((inner, inner_turn));
    };
    let (outer, turn) = parts(object)?;
    Ok((outer + turn * inner, turn * inner_turn))
}

/// Adds a shape; an error describes its fault.
fn add(
    primitive: &Primitive,
    name: String,
    (center, turn): Placed,
    to: &mut ScenarioFile,
) -> std::result::Result<(), String> {
    let name = Some(name);
    let center_m = center.into();
    let orientation_xyzw = (turn != UnitQuaternion::identity()).then(|| turn.coords.into());
    let dimensions = primitive.dimensions.as_slice();
    let kind = primitive.kind.name();
    let numbers = |wanted: &str| {
        let found = dimensions.len();
        format!("dimensions of a {kind} are {wanted}, but {found} numbers are given")
    };
    match kind.as_str() {
        "box" => {
            let size = dimensions
                .try_into()
                .map_err(|_| numbers("its three lengths"))?;
            let obstacle = BoxObstacle {
                name,
                center_m,
                size_m: size,
                orientation_xyzw,
            };
            obstacle.placed()?;
            to.box_obstacles.push(obstacle);
        }
        "cylinder" => {
            let [length_m, radius_m] = dimensions
                .try_into()
                .map_err(|_| numbers("its length and radius"))?;
            let obstacle = CylinderObstacle {
                name,
                center_m,
                radius_m,
                length_m,
                orientation_xyzw,
            };
            obstacle.placed()?;
            to.cylinder_obstacles.push(obstacle);
        }
        "sphere" => {
            let [radius_m] = dimensions.try_into().map_err(|_| numbers("its radius"))?;
            let obstacle = SphereObstacle {
                name,
                center_m,
                radius_m,
            };
            obstacle.placed()?;
            to.sphere_obstacles.push(obstacle);
        }
        other => {
            return Err(format!(
                "type is '{other}'; boxes, cylinders and spheres alone are read"
            ));
        }
    }
    Ok(())
}
