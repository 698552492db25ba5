//! Scenarios from MoveIt's planning scenes and requests.

mod constraints;
mod field_table;
mod fields;
mod messages;
mod obstacles;
mod other_fields;
mod scaling;
mod states;

pub(super) use fields::check_fields;
pub use fields::moveit_fields;

use super::load::absolute_folders;
use super::{
    HorizonBounds, IgnoredPair, IgnoredPairs, Objective, Preset, RobotShape, Scenario, ScenarioFile, SelfCollision,
    link_shapes,
};
use aghf::error::{Error, Result, plain};
use aghf::model::Model;
use aghf::motion::Problem;
use aghf::urdf::{LoadReport, Mimic, RobotSource, Srdf, UrdfOptions};
use constraints::{Target, kept, kept_speed};
use messages::{Message, Request, Scene};
use obstacles::obstacles_of;
use scaling::Scaled;
use states::{Joints, States};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The shortest default horizon, s.
const MIN_HORIZON: f64 = 0.1;

/// The default first and longest horizon of a search, as multiples of the time that the limits allow about.
const FIRST_MULTIPLE: f64 = 2.0;
const MAX_MULTIPLE: f64 = 15.0;

/// The files of a MoveIt planning problem, and the options for converting it to a scenario.
#[derive(Clone, Debug)]
pub struct MoveIt {
    /// The planning scene, YAML.
    pub scene: PathBuf,
    /// The planning request, YAML.
    pub request: PathBuf,
    /// The name of a built-in robot, or the path of a URDF file.
    pub urdf: String,
    /// The folders of packages by their names, relative to the current folder.
    pub packages: BTreeMap<String, PathBuf>,
    /// The treatment of mimic joints.
    pub mimic: Mimic,
    /// The SRDF, whose disabled pairs of links are not checked, nor are those that [always
    /// overlap](super::always_overlapping); without one the pairs are found by [sampling](IgnoredPairs::by_sampling).
    /// Those that the scene allows to overlap are not checked either way.
    pub srdf: Option<PathBuf>,
    /// A `joint_limits.yaml` of MoveIt, whose limits of velocity, acceleration and jerk are kept beside those of the
    /// robot.
    pub joint_limits: Option<PathBuf>,
    /// The distance by which convex pieces may extend beyond a mesh, m.
    pub excess: f64,
    /// The horizon.
    pub horizon: MoveItHorizon,
    /// The objective; on a given horizon it is the least effort.
    pub objective: Preset,
}

/// The horizon of a converted scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveItHorizon {
    /// Free, from the shortest one that the velocity limits allow, but at least 0.1 s, to fifteen times that, or times
    /// the time that limits of acceleration and of the speed of a link take about, if it is longer.
    Free,
    /// Free between these bounds, s.
    Between(f64, f64),
    /// Fixed, s.
    Given(f64),
}

impl MoveIt {
    /// Converts the planning problem to a scenario: from the joint state of the request to rest at its goal in joint
    /// space or by pose, with the poses of its path constraints, within all limits of the robot and of the
    /// `joint_limits.yaml`, times the scaling factors of the request, with the boxes, cylinders and spheres of the
    /// scene as obstacles, the collision shapes of the robot, and the pairs of links that may overlap. Joints that
    /// are not in the goal are locked at their position in the request, or in the scene; for a goal by pose those
    /// that are not in the group of the request, or without an SRDF not in its start. Positions beyond a limit by
    /// 1e-5 rad or m at most, as by a limit of 3.14159, are set to the limit; the goal of a continuous joint is moved
    /// by whole turns, as near as possible to its start. The [guide](super::guide::moveit) has all fields. `path` is
    /// the future path of the scenario, which is loaded once as a check.
    ///
    /// # Errors
    /// Names the file, the element and the fault, such as a goal, an obstacle or a frame that scenarios do not support.
    pub fn scenario(&self, path: &str) -> Result<Scenario> {
        let [scene_name, request_name] = [&self.scene, &self.request].map(|path| path.display().to_string());
        let scene = Scene::load(&self.scene)?;
        let request = Request::load(&self.request)?;
        let source = RobotSource::find(&self.urdf, Path::new(""))?;
        let (model, _) = source.parse(UrdfOptions {
            singular: true,
            mimic: self.mimic,
            packages: self.packages.clone(),
            ..UrdfOptions::default()
        })?;
        let mut notes = LoadReport::new();
        let target = Target::of(&request, &model, &request_name)?;
        let joints = self.joints(&model, (&scene, &request), &target, &mut notes)?;
        let mut keep = kept(&request, &model, &request_name)?;
        let speed = kept_speed(&request, &model, &request_name)?;
        let scaled = Scaled::of(
            (&request, &request_name),
            self.joint_limits.as_deref(),
            (&joints, &model),
            speed.as_ref(),
            &mut notes,
        )?;
        keep.extend(speed);
        let (horizon_s, free_horizon) = self.horizon_to(&target, &joints, &scaled, &request_name)?;
        let allowed = scene.allowed_collision_matrix.pairs(&scene_name)?;
        let ignored = self.ignored_pairs(&model, &source, allowed)?.ignored_pairs;
        let ignored = ignored.into_iter().map(|pair| pair.links).collect();
        let (v_goal, goal) = match target {
            Target::Joints(_) => (vec![0.0; joints.moving.len()], Vec::new()),
            Target::Poses(sets) => (Vec::new(), sets),
        };
        let (from, to) = ([joints.q_start, joints.v_start], [joints.q_goal, v_goal]);
        let file = ScenarioFile {
            packages: absolute_folders(&self.packages)?,
            mimic: self.mimic,
            locked_joints: joints.locked,
            goal,
            keep,
            // On a given horizon nothing is weighed against the effort.
            objective: Objective::Preset(match self.horizon {
                MoveItHorizon::Given(_) => Preset::LeastEffort,
                _ => self.objective,
            }),
            free_horizon,
            obstacles: obstacles_of(&scene, &model, &scene_name)?,
            robot_shape: Some(RobotShape::Collision { excess_m: Some(self.excess) }),
            self_collision: Some(SelfCollision::IgnoredPairs(ignored)),
            enforced_limits: scaled.enforced,
            ..ScenarioFile::new(source.absolute()?, horizon_s, from, to)
        };
        let mut scenario = Scenario::new(file, path, Path::new(""))?;
        scenario.load_notes.extend(notes);
        Ok(scenario)
    }

    /// The joints of the robot with their states.
    fn joints<'a>(
        &self,
        model: &'a Model,
        (scene, request): (&Scene, &Request),
        target: &Target,
        notes: &mut LoadReport,
    ) -> Result<Joints<'a>> {
        let [scene_name, request_name] = [&self.scene, &self.request].map(|path| path.display().to_string());
        let fixed = &scene.fixed_frame_transforms;
        if let Some(i) = fixed.iter().position(|of| !of.transform.is_identity()) {
            let condition = "it moves a frame; poses in the base frame are needed";
            let element = format!("fixed_frame_transforms[{i}].transform");
            return Err(Error::input(scene_name, element, condition));
        }
        let places = [[scene_name.as_str(), "robot_state"], [&request_name, "start_state"]];
        let scene_state = States::of(&scene.robot_state, model, places[0], notes)?;
        let start = States::of(&request.start_state, model, places[1], notes)?;
        let planned = self.planned(request, target, &start, model)?;
        let joints = Joints::of(model, &planned, [&start, &scene_state], target, notes);
        joints.map_err(|condition| Error::input(&request_name, "start_state.joint_state", condition))
    }

    /// The names of the joints that are planned.
    fn planned(&self, request: &Request, target: &Target, start: &States, model: &Model) -> Result<BTreeSet<String>> {
        if let Target::Joints(goal) = target {
            return Ok(goal.keys().cloned().collect());
        }
        let Some(path) = &self.srdf else {
            return Ok(start.0.keys().cloned().collect());
        };
        let srdf = Srdf::load(path, model)?;
        let file = path.display().to_string();
        let joints = srdf.joints_of_group(&request.group_name, model, &file)?;
        let name = |i: usize| model.joints()[i].name().to_owned();
        Ok(joints.into_iter().map(name).collect())
    }

    /// The pairs of links that may overlap, those that the scene allows among them.
    fn ignored_pairs(&self, model: &Model, source: &RobotSource, allowed: Vec<[String; 2]>) -> Result<IgnoredPairs> {
        let links = link_shapes(model, source.folder(), self.excess)?;
        let srdf = self.srdf.as_ref().map(|path| Srdf::load(path, model)).transpose()?;
        let mut found = IgnoredPairs::find(model, srdf.as_ref(), &links)?;
        for [a, b] in allowed {
            let same = |pair: &IgnoredPair| pair.links.contains(&a) && pair.links.contains(&b);
            // Objects and links without a shape are named there too.
            if [&a, &b].iter().all(|name| links.links.contains(name)) && !found.ignored_pairs.iter().any(same) {
                let reason = "allowed by the scene".to_owned();
                let links = [a, b];
                found.ignored_pairs.push(IgnoredPair { links, reason });
            }
        }
        Ok(found)
    }

    /// The initial horizon of the motion to a goal, and its bounds if it is free. `file` names the request.
    fn horizon_to(
        &self,
        target: &Target,
        joints: &Joints<'_>,
        scaled: &Scaled,
        file: &str,
    ) -> Result<(f64, Option<HorizonBounds>)> {
        let by_pose = matches!(target, Target::Poses(_));
        let (horizon_s, free) = self.horizon(scaled.times(target, joints), by_pose);
        let longest = free.map_or(horizon_s, |free| free.longest_s);
        if self.horizon == MoveItHorizon::Free && Problem::check_horizon(longest).is_err() {
            let condition = format!("so far from the start that it would take up to {} s", plain(longest));
            return Err(Error::input(file, "goal_constraints", condition));
        }
        Ok((horizon_s, free))
    }

    /// The initial horizon of a motion that takes at `least` this time, and about the `usual` one, both in s, and its
    /// bounds if it is free.
    fn horizon(&self, [least, usual]: [f64; 2], by_pose: bool) -> (f64, Option<HorizonBounds>) {
        let [least, usual] = [least, usual].map(|time| time.max(MIN_HORIZON));
        let free = |shortest_s: f64, longest_s: f64| {
            let bounds = HorizonBounds { shortest_s, longest_s };
            // Invalid bounds are refused like those of any scenario.
            let first = (FIRST_MULTIPLE * usual).min(longest_s).max(shortest_s);
            (first, Some(bounds))
        };
        match self.horizon {
            MoveItHorizon::Given(horizon) => (horizon, None),
            MoveItHorizon::Between(shortest, longest) => free(shortest, longest),
            // The joint positions of a pose are not known, and so not the least time.
            MoveItHorizon::Free if by_pose => free(MIN_HORIZON, MAX_MULTIPLE * usual),
            MoveItHorizon::Free => free(least, MAX_MULTIPLE * usual),
        }
    }
}
