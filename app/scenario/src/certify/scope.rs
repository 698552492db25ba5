//! The parts of a scenario that a certificate covers.

use super::LEFT_OUT;
use crate::promise::{Role, roles};
use crate::{ObstacleShape, Quantity, RobotShape, Scenario, sha256};
use aghf::error::{Error, Result};
use aghf::geometry::Shape;
use aghf::input::read_bytes;
use aghf::model::{Collision, CollisionShape};
use aghf::urdf::mesh_path;
use std::collections::BTreeMap;
use urdf_rs::Geometry;

const PROVED: &str = "proved";
const ASSUMED: &str = "assumed";
const NO_PROMISE: &str = "no promise";

/// The reason why clearances are left out.
const LOAD: &str = "the robot consists of balls and its load does not; that of a load that is a ball can be certified";

/// The keys of a scenario and those that promise something by default, each with its outcome, and constraints that were
/// added in code. Clearances are known of a robot of `shapes`, or one of balls.
pub(super) fn keys(scenario: &Scenario, shapes: bool) -> Result<BTreeMap<String, String>> {
    let is_known = shapes || has_balls(scenario);
    let own = scenario.added_constraints();
    let written = serde_json::to_value(&scenario.file);
    let written = written.map_err(|e| Error::input("certify", "scenario", e.to_string()))?;
    let by_default = ["continuity", "enforced_limits", "self_collision"];
    let mut all = roles(scenario);
    all.retain(|(key, _)| written.get(key).is_some() || by_default.contains(key));
    let all = all.into_iter().map(|(key, role)| (key.to_owned(), outcome(&role, is_known)));
    let mut all: BTreeMap<String, String> = all.collect();
    if own > 0 {
        let reason = format!("{LEFT_OUT}no key of the scenario has these, {own} in number");
        all.insert("constraints added in code".to_owned(), reason);
    }
    Ok(all)
}

/// The outcome of a key.
fn outcome(role: &Role, is_known: bool) -> String {
    match role {
        Role::Assumed => ASSUMED.to_owned(),
        Role::NoPromise => NO_PROMISE.to_owned(),
        Role::OfPhases => format!("{LEFT_OUT}a walk is certified phase by phase"),
        Role::Promised(all) => match all.iter().find_map(|promise| missing_proof(promise.quantity, is_known)) {
            Some(reason) => format!("{LEFT_OUT}{reason}"),
            None => PROVED.to_owned(),
        },
    }
}

/// The reason why there is no proof for a quantity; `None` if there is one.
fn missing_proof(quantity: Quantity, is_known: bool) -> Option<&'static str> {
    use Quantity as Q;
    match quantity {
        Q::Position | Q::Velocity | Q::Acceleration | Q::Jerk | Q::Torque | Q::Power => None,
        Q::Duration | Q::Frame | Q::Foot => None,
        Q::Passive => {
            Some("a polynomial keeps the torque of a joint without a motor at zero at finitely many times only")
        }
        Q::Obstacles | Q::SelfCollision => (!is_known).then_some(LOAD),
        Q::Other => Some("no key of the scenario has these"),
    }
}

/// The files of meshes, as the URDF names them, with the SHA-256 of their bytes, if they are the shape of the robot.
pub(super) fn meshes(scenario: &Scenario) -> Result<BTreeMap<String, String>> {
    let mut found = BTreeMap::new();
    if !matches!(scenario.robot_shape(), RobotShape::Collision { .. }) {
        return Ok(found);
    }
    let robot = scenario.source.elements()?;
    for collision in robot.links.iter().flat_map(|link| &link.collision) {
        if let Geometry::Mesh { filename, .. } = &collision.geometry {
            let path = mesh_path(filename, scenario.source.folder(), &scenario.file.packages)?;
            found.insert(filename.clone(), sha256(&read_bytes(&path)?));
        }
    }
    Ok(found)
}

/// True if the robot and its load consist of balls, or of points or balls along its links.
pub(super) fn has_balls(scenario: &Scenario) -> bool {
    let payload = scenario.file.payload.as_ref().and_then(|payload| payload.shape);
    let load = payload.is_none_or(|shape| matches!(shape, ObstacleShape::Sphere { .. }));
    let by_shapes = matches!(scenario.robot_shape(), RobotShape::Collision { .. });
    let is_ball = |c: &Collision| matches!(c.shape, CollisionShape::Solid(Shape::Sphere { .. }));
    load && (!by_shapes || scenario.model.collisions().iter().all(is_ball))
}
