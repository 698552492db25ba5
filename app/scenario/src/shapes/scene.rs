//! The robot of a scenario among its obstacles.

use crate::keys::obstacles::placed;
use crate::results::feasibility::three_digits;
use crate::shapes::robot_shape::collision_geometry;
use crate::shapes::self_collision::{IgnoredPair, always_overlapping, check_links, neighbours, never_meeting};
use crate::{Obstacle, RobotShape, Scenario, ScenarioFile, SelfCollision};
use aghf::constraint::{AnyConstraint, Constraint};
use aghf::dynamics::forward_kinematics;
use aghf::error::{Error, Result};
use aghf::geometry::{ClosestPair, Collider, Part, Scene};
use aghf::model::{Collision, Model, Reduced};
use aghf::spatial::Placement;
use nalgebra::Vector3;
use std::path::Path;

/// The largest number of rows of the constraints: each takes about 10 kB at degree 16.
const MAX_ROWS: usize = 50_000;

/// The distance of an obstacle, as a multiple of the robot's reach, beyond which the obstacle has no effect.
pub(crate) const FAR: f64 = 100.0;

/// The question about such large lengths.
pub(crate) const MILLIMETRES: &str = "lengths are in metres, are these millimetres?";

/// Builds the scene of a scenario, in which the robot may carry a load, and finds the pairs of links that are not
/// ignored but [always overlap](always_overlapping), which are ignored too, as are those that never meet; `path` names
/// the scenario in errors. Meshes are looked up from `folder`. If joints of the robot are locked, `reduced` is the
/// robot without them.
pub(crate) fn scene(
    (robot, load): (&Model, Option<&Collision>),
    reduced: Option<&Reduced>,
    file: &ScenarioFile,
    folder: &Path,
    path: &str,
) -> Result<(Scene, Vec<IgnoredPair>)> {
    let obstacles = placed(&file.obstacles, path)?;
    let bodies = reduced.map(|reduced| reduced.bodies.as_slice());
    let shape = (file.robot_shape).unwrap_or_else(|| RobotShape::of(robot));
    let geometry = collision_geometry((robot, load), bodies, shape, folder, path);
    let geometry = geometry.map_err(|e| by_default(e, file.robot_shape.is_none()))?;
    let refuse = |key: &str, condition: String| Err(Error::input(path, key, condition));
    let moving = reduced.map_or(robot, |reduced| &reduced.model);
    let has_links = matches!(shape, RobotShape::Collision { .. });
    let ignored_pairs = match &file.self_collision {
        Some(SelfCollision::Off) => None,
        None if !has_links => None,
        None => Some(neighbours(moving, &geometry)),
        Some(SelfCollision::IgnoredPairs(_)) if !has_links => {
            let condition = "links are told apart with the robot_shape 'collision' only";
            return refuse("self_collision", condition.to_owned());
        }
        Some(SelfCollision::IgnoredPairs(pairs)) => {
            check_links(pairs, robot, path)?;
            Some(pairs.clone())
        }
        Some(SelfCollision::IgnoredPairsFile(_)) => {
            let condition = "a file is read when a scenario is, and not here";
            return refuse("self_collision", condition.to_owned());
        }
    };
    let margins = file.clearance_m.margins(&file.obstacles, path)?;
    // Pairs that may overlap, and with them those that never meet.
    let (mut overlapping, mut may_overlap, mut ignored) = (Vec::new(), None, None);
    if let Some(mut all) = ignored_pairs {
        overlapping = always_overlapping(moving, &geometry, &all)?;
        all.extend(overlapping.iter().map(|pair| pair.links.clone()));
        may_overlap = Some(all.clone());
        let limited = file.enforced_limits.position.is_of_all();
        let margin = |links: [&str; 2]| margins.of_links(links);
        let never = never_meeting(moving, &geometry, &all, limited, margin)?;
        all.extend(never);
        ignored = Some(all);
    }
    let scene = Scene::new(geometry, obstacles, ignored.as_deref());
    let scene = margins.of_scene(scene, may_overlap.as_deref(), robot, path)?;
    let scene = scene.with_ends(ends(moving, file)?)?;
    check_rows(&scene, path)?;
    Ok((scene, overlapping))
}

/// The placements of the bodies at the start, and at the end unless it is a set.
fn ends(model: &Model, file: &ScenarioFile) -> Result<Vec<Vec<Placement<f64>>>> {
    let end = file.goal.is_empty().then_some(&file.q_goal);
    let all = [&file.q_start].into_iter().chain(end).filter(|q| q.len() == model.dof());
    let placed = all.map(|q| {
        let mut placements = vec![Placement::identity(); model.dof()];
        forward_kinematics(model, q, &mut placements)?;
        Ok(placements)
    });
    placed.collect()
}

/// Refuses a scene with too many rows; `path` names the scenario.
fn check_rows(scene: &Scene, path: &str) -> Result<()> {
    let rows: usize = AnyConstraint::of_scene(scene).iter().map(Constraint::dim).sum();
    if rows > MAX_ROWS {
        let (obstacles, robot) = (scene.obstacles().len(), scene.robot());
        let kind = if robot.parts.is_empty() { "balls" } else { "convex parts" };
        let balls = robot.balls.len();
        let key = match obstacles {
            0 => "robot_shape",
            _ => "obstacles",
        };
        let condition = format!(
            "{obstacles} obstacles and {balls} {kind} of the robot take {rows} rows of the constraints, at most \
             {MAX_ROWS} are allowed"
        );
        return Err(Error::input(path, key, condition));
    }
    Ok(())
}

/// The error of a shape of the robot, with the remedy if no key asks for the shape.
fn by_default(error: Error, is_default: bool) -> Error {
    match error {
        Error::Input { file, element, condition } if is_default => {
            let condition = format!(
                "{condition}; \"robot_shape\": \"joint_frames\" plans without the shapes, by the origins of joint \
                 frames alone"
            );
            Error::input(file, element, condition)
        }
        other => other,
    }
}

impl Scenario {
    /// The parts of the robot that keep clear, by the key or by default.
    #[must_use]
    pub fn robot_shape(&self) -> RobotShape {
        (self.file.robot_shape).unwrap_or_else(|| RobotShape::of(&self.model))
    }

    /// The scene with other obstacles in place of those of the file.
    pub(crate) fn scene_with(&self, obstacles: &[Obstacle]) -> Result<Scene> {
        let margins = self.file.clearance_m.margins(obstacles, &self.name)?;
        let obstacles = placed(obstacles, &self.name)?;
        let scene = self.scene.clone().with_obstacles(obstacles);
        let scene = scene.with_margins(|i| margins.obstacles[i], |links| margins.of_links(links));
        check_rows(&scene, &self.name)?;
        Ok(scene)
    }

    /// Returns true if links keep clear of each other, by the key or by default.
    #[must_use]
    pub fn keeps_links_clear(&self) -> bool {
        match self.file.self_collision {
            Some(SelfCollision::Off) => false,
            _ => matches!(self.robot_shape(), RobotShape::Collision { .. }),
        }
    }

    /// The smallest [clearance](Scene::clearance) over configurations, in m; `None` without obstacles or pairs of
    /// links.
    ///
    /// # Errors
    /// A configuration has the wrong length.
    pub fn smallest_clearance<'q>(&self, configurations: impl Iterator<Item = &'q [f64]>) -> Result<Option<f64>> {
        Ok(self.nearest(configurations)?.map(|(.., distance)| distance))
    }

    /// The index of the configuration with the smallest [clearance](Scene::clearance), the [names](Self::names_of) of
    /// the pair, and its distance, m; `None` without obstacles or pairs of links.
    ///
    /// # Errors
    /// A configuration has the wrong length.
    pub fn nearest<'q>(
        &self,
        configurations: impl Iterator<Item = &'q [f64]>,
    ) -> Result<Option<(usize, [String; 2], f64)>> {
        let mut placements = vec![Placement::identity(); self.model.dof()];
        let mut nearest: Option<(usize, ClosestPair)> = None;
        for (k, q) in configurations.enumerate() {
            forward_kinematics(&self.model, q, &mut placements)?;
            let most = nearest.map_or(f64::INFINITY, |(_, known)| known.distance);
            let closer = self.scene.closest_pair_within(&placements, most)?;
            nearest = closer.map(|pair| (k, pair)).or(nearest);
        }
        let named = |(k, pair): (usize, ClosestPair)| (k, self.names_of(&pair).map(str::to_owned), pair.distance);
        Ok(nearest.map(named))
    }

    /// Remarks on obstacles so far away that their lengths may have another unit.
    ///
    /// # Errors
    /// As [`problem`](Self::problem).
    pub(crate) fn far_obstacles(&self) -> Result<Vec<String>> {
        let reach = self.problem()?.reach();
        let obstacles = self.scene.obstacles().iter();
        let distances = obstacles.map(|each| (each, each.solid.distance(&Vector3::zeros())));
        let far = distances.filter(|(_, distance)| reach > 0.0 && *distance > FAR * reach);
        let told = far.map(|(obstacle, distance)| {
            let (name, [distance, reach]) = (&obstacle.name, [distance, reach].map(|x| three_digits(x, f64::round)));
            format!("'{name}' is {distance} m from the base, and the robot reaches {reach} m: {MILLIMETRES}")
        });
        Ok(told.collect())
    }

    /// The names of a part of the robot, its link or otherwise the joint that moves it, and of the obstacle or part
    /// that is closest to it.
    #[must_use]
    pub fn names_of<'a>(&'a self, pair: &ClosestPair<'a>) -> [&'a str; 2] {
        let name = |part: Part<'a>| {
            let joint = part.body.map(|body| self.model.joints()[body].name());
            part.link.or(joint).unwrap_or("base")
        };
        let other = match pair.other {
            Collider::Obstacle(name) => name,
            Collider::Robot(part) => name(part),
        };
        [name(pair.part), other]
    }
}
