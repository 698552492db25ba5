//! The parts of a scenario that a certificate covers.

use super::NotCertified;
use super::shapes::parts;
use crate::{ObstacleShape, RobotShape, Scenario};
use aghf::error::Result;
use aghf::geometry::Shape;
use aghf::model::{Collision, CollisionShape};

/// The parts of a scenario without proofs.
pub(super) fn not_certified(scenario: &Scenario) -> Result<Vec<NotCertified>> {
    let mut all = Vec::new();
    let mut add = |promise: &str, reason: &str| {
        all.push(NotCertified {
            promise: promise.to_owned(),
            reason: reason.to_owned(),
        });
    };
    if !scenario.passive().is_empty() {
        add(
            "passive_joints",
            "a polynomial keeps their torques at zero at finitely many times only",
        );
    }
    if !has_balls(scenario) && parts(scenario)?.is_none() {
        let reason =
            "a shape of the robot is a mesh, or it consists of balls and its load does not";
        if !scenario.file.obstacles.is_empty() {
            let instead = "the clearance of the robot_shape swept_links or joint_frames, with a ball for a load, can \
                           be certified";
            add("obstacles", &format!("{reason}; {instead}"));
        }
        if scenario.keeps_links_clear() {
            add("self_collision", reason);
        }
    }
    Ok(all)
}

/// True if the robot and its load consist of balls, or of points or balls along its links.
pub(super) fn has_balls(scenario: &Scenario) -> bool {
    let payload = scenario
        .file
        .payload
        .as_ref()
        .and_then(|payload| payload.shape);
    let load = payload.is_none_or(|shape| matches!(shape, ObstacleShape::Sphere { .. }));
    let by_shapes = matches!(scenario.robot_shape(), RobotShape::Collision { .. });
    let is_ball = |c: &Collision| matches!(c.shape, CollisionShape::Solid(Shape::Sphere { .. }));
    load && (!by_shapes || scenario.model.collisions().iter().all(is_ball))
}

/// The pairs of links on different bodies that do not keep clear of each other.
pub(super) fn may_overlap(scenario: &Scenario) -> Vec<[String; 2]> {
    let scene = &scenario.scene;
    if scene.tree_pairs().is_empty() {
        return Vec::new();
    }
    let trees = scene.trees();
    let link = |i: usize| {
        scene
            .robot()
            .link_of(&trees[i])
            .unwrap_or_default()
            .to_owned()
    };
    let mut all = Vec::new();
    for i in 0..trees.len() {
        for j in i + 1..trees.len() {
            let kept = scene
                .tree_pairs()
                .iter()
                .any(|p| *p == [i, j] || *p == [j, i]);
            if !kept && trees[i].body != trees[j].body && link(i) != link(j) {
                all.push([link(i), link(j)]);
            }
        }
    }
    all
}
