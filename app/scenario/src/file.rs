//! Reading a scenario.

use super::clearance::Clearance;
use super::flow_parameters::FlowParameters;
use super::goal::{Goal, goal_set};
use super::group::{hold_others, lock};
use super::json::{by_name, one_or_more, read_json};
use super::keep::{Kept, kept_rows};
use super::losses::{Losses, substitute_rotors};
use super::objective::{Continuous, HorizonBounds, Objective, check_objective};
use super::obstacles::{Obstacle, RobotShape, SelfCollision};
use super::own_terms::OwnTerms;
use super::passive::check_passive;
use super::payload::Payload;
use super::period::period_of;
use super::phases::{PhaseTerms, WalkPhase, complete, phase_terms, points_of_walk};
use super::scene::scene;
use super::schema::{self, FeedbackKeys, one_of};
use super::self_collision::in_full;
use super::stand::{Stand, standing_foot};
use super::waypoints::{PointOnTheWay, waypoints};
use super::{EnforcedLimits, IgnoredPair};
use aghf::curve::Chebyshev;
use aghf::direct::{GoalSet, Period, Waypoint};
use aghf::error::{Error, Result, plain};
use aghf::geometry::Scene;
use aghf::input::name_of;
use aghf::model::Model;
use aghf::motion::{Feedback, Problem};
use aghf::urdf::{LoadReport, Mimic, RobotSource, UrdfOptions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf, absolute};

/// A scenario as written in a file. Angles in rad, lengths in m, times in s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScenarioFile {
    /// The path or the address of the JSON Schema of scenarios, by which an editor completes keys; it has no effect.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// The name of a built-in robot, or the path of a URDF file relative to the scenario file.
    pub robot: String,
    /// The folders of packages by their names, relative to the scenario file, for meshes `package://NAME/PATH`; others
    /// are searched for.
    #[serde(
        default,
        deserialize_with = "by_name",
        skip_serializing_if = "BTreeMap::is_empty"
    )]
    pub packages: BTreeMap<String, PathBuf>,
    /// The link that becomes the root of the robot, such as the foot on which it stands; by default that of the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub root: Option<String>,
    /// The treatment of mimic joints.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(schema_with = "one_of::<Mimic>")]
    pub mimic: Mimic,
    /// The path of an SRDF relative to the scenario file, for `group` and for pairs of links that may overlap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub srdf: Option<PathBuf>,
    /// The group of the SRDF whose joints are planned. All others are locked: where `locked_joints` says, otherwise in
    /// `held_state`, otherwise, a mimic joint, where its master takes it, otherwise as close to zero as their limits
    /// allow. A scenario that was read has these as `locked_joints`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// The name of a state in the SRDF where joints outside of the group are held; it may have one for each of several
    /// groups.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_state: Option<String>,
    /// The locked joints with their positions; they are not among the `N` joints of the keys below.
    #[serde(
        default,
        deserialize_with = "by_name",
        skip_serializing_if = "BTreeMap::is_empty"
    )]
    pub locked_joints: BTreeMap<String, f64>,
    /// Losses and rotor inertia of the joints; none by default.
    #[serde(default, skip_serializing_if = "is_default")]
    pub losses: Losses,
    /// A body that the robot carries; none by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<Payload>,
    /// The names of the joints without a motor: their torque is zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub passive: Vec<String>,
    /// The horizon `T`.
    pub horizon_s: f64,
    /// Configuration at the start, `N` entries.
    pub q_start: Vec<f64>,
    /// Velocity at the start.
    pub v_start: Vec<f64>,
    /// Configuration at the end; with `goal` a first guess of it, by default that at the start.
    #[serde(default)]
    pub q_goal: Vec<f64>,
    /// Velocity at the end: with `goal` zero by default, otherwise required, also for an end at rest.
    #[serde(default)]
    pub v_goal: Vec<f64>,
    /// For the direct method: a set of poses of a frame, or a list of sets of which the motion ends in the one that
    /// costs least. The configuration at the end is then an unknown.
    #[serde(
        default,
        deserialize_with = "one_or_more",
        skip_serializing_if = "Vec::is_empty"
    )]
    #[schemars(schema_with = "schema::one_or_more::<Goal>")]
    pub goal: Vec<Goal>,
    /// For the direct method: conditions that are kept along the way.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keep: Vec<Kept>,
    /// For the direct method: points on the way, in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub waypoints: Vec<PointOnTheWay>,
    /// For the direct method and the published flow: the foot on which the robot stands; by default the base holds
    /// anything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stand: Option<Stand>,
    /// For the direct method: the phases of a walk. The first foot is the root of the robot, which gives the order of
    /// the joints.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<WalkPhase>,
    /// True for a walk that ends as it starts, or in the mirror image of that if it ends on the other foot: positions
    /// and velocities at the start are unknowns, and `q_start` and `v_start` first guesses.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub periodic: bool,
    /// For the direct method: true if the final velocity is free; `v_goal` then serves only as the first guess.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub free_final_velocity: bool,
    /// For the direct method: the highest derivative that is continuous. If that is the acceleration, it is zero at an
    /// end at which all velocities are; by default `acceleration`, with passive joints and in a walk `velocity`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "one_of::<Continuous>")]
    pub continuity: Option<Continuous>,
    /// The cost that is minimised: a preset by its name, by default `least-effort`, or weights. The published flow
    /// always minimises the control effort, and reports this.
    #[serde(default, skip_serializing_if = "is_default")]
    pub objective: Objective,
    /// For the direct method: the bounds of a horizon that is an unknown; the search starts from `horizon_s`. By
    /// default it is one if the objective weighs time, from the least horizon that the limits allow to ten times that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub free_horizon: Option<HorizonBounds>,
    /// The obstacles to keep clear of.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
    /// The parts of the robot that keep clear of obstacles; by default `collision`, or `joint_frames` for a robot
    /// without collision shapes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot_shape: Option<RobotShape>,
    /// The links that keep clear of each other, or `off`. By default, with the shape `collision`, all but those that
    /// the SRDF disables, without one those with a single moving joint between them; those that always overlap may
    /// overlap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub self_collision: Option<SelfCollision>,
    /// The distances that the robot keeps from obstacles and between its links, m; zero by default.
    #[serde(default, skip_serializing_if = "is_default")]
    pub clearance_m: Clearance,
    /// The joint limits that act as constraints; all by default.
    #[serde(default)]
    pub enforced_limits: EnforcedLimits,
    /// The parameters of the flow; by default the paper's for Kinova.
    #[serde(default)]
    pub flow: FlowParameters,
    /// The gains of the forward simulation; by default the paper's for Kinova, 10 and 10.
    #[serde(default = "kinova_gains")]
    #[schemars(with = "FeedbackKeys")]
    pub feedback: Feedback,
    /// The final error below which a solve is a success; by default the paper's 0.05.
    #[serde(default = "paper_threshold")]
    pub success_threshold: f64,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn kinova_gains() -> Feedback {
    Feedback { kp: 10.0, kv: 10.0 }
}

fn paper_threshold() -> f64 {
    0.05
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
    /// The 64-bit xxHash of the text of the robot, in hexadecimal digits.
    pub robot_xxh64: String,
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
    pub(super) own: OwnTerms,
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
        let refuse = |element: &str, condition: String| Err(Error::input(path, element, condition));
        for package in file.packages.values_mut() {
            let found = absolute(folder.join(&package));
            *package = found.map_err(|e| Error::input(path, "packages", e.to_string()))?;
        }
        complete(&mut file, path)?;
        let options = UrdfOptions {
            mimic: match file.group {
                Some(_) => Mimic::Independent,
                None => file.mimic,
            },
            root: file.root.clone(),
            losses: file.losses.options(),
            singular: true,
            packages: file.packages.clone(),
        };
        let of_robot = |e: Error| Error::input(path, "robot", e.to_string());
        let source = RobotSource::find(&file.robot, folder).map_err(of_robot)?;
        let (mut robot, mut load_notes) = source.parse(options).map_err(of_robot)?;
        let robot_place = source.absolute().map_err(of_robot)?;
        let robot_xxh64 = twox_hash::XxHash64::oneshot(0, source.text.as_bytes());
        if let Some(given) = file.self_collision.take() {
            let read = in_full(given, folder);
            let read = read.map_err(|e| Error::input(path, "self_collision", e.to_string()))?;
            file.self_collision = Some(read);
        }
        hold_others(&mut file, &robot, &source, folder, path)?;
        let held = |joint: &str| file.locked_joints.contains_key(joint);
        load_notes.retain(|note| !note.joint().is_some_and(held));
        let load = match &file.payload {
            Some(payload) => payload.attach(&mut robot, path)?,
            None => None,
        };
        let locked = lock(&robot, &file.locked_joints, path)?;
        let load = load.as_ref();
        let found = scene(
            (&robot, load),
            locked.as_ref(),
            &file,
            source.folder(),
            path,
        )?;
        let (scene, overlapping) = found;
        let (model, of_key) = match locked {
            Some(reduced) => (reduced.model, "locked_joints"),
            None => (robot, "robot"),
        };
        let model = substitute_rotors(model, &mut file.losses, &mut load_notes)?;
        model
            .check_regular(&source.name())
            .map_err(|e| Error::input(path, of_key, e.to_string()))?;
        let phases = phase_terms(&file, &model, (path, folder))?;
        let period = period_of(&mut file, &model, &phases, (path, folder))?;
        let goal = goal_set(&mut file, &model, path)?;
        let mut waypoints = waypoints(&file, &model, path)?;
        waypoints.extend(points_of_walk(&file, &model, path)?);
        let (kept, kept_between) = kept_rows(&file, &model, path)?;
        let foot = standing_foot(&file, &model, path)?;
        let states = [
            ("q_start", &file.q_start),
            ("v_start", &file.v_start),
            ("q_goal", &file.q_goal),
            ("v_goal", &file.v_goal),
        ];
        for (key, state) in states {
            if state.len() != model.dof() {
                let (expected, found) = (model.dof(), state.len());
                let left = if file.locked_joints.is_empty() {
                    ""
                } else {
                    " that are not locked"
                };
                let joints = match (key, found) {
                    ("q_goal", 0) => "neither q_goal nor goal is given".to_owned(),
                    _ => format!(
                        "the robot has {expected} joints{left}, but {found} values are given"
                    ),
                };
                return refuse(key, joints);
            }
        }
        let positive = [
            ("flow.k", file.flow.k),
            ("flow.s_max", file.flow.s_max),
            ("flow.k_cons", file.flow.k_cons),
            ("flow.c_cons", file.flow.c_cons),
            ("success_threshold", file.success_threshold),
        ];
        for (key, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return refuse(
                    key,
                    format!("it is {}, a positive number is needed", plain(value)),
                );
            }
        }
        for (key, gain) in [
            ("feedback.kp", file.feedback.kp),
            ("feedback.kv", file.feedback.kv),
        ] {
            if !(gain.is_finite() && gain >= 0.0) {
                return refuse(
                    key,
                    format!("it is {}, a gain is not negative", plain(gain)),
                );
            }
        }
        Problem::check_horizon(file.horizon_s)
            .map_err(|condition| Error::input(path, "horizon_s", condition))?;
        Chebyshev::check_degree(file.flow.degree)
            .map_err(|condition| Error::input(path, "flow.degree", condition))?;
        check_objective(&file, model.dof(), path)?;
        (file.enforced_limits).read(&model, &source, folder, path)?;
        file.enforced_limits.check(&model, path)?;
        check_passive(&file, &model, path)?;
        Ok(Self {
            name: name_of(path),
            file,
            model,
            load_notes,
            scene,
            overlapping,
            robot_place,
            robot_xxh64: format!("{robot_xxh64:016x}"),
            source,
            goal,
            waypoints,
            phases,
            period,
            own: OwnTerms {
                constraints: kept,
                stage: kept_between,
                foot,
                running_cost: None,
            },
        })
    }

    /// The trajectory optimisation problem of this scenario.
    ///
    /// # Errors
    /// As [`Problem::new`].
    pub fn problem(&self) -> Result<Problem<'_>> {
        let state = |q: &[f64], v: &[f64]| [q, v].concat();
        Problem::new(
            &self.model,
            state(&self.file.q_start, &self.file.v_start),
            state(&self.file.q_goal, &self.file.v_goal),
            self.file.horizon_s,
        )
    }
}
