//! The keys of a scenario.

use crate::keys::clearance::Clearance;
use crate::keys::flow_parameters::FlowParameters;
use crate::keys::goal::Goal;
use crate::keys::json::{by_name, one_or_more};
use crate::keys::keep::Kept;
use crate::keys::losses::Losses;
use crate::keys::objective::{Continuous, HorizonBounds, Objective};
use crate::keys::obstacles::{Obstacle, Pose, RobotShape, SelfCollision};
use crate::keys::payload::Payload;
use crate::keys::phases::WalkPhase;
use crate::keys::schema::{self, FeedbackKeys, one_of};
use crate::keys::stand::Stand;
use crate::keys::turns::Turns;
use crate::keys::waypoints::PointOnTheWay;
use crate::{EnforcedLimits, Quantity, StartTolerance};
use aghf::curve::Chebyshev;
use aghf::error::{Error, Result, plain};
use aghf::model::Model;
use aghf::motion::{Feedback, Problem};
use aghf::urdf::Mimic;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

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
    #[serde(default, deserialize_with = "by_name", skip_serializing_if = "BTreeMap::is_empty")]
    pub packages: BTreeMap<String, PathBuf>,
    /// The link that becomes the root of the robot, such as the foot on which it stands; by default that of the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub root: Option<String>,
    /// The pose of the root of the robot in the world, such as on a wall or a ceiling; obstacles, poses and gravity are
    /// in the world. By default the frame of the root is the world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mount: Option<Pose>,
    /// The acceleration of gravity in the world, m/s^2; `[0, 0, -9.81]` by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<[f64; 3]>,
    /// The treatment of mimic joints.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(schema_with = "one_of::<Mimic>")]
    pub mimic: Mimic,
    /// The path of an SRDF relative to the scenario file, for `group` and for pairs of links that may overlap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub srdf: Option<PathBuf>,
    /// The group of the SRDF whose joints are planned. All others are locked: where `locked_joints` says, otherwise in
    /// `held_state`, otherwise, for a mimic joint, at the position that its master gives it, otherwise as close to zero
    /// as their limits allow. A scenario that was read has these as `locked_joints`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// The name of a state in the SRDF where joints outside of the group are held; it may have one for each of several
    /// groups.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_state: Option<String>,
    /// The locked joints with their positions; they are not among the `N` joints of the keys below.
    #[serde(default, deserialize_with = "by_name", skip_serializing_if = "BTreeMap::is_empty")]
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
    /// For the direct method with continuous accelerations: the acceleration at the start, `N` entries; by default zero
    /// if the robot is at rest there, and free if it moves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub a_start: Option<Vec<f64>>,
    /// The distance from limits of positions at which the motion may start, by default 1e-4 rad or m, and the time at
    /// which it is back, which is also the least duration, by default 0.25 s, or half of `horizon_s` if that is
    /// shorter. A scenario that was read has it if a joint starts outside of its limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_tolerance: Option<StartTolerance>,
    /// Configuration at the end; with `goal` a first guess of it, by default that at the start.
    #[serde(default)]
    pub q_goal: Vec<f64>,
    /// Velocity at the end: with `goal` zero by default, otherwise required, also for an end at rest.
    #[serde(default)]
    pub v_goal: Vec<f64>,
    /// Acceleration at the end, as `a_start` at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub a_goal: Option<Vec<f64>>,
    /// The way of continuous joints to the positions of `q_goal` and of waypoints. A scenario that was read has the
    /// positions to which they go.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(schema_with = "one_of::<Turns>")]
    pub turns: Turns,
    /// For the direct method: a set of poses of a frame, or a list of sets of which the motion ends in the one that
    /// costs least. The configuration at the end is then an unknown.
    #[serde(default, deserialize_with = "one_or_more", skip_serializing_if = "Vec::is_empty")]
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

impl ScenarioFile {
    /// Returns true if a velocity, an acceleration, a jerk, a torque or a kept speed is bounded, as a least time needs.
    pub(crate) fn bounds_time(&self, model: &Model) -> bool {
        let limits = Quantity::JOINT.into_iter().filter(|of| *of != Quantity::Position);
        let is_bounded = |joint, limit| self.enforced_limits.bound(model, limit, joint).is_some();
        (0..model.dof()).any(|joint| limits.clone().any(|limit| is_bounded(joint, limit)))
            || self.keep.iter().any(|kept| kept.speed.is_some())
    }

    /// Returns true if the horizon is an unknown.
    pub(crate) fn has_free_horizon(&self) -> bool {
        self.free_horizon.is_some() || self.objective.weighs_time()
    }

    /// The shortest and the longest horizon, s: that of the file, those of `free_horizon`, or zero and infinity if the
    /// objective alone makes it free; not before a start outside of limits is [back](StartTolerance::back_s).
    #[must_use]
    pub fn horizon_bounds(&self) -> [f64; 2] {
        let [shortest, longest] = match self.free_horizon {
            Some(free) => [free.shortest_s, free.longest_s],
            None if self.objective.weighs_time() => [0.0, f64::INFINITY],
            None => [self.horizon_s; 2],
        };
        [self.start_tolerance.map_or(shortest, |start| shortest.max(start.back_s)), longest]
    }

    /// The accelerations of a motion at the start and at the end, `N` entries each: those that are given, and zero at
    /// an end at rest if accelerations are continuous; `None` where they are free.
    #[must_use]
    pub fn accelerations(&self) -> [Option<Vec<f64>>; 2] {
        let is_smooth = self.continuity() == Continuous::Acceleration;
        let ends = [(&self.a_start, &self.v_start, false), (&self.a_goal, &self.v_goal, self.free_final_velocity)];
        ends.map(|(given, v, is_free)| {
            let is_at_rest = !is_free && v.iter().all(|v| *v == 0.0);
            given.clone().or_else(|| (is_smooth && is_at_rest).then(|| vec![0.0; v.len()]))
        })
    }

    /// The keys of a motion of this robot from one state to another within `horizon_s`; all others are as by default.
    /// A state is a pair of positions and velocities.
    #[must_use]
    pub fn new(robot: String, horizon_s: f64, start: [Vec<f64>; 2], goal: [Vec<f64>; 2]) -> Self {
        let [q_start, v_start] = start;
        let [q_goal, v_goal] = goal;
        Self {
            schema: None,
            robot,
            packages: BTreeMap::new(),
            root: None,
            mount: None,
            gravity: None,
            mimic: Mimic::default(),
            srdf: None,
            group: None,
            held_state: None,
            locked_joints: BTreeMap::new(),
            losses: Losses::default(),
            payload: None,
            passive: Vec::new(),
            horizon_s,
            q_start,
            v_start,
            a_start: None,
            start_tolerance: None,
            q_goal,
            v_goal,
            a_goal: None,
            turns: Turns::default(),
            goal: Vec::new(),
            keep: Vec::new(),
            waypoints: Vec::new(),
            stand: None,
            phases: Vec::new(),
            periodic: false,
            free_final_velocity: false,
            continuity: None,
            objective: Objective::default(),
            free_horizon: None,
            obstacles: Vec::new(),
            robot_shape: None,
            self_collision: None,
            clearance_m: Clearance::default(),
            enforced_limits: EnforcedLimits::default(),
            flow: FlowParameters::default(),
            feedback: kinova_gains(),
            success_threshold: paper_threshold(),
        }
    }

    /// Refuses states at the ends with another number of values than `model` has joints. `path` names the scenario.
    pub(crate) fn check_states(&self, model: &Model, path: &str) -> Result<()> {
        let given = [("a_start", &self.a_start), ("a_goal", &self.a_goal)];
        let given = given.into_iter().filter_map(|(key, a)| Some((key, a.as_ref()?)));
        if let (Some((key, _)), Continuous::Velocity) = (given.clone().next(), self.continuity()) {
            let condition = "accelerations are continuous only with \"continuity\": \"acceleration\"";
            return Err(Error::input(path, key, condition));
        }
        let states = [
            ("q_start", &self.q_start),
            ("v_start", &self.v_start),
            ("q_goal", &self.q_goal),
            ("v_goal", &self.v_goal),
        ];
        let expected = model.dof();
        let Some((key, state)) = states.into_iter().chain(given).find(|(_, state)| state.len() != expected) else {
            return Ok(());
        };
        let left = if self.locked_joints.is_empty() { "" } else { " that are not locked" };
        let condition = match (key, state.len()) {
            ("q_goal", 0) => "neither q_goal nor goal is given".to_owned(),
            (_, found) => {
                format!("the robot has {expected} joints{left}, but {found} values are given")
            }
        };
        Err(Error::input(path, key, condition))
    }

    /// Refuses invalid parameters of the flow and of the simulation, horizons and degrees.
    pub(crate) fn check_numbers(&self, path: &str) -> Result<()> {
        let positive = [
            ("flow.k", self.flow.k),
            ("flow.s_max", self.flow.s_max),
            ("flow.k_cons", self.flow.k_cons),
            ("flow.c_cons", self.flow.c_cons),
            ("success_threshold", self.success_threshold),
        ];
        let refuse = |key: &str, value: f64, needed: &str| {
            let condition = format!("it is {} and must be {needed}", plain(value));
            Err(Error::input(path, key, condition))
        };
        for (key, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return refuse(key, value, "a positive number");
            }
        }
        let gains = [("feedback.kp", self.feedback.kp), ("feedback.kv", self.feedback.kv)];
        for (key, gain) in gains {
            if !(gain.is_finite() && gain >= 0.0) {
                return refuse(key, gain, "a number of at least 0");
            }
        }
        Problem::check_horizon(self.horizon_s).map_err(|condition| Error::input(path, "horizon_s", condition))?;
        Chebyshev::check_degree(self.flow.degree).map_err(|condition| Error::input(path, "flow.degree", condition))
    }
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
