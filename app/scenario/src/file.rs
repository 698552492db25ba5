//! Reading a scenario.

use crate::IgnoredPair;
use crate::keys::goal::goal_set;
use crate::keys::group::{hold_others, lock};
use crate::keys::json::read_json;
use crate::keys::keep::kept_rows;
use crate::keys::losses::substitute_rotors;
use crate::keys::objective::check_objective;
use crate::keys::obstacles::bounded;
use crate::keys::passive::check_passive;
use crate::keys::period::period_of;
use crate::keys::phases::{PhaseTerms, complete, phase_terms, points_of_walk};
use crate::keys::scenario_file::ScenarioFile;
use crate::keys::stand::standing_foot;
use crate::keys::turns::shorten_turns;
use crate::keys::waypoints::waypoints;
use crate::shapes::scene::scene;
use crate::shapes::self_collision::{in_full, name_overlapping};
use crate::solve::custom_terms::CustomTerms;
use aghf::direct::{GoalEnd, GoalSet, Period, Waypoint};
use aghf::error::{Error, Result};
use aghf::geometry::Scene;
use aghf::input::name_of;
use aghf::model::Model;
use aghf::motion::Problem;
use aghf::urdf::{LoadReport, Mimic, RobotSource, UrdfOptions};
use sha2::{Digest, Sha256};
use std::path::{Path, absolute};
use std::sync::OnceLock;

/// The SHA-256 of bytes, in hexadecimal digits.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A scenario with its robot, checked.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The name: the file name without its extension.
    pub name: String,
    /// The contents of the file.
    pub file: ScenarioFile,
    /// The robot, without the locked joints.
    pub model: Model,
    /// The notes from loading the robot.
    pub load_notes: LoadReport,
    /// The shape of the robot and the obstacles.
    pub scene: Scene,
    /// The pairs of links that always overlap and are therefore not kept clear of each other, though nothing says so.
    pub overlapping: Vec<IgnoredPair>,
    /// The name of the robot if it is built in, otherwise its absolute path.
    pub robot_place: String,
    /// The SHA-256 of the text of the robot, in hexadecimal digits.
    pub robot_sha256: String,
    /// The text of the robot and its origin.
    pub source: RobotSource,
    /// The goal, if it is a set.
    pub goal: Option<GoalSet>,
    /// The points on the way.
    pub waypoints: Vec<Waypoint>,
    /// The phases of a walk.
    pub(super) phases: Vec<PhaseTerms>,
    /// The relation between the ends of a periodic walk.
    pub(super) period: Option<Period>,
    /// The constraints and the cost that no key can name.
    pub(super) own: CustomTerms,
    /// The continuous joints that go to other positions than those given, in words.
    pub(super) turned: Vec<String>,
    /// The ends of a goal that is a set, those first to which motions are expected to be best, and the file of which
    /// they are, once they were found.
    pub(super) ends: OnceLock<(ScenarioFile, Vec<GoalEnd>)>,
}

impl Scenario {
    /// Parses a scenario from JSON text. `path` and `folder` are as in [`new`](Self::new).
    ///
    /// # Errors
    /// Those of [`load`](Self::load).
    pub fn parse(text: &str, path: &str, folder: &Path) -> Result<Self> {
        Self::new(read_json(text, path)?, path, folder)
    }

    /// Builds a scenario from the contents of a file, or from values of a program. Errors name `path`; its file name
    /// without extension becomes the name of the scenario. The robot is looked for in `folder` unless it is built in.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn new(mut file: ScenarioFile, path: &str, folder: &Path) -> Result<Self> {
        for package in file.packages.values_mut() {
            let found = absolute(folder.join(&package));
            *package = found.map_err(|e| Error::input(path, "packages", e.to_string()))?;
        }
        complete(&mut file, path)?;
        let robot = Robot::read(&mut file, path, folder)?;
        let source = &robot.source;
        let model = &robot.model;
        let turned = shorten_turns(&mut file, model);
        let phases = phase_terms(&file, model, (path, folder))?;
        let period = period_of(&mut file, model, &phases, (path, folder))?;
        let goal = goal_set(&mut file, model, path)?;
        let mut waypoints = waypoints(&file, model, path)?;
        waypoints.extend(points_of_walk(&file, model, path)?);
        let (kept, kept_between) = kept_rows(&file, model, path)?;
        let mut own = CustomTerms {
            constraints: kept,
            stage: kept_between,
            foot: standing_foot(&file, model, path)?,
            running_cost: None,
            added: [0; 2],
        };
        file.check_states(model, path)?;
        file.check_numbers(path)?;
        let mut load_notes = robot.notes;
        (file.enforced_limits).read(model, source, (path, folder), &mut load_notes)?;
        file.enforced_limits.check(model, path)?;
        own.stage.extend(file.complete_start(model, path)?);
        check_objective(&file, model, path)?;
        check_passive(&file, model, path)?;
        Ok(Self {
            name: name_of(path),
            robot_place: (source.absolute()).map_err(|e| of_robot(&e, path))?,
            robot_sha256: sha256(source.text.as_bytes()),
            file,
            model: robot.model,
            load_notes,
            scene: robot.scene,
            overlapping: robot.overlapping,
            source: robot.source,
            goal,
            waypoints,
            phases,
            period,
            own,
            turned,
            ends: OnceLock::new(),
        })
    }

    /// The trajectory optimisation problem of this scenario.
    ///
    /// # Errors
    /// As [`Problem::new`] and [`Problem::with_accelerations`].
    pub fn problem(&self) -> Result<Problem<'_>> {
        let state = |q: &[f64], v: &[f64]| [q, v].concat();
        let ScenarioFile { q_start, v_start, a_start, q_goal, v_goal, a_goal, horizon_s, .. } = &self.file;
        let problem = Problem::new(&self.model, state(q_start, v_start), state(q_goal, v_goal), *horizon_s)?;
        problem.with_accelerations([a_start.clone(), a_goal.clone()])
    }
}

/// The robot of a scenario, without the locked joints, among its obstacles.
struct Robot {
    source: RobotSource,
    model: Model,
    notes: LoadReport,
    scene: Scene,
    overlapping: Vec<IgnoredPair>,
}

impl Robot {
    /// Reads the robot of a file, and replaces the keys of the file that depend on others: the group, the pairs of
    /// links and the losses.
    fn read(file: &mut ScenarioFile, path: &str, folder: &Path) -> Result<Self> {
        let options = UrdfOptions {
            mimic: match file.group {
                Some(_) => Mimic::Independent,
                None => file.mimic,
            },
            hold: file.group.is_some(),
            root: file.root.clone(),
            losses: file.losses.options(),
            singular: true,
            packages: file.packages.clone(),
        };
        let source = RobotSource::find(&file.robot, folder).map_err(|e| of_robot(&e, path))?;
        let (whole, mut notes) = source.parse(options).map_err(|e| of_robot(&e, path))?;
        let mut whole = in_world(whole, file, path)?;
        if let Some(given) = file.self_collision.take() {
            let read = in_full(given, folder);
            let read = read.map_err(|e| Error::input(path, "self_collision", e.to_string()))?;
            file.self_collision = Some(read);
        }
        hold_others(file, (&whole, &mut notes), &source, folder, path)?;
        let held = |joint: &str| file.locked_joints.contains_key(joint);
        notes.retain(|note| !note.joint().is_some_and(held));
        let load = match &file.payload {
            Some(payload) => payload.attach(&mut whole, path)?,
            None => None,
        };
        let locked = lock(&whole, &file.locked_joints, path)?;
        let shapes = (&whole, load.as_ref());
        let (scene, overlapping) = scene(shapes, locked.as_ref(), file, source.folder(), path)?;
        let moving = locked.as_ref().map_or(&whole, |reduced| &reduced.model);
        name_overlapping(file, moving, &scene, &overlapping);
        let (model, of_key) = match locked {
            Some(reduced) => (reduced.model, "locked_joints"),
            None => (whole, "robot"),
        };
        let model = substitute_rotors(model, &mut file.losses, &mut notes)?;
        model.check_regular(&source.name()).map_err(|e| Error::input(path, of_key, e.to_string()))?;
        Ok(Self { source, model, notes, scene, overlapping })
    }
}

/// The robot at the place where it is mounted, under the gravity there.
fn in_world(mut robot: Model, file: &ScenarioFile, path: &str) -> Result<Model> {
    let refuse = |key: &str, condition: String| Error::input(path, key, condition);
    if let Some(mount) = &file.mount {
        let mount = mount.placement().map_err(|condition| refuse("mount", condition))?;
        robot = robot.mounted(&mount)?;
    }
    match file.gravity {
        None => Ok(robot),
        Some(gravity) if bounded(&gravity) => Ok(robot.with_gravity(gravity.into())),
        Some(_) => Err(refuse("gravity", "it needs three finite numbers, in m/s^2".to_owned())),
    }
}

/// An error of the robot as one of the scenario at `path`.
fn of_robot(error: &Error, path: &str) -> Error {
    Error::input(path, "robot", error.to_string())
}
