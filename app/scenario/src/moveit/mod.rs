//! Scenarios from MoveIt's planning scenes and requests.

mod constraints;
mod messages;
mod obstacles;

use super::load::absolute_folders;
use super::preflight::slowest;
use super::yaml::read_yaml;
use super::{
    HorizonBounds, IgnoredPair, IgnoredPairs, Objective, Preset, RobotShape, Scenario,
    ScenarioFile, SelfCollision, cover_links,
};
use aghf::error::{Error, Result, plain};
use aghf::input::read_text;
use aghf::model::{Joint, Model};
use aghf::motion::Problem;
use aghf::urdf::{LoadNote, LoadReport, Mimic, RobotSource, Srdf, UrdfOptions};
use constraints::{Target, kept};
use messages::{Request, RobotState, Scene};
use obstacles::obstacles_of;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// The shortest default horizon, s.
const SHORTEST: f64 = 0.1;

/// The default first and longest horizon of a search, as multiples of the shortest one that the velocity limits allow.
const FIRST: f64 = 2.0;
const LONGEST: f64 = 15.0;

/// The largest distance beyond a limit that counts as rounding, rad or m: that of numbers with six digits.
const ROUNDING: f64 = 1e-5;

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
    /// The largest distance by which the balls may stick out that cover shapes other than spheres, m.
    pub excess: f64,
    /// The horizon.
    pub horizon: MoveItHorizon,
    /// The objective; on a given horizon it is the least effort.
    pub objective: Preset,
}

/// The horizon of a converted scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveItHorizon {
    /// Free, from the shortest one that the velocity limits allow, but at least 0.1 s, to fifteen times that.
    Free,
    /// Free between these bounds, s.
    Between(f64, f64),
    /// Fixed, s.
    Given(f64),
}

impl MoveIt {
    /// Converts the planning problem to a scenario: from the joint state of the request to its goal in joint space or
    /// by pose, at rest at both ends, with the poses of its path constraints, within all limits of the robot, with the
    /// boxes, cylinders and spheres of the scene as obstacles, the collision shapes of the robot, and the pairs of
    /// links that may overlap. Joints that are not in the goal are locked at their position in the request, or in the
    /// scene; for a goal by pose those that are not in the group of the request, or without an SRDF not in its start.
    /// Positions beyond a limit by 1e-5 rad or m at most, as by a limit of 3.14159, are set to the limit.
    /// `path` is the future path of the scenario, which is loaded once as a check.
    ///
    /// # Errors
    /// Names the file, the element and the fault, such as a goal, an obstacle or a frame that scenarios do not support.
    pub fn scenario(&self, path: &str) -> Result<Scenario> {
        let [scene_name, request_name] =
            [&self.scene, &self.request].map(|path| path.display().to_string());
        let scene: Scene = read_yaml(&read_text(&self.scene)?, &scene_name, "scene")?;
        let request: Request = read_yaml(&read_text(&self.request)?, &request_name, "request")?;
        let source = RobotSource::find(&self.urdf, Path::new(""))?;
        let (model, _) = source.parse(UrdfOptions {
            singular: true,
            mimic: self.mimic,
            packages: self.packages.clone(),
            ..UrdfOptions::default()
        })?;
        let mut notes = LoadReport::new();
        let places = [
            [scene_name.as_str(), "robot_state"],
            [&request_name, "start_state"],
        ];
        let scene_state = Positions::of(&scene.robot_state, &model, places[0], &mut notes)?;
        let start = Positions::of(&request.start_state, &model, places[1], &mut notes)?;
        let target = Target::of(&request, &model, &request_name)?;
        let planned = self.planned(&request, &target, &start, &model)?;

        let states = [&start, &scene_state];
        let joints = Joints::of(&model, &planned, states, &target, &mut notes);
        let joints = joints.map_err(|condition| {
            Error::input(&request_name, "start_state.joint_state", condition)
        })?;
        let (horizon_s, free_horizon) = self.horizon_to(&target, &joints);
        let longest = free_horizon.map_or(horizon_s, |free| free.longest_s);
        if self.horizon == MoveItHorizon::Free && Problem::check_horizon(longest).is_err() {
            let condition = format!(
                "so far from the start that it would take up to {} s",
                plain(longest)
            );
            return Err(Error::input(request_name, "goal_constraints", condition));
        }
        let allowed = scene.allowed_collision_matrix.pairs(&scene_name)?;
        let ignored = self.ignored_pairs(&model, &source, allowed)?.ignored_pairs;
        let ignored = ignored.into_iter().map(|pair| pair.links).collect();
        let zeros = vec![0.0; joints.moving.len()];
        let (v_goal, goal) = match target {
            Target::Joints(_) => (zeros.clone(), Vec::new()),
            Target::Poses(sets) => (Vec::new(), sets),
        };
        let (from, to) = ([joints.q_start, zeros], [joints.q_goal, v_goal]);
        let file = ScenarioFile {
            packages: absolute_folders(&self.packages)?,
            mimic: self.mimic,
            locked_joints: joints.locked,
            goal,
            keep: kept(&request, &model, &request_name)?,
            // On a given horizon nothing is weighed against the effort.
            objective: Objective::Preset(match self.horizon {
                MoveItHorizon::Given(_) => Preset::LeastEffort,
                _ => self.objective,
            }),
            free_horizon,
            obstacles: obstacles_of(&scene, &scene_name)?,
            robot_shape: Some(RobotShape::Collision {
                excess_m: Some(self.excess),
            }),
            self_collision: Some(SelfCollision::IgnoredPairs(ignored)),
            ..ScenarioFile::new(source.absolute()?, horizon_s, from, to)
        };
        let mut scenario = Scenario::new(file, path, Path::new(""))?;
        scenario.load_notes.extend(notes);
        Ok(scenario)
    }

    /// The names of the joints that are planned.
    fn planned(
        &self,
        request: &Request,
        target: &Target,
        start: &Positions,
        model: &Model,
    ) -> Result<BTreeSet<String>> {
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
    fn ignored_pairs(
        &self,
        model: &Model,
        source: &RobotSource,
        allowed: Vec<[String; 2]>,
    ) -> Result<IgnoredPairs> {
        let links = cover_links(model, source.folder(), self.excess)?;
        let mut found = match &self.srdf {
            Some(path) => {
                IgnoredPairs::of_srdf(model, &Srdf::load(path, model)?).joined(model, &links)?
            }
            None => IgnoredPairs::by_sampling(model, &links)?,
        };
        for [a, b] in allowed {
            let same = |pair: &IgnoredPair| pair.links.contains(&a) && pair.links.contains(&b);
            // Objects and links without a shape are named there too.
            if [&a, &b].iter().all(|name| links.links.contains(name))
                && !found.ignored_pairs.iter().any(same)
            {
                let reason = "allowed by the scene".to_owned();
                let links = [a, b];
                found.ignored_pairs.push(IgnoredPair { links, reason });
            }
        }
        Ok(found)
    }

    /// The initial horizon of the motion to a goal, and its bounds if it is free.
    fn horizon_to(&self, target: &Target, joints: &Joints<'_>) -> (f64, Option<HorizonBounds>) {
        if let Target::Joints(_) = target {
            return self.horizon(&joints.moving, &joints.q_start, &joints.q_goal);
        }
        // The joint positions are not known: half a turn stands for the motion of each joint, but for the bound.
        let [from, to] = [0.0, PI].map(|q| vec![q; joints.moving.len()]);
        let (first, mut free) = self.horizon(&joints.moving, &from, &to);
        if let (MoveItHorizon::Free, Some(bounds)) = (self.horizon, &mut free) {
            bounds.shortest_s = SHORTEST;
        }
        (first, free)
    }

    /// The initial horizon, and its bounds if it is free.
    fn horizon(
        &self,
        joints: &[&Joint<f64>],
        start: &[f64],
        goal: &[f64],
    ) -> (f64, Option<HorizonBounds>) {
        let speed = |i: usize| joints[i].limits().velocity;
        let least = slowest(start, goal, speed).map_or(0.0, |(_, least)| least);
        let least = least.max(SHORTEST);
        let free = |shortest_s: f64, longest_s: f64| {
            let bounds = HorizonBounds {
                shortest_s,
                longest_s,
            };
            // Invalid bounds are refused like those of any scenario.
            let first = (FIRST * least).min(longest_s).max(shortest_s);
            (first, Some(bounds))
        };
        match self.horizon {
            MoveItHorizon::Given(horizon) => (horizon, None),
            MoveItHorizon::Between(shortest, longest) => free(shortest, longest),
            MoveItHorizon::Free => free(least, LONGEST * least),
        }
    }
}

/// The joints of the robot: those that move, with their positions at both ends, and the others.
struct Joints<'a> {
    moving: Vec<&'a Joint<f64>>,
    q_start: Vec<f64>,
    /// Empty for a goal by pose.
    q_goal: Vec<f64>,
    locked: BTreeMap<String, f64>,
}

impl<'a> Joints<'a> {
    /// Separates the joints that are `planned` from the others. A position is that of the first of the two states that
    /// has it.
    ///
    /// # Errors
    /// A joint without a position, in words.
    fn of(
        model: &'a Model,
        planned: &BTreeSet<String>,
        states: [&Positions; 2],
        target: &Target,
        notes: &mut LoadReport,
    ) -> std::result::Result<Self, String> {
        let mut joints = Self {
            moving: Vec::new(),
            q_start: Vec::new(),
            q_goal: Vec::new(),
            locked: BTreeMap::new(),
        };
        for joint in model.joints() {
            let name = joint.name();
            let Some(from) = states.iter().find_map(|state| state.0.get(name)) else {
                return Err(format!(
                    "joint '{name}' of the robot is neither there nor in the scene"
                ));
            };
            if !planned.contains(name) {
                joints.locked.insert(name.to_owned(), *from);
                continue;
            }
            joints.q_start.push(within_limits(joint, *from, notes));
            joints.moving.push(joint);
            if let Target::Joints(goal) = target {
                let goal = goal.get(name);
                (joints.q_goal).extend(goal.map(|q| within_limits(joint, *q, notes)));
            }
        }
        Ok(joints)
    }
}

/// Joint positions by name.
struct Positions(BTreeMap<String, f64>);

impl Positions {
    /// Reads the positions of a state. Joints that the robot lacks, such as the wheels of its base, are noted. `key` is
    /// the position of the state in `file`.
    fn of(
        state: &RobotState,
        model: &Model,
        [file, key]: [&str; 2],
        notes: &mut LoadReport,
    ) -> Result<Self> {
        let refuse = |what: &str, condition: String| {
            Err(Error::input(file, format!("{key}.{what}"), condition))
        };
        let joints = &state.joint_state;
        if joints.name.len() != joints.position.len() {
            let (names, positions) = (joints.name.len(), joints.position.len());
            let condition = format!("it has {names} names, but {positions} positions");
            return refuse("joint_state", condition);
        }
        if !state.attached_collision_objects.is_empty() {
            let condition = "objects that the robot carries are not read".to_owned();
            return refuse("attached_collision_objects", condition);
        }
        for (i, transform) in state.multi_dof_joint_state.transforms.iter().enumerate() {
            let translation: nalgebra::Vector3<f64> = transform.translation.into();
            let [x, y, z, _]: [f64; 4] = transform.rotation.into();
            if translation.iter().chain(&[x, y, z]).any(|x| *x != 0.0) {
                let what = format!("multi_dof_joint_state.transforms[{i}]");
                return refuse(&what, "it moves the robot, whose base is fixed".to_owned());
            }
        }
        let mut positions = BTreeMap::new();
        for (i, (name, position)) in joints.name.iter().zip(&joints.position).enumerate() {
            if !has_joint(model, name) {
                let note = LoadNote::Missing {
                    joint: name.clone(),
                };
                if !notes.contains(&note) {
                    notes.push(note);
                }
            }
            if positions.insert(name.clone(), *position).is_some() {
                let condition = format!("joint '{name}' is named twice");
                return refuse(&format!("joint_state.name[{i}]"), condition);
            }
        }
        Ok(Self(positions))
    }
}

/// The position of a joint, or its limit if that is exceeded by [`ROUNDING`] at most, which is noted.
fn within_limits(joint: &Joint<f64>, position: f64, notes: &mut LoadReport) -> f64 {
    let limits = joint.limits();
    let inside = position.max(limits.lower).min(limits.upper);
    let by = (position - inside).abs();
    if by == 0.0 || by > ROUNDING {
        return position;
    }
    notes.push(LoadNote::AtLimit {
        joint: joint.name().to_owned(),
        by: format!("{by:.1e}"),
    });
    inside
}

/// Returns true if the robot has a moving or fixed joint of this name.
fn has_joint(model: &Model, name: &str) -> bool {
    let carriers = model.frames().iter().filter_map(|f| f.carrier.as_ref());
    let mut names = carriers.map(|carrier| carrier.joint.as_str());
    names.any(|joint| joint == name)
}

/// Returns true if a message contains anything but empty lists and texts.
fn has_entries(value: &serde_json::Value) -> bool {
    use serde_json::Value;
    match value {
        Value::Null => false,
        Value::String(text) => !text.is_empty(),
        Value::Array(list) => !list.is_empty(),
        Value::Object(object) => object.values().any(has_entries),
        Value::Bool(_) | Value::Number(_) => true,
    }
}
