//! The parts of a scenario that a certificate covers.

use super::LEFT_OUT;
use super::shapes::parts;
use crate::{ObstacleShape, RobotShape, Scenario, ScenarioFile, sha256};
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
const MESHES: &str = "a shape of the robot is a mesh, or it consists of balls and its load does not; the clearance of \
                      the robot_shape swept_links or joint_frames, with a ball for a load, can be certified";

/// The keys of a scenario and those that promise something by default, each with its outcome, and constraints that were
/// added in code. A key without an outcome does not compile.
pub(super) fn keys(scenario: &Scenario) -> Result<BTreeMap<String, String>> {
    let is_known = has_balls(scenario) || parts(scenario)?.is_some();
    let (own, file) = (scenario.added_constraints(), &scenario.file);
    let written = serde_json::to_value(file);
    let written = written.map_err(|e| Error::input("certify", "scenario", e.to_string()))?;
    let by_default = ["continuity", "enforced_limits", "self_collision"];
    let all = outcomes(scenario, is_known).into_iter();
    let mut all: BTreeMap<String, String> = all
        .filter(|(key, _)| written.get(key).is_some() || by_default.contains(key))
        .map(|(key, outcome)| (key.to_owned(), outcome))
        .collect();
    if own > 0 {
        let reason = format!("{LEFT_OUT}no key of the scenario has these, {own} in number");
        all.insert("constraints added in code".to_owned(), reason);
    }
    Ok(all)
}

/// The outcome of each key.
fn outcomes(scenario: &Scenario, is_known: bool) -> Vec<(&'static str, String)> {
    fn row<T>(key: &'static str, _value: &T, outcome: impl Into<String>) -> (&'static str, String) {
        (key, outcome.into())
    }
    let unless = |is_free: bool| if is_free { NO_PROMISE } else { PROVED };
    let clear = |is_asked: bool| match (is_asked, is_known) {
        (false, _) => NO_PROMISE.to_owned(),
        (true, true) => PROVED.to_owned(),
        (true, false) => format!("{LEFT_OUT}{MESHES}"),
    };
    let left_out =
        |is_asked: bool, reason: &str| if is_asked { format!("{LEFT_OUT}{reason}") } else { NO_PROMISE.to_owned() };
    #[rustfmt::skip]
    let ScenarioFile {
        schema, robot, packages, root, mount, gravity, mimic, srdf, group, held_state, locked_joints, losses,
        payload, passive, horizon_s, q_start, v_start, q_goal, v_goal, turns, goal, keep, waypoints, stand,
        phases, periodic, free_final_velocity, continuity, objective, free_horizon, obstacles, robot_shape,
        self_collision, clearance_m, enforced_limits, flow, feedback, success_threshold,
    } = &scenario.file;
    let apart = scenario.keeps_links_clear();
    let is_free = scenario.file.has_free_horizon();
    let walk = "a walk is certified phase by phase";
    vec![
        row("$schema", schema, NO_PROMISE),
        row("robot", robot, ASSUMED),
        row("packages", packages, NO_PROMISE),
        row("root", root, ASSUMED),
        row("mount", mount, ASSUMED),
        row("gravity", gravity, ASSUMED),
        row("mimic", mimic, ASSUMED),
        row("srdf", srdf, NO_PROMISE),
        row("group", group, NO_PROMISE),
        row("held_state", held_state, NO_PROMISE),
        row("locked_joints", locked_joints, ASSUMED),
        row("losses", losses, ASSUMED),
        row("payload", payload, ASSUMED),
        row(
            "passive",
            passive,
            left_out(
                !passive.is_empty(),
                "a polynomial keeps the torque of a joint without a motor at zero at finitely many times only",
            ),
        ),
        row("horizon_s", horizon_s, unless(is_free)),
        row("q_start", q_start, PROVED),
        row("v_start", v_start, PROVED),
        row("q_goal", q_goal, unless(!goal.is_empty())),
        row("v_goal", v_goal, unless(*free_final_velocity)),
        row("turns", turns, NO_PROMISE),
        row("goal", goal, PROVED),
        row("keep", keep, PROVED),
        row("waypoints", waypoints, PROVED),
        row("stand", stand, PROVED),
        row("phases", phases, left_out(!phases.is_empty(), walk)),
        row("periodic", periodic, left_out(*periodic, walk)),
        row("free_final_velocity", free_final_velocity, NO_PROMISE),
        row("continuity", continuity, PROVED),
        row("objective", objective, NO_PROMISE),
        row("free_horizon", free_horizon, PROVED),
        row("obstacles", obstacles, clear(!obstacles.is_empty())),
        row("robot_shape", robot_shape, ASSUMED),
        row("self_collision", self_collision, clear(apart)),
        row("clearance_m", clearance_m, clear(apart || !obstacles.is_empty())),
        row("enforced_limits", enforced_limits, PROVED),
        row("flow", flow, NO_PROMISE),
        row("feedback", feedback, NO_PROMISE),
        row("success_threshold", success_threshold, NO_PROMISE),
    ]
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
