//! The states of joints in a planning scene and a request.

use super::constraints::Target;
use super::messages::RobotState;
use aghf::error::{Error, Result, plain};
use aghf::model::{Joint, JointKind, Model};
use aghf::plan::nearest_turn;
use aghf::urdf::{LoadNote, LoadReport};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// The largest distance beyond a limit that counts as rounding, rad or m: that of numbers with six digits.
const ROUNDING: f64 = 1e-5;

/// The joints of the robot: those that move, with their states at both ends, and the others.
pub(super) struct Joints<'a> {
    pub moving: Vec<&'a Joint<f64>>,
    pub q_start: Vec<f64>,
    pub v_start: Vec<f64>,
    /// Empty for a goal by pose.
    pub q_goal: Vec<f64>,
    pub locked: BTreeMap<String, f64>,
}

impl<'a> Joints<'a> {
    /// Separates the joints that are `planned` from the others. The state of a joint is that of the first of the two
    /// states that has it.
    ///
    /// # Errors
    /// A joint without a position, or one that moves at the start and is not planned, in words.
    pub fn of(
        model: &'a Model,
        planned: &BTreeSet<String>,
        states: [&States; 2],
        target: &Target,
        notes: &mut LoadReport,
    ) -> std::result::Result<Self, String> {
        let mut joints = Self {
            moving: Vec::new(),
            q_start: Vec::new(),
            v_start: Vec::new(),
            q_goal: Vec::new(),
            locked: BTreeMap::new(),
        };
        for joint in model.joints() {
            let name = joint.name();
            let Some([q, v]) = states.iter().find_map(|state| state.0.get(name)) else {
                return Err(format!("joint '{name}' of the robot is neither there nor in the scene"));
            };
            if !planned.contains(name) {
                if *v != 0.0 {
                    return Err(format!(
                        "joint '{name}' moves at {}, and is not planned; one that is held has velocity 0",
                        plain(*v)
                    ));
                }
                joints.locked.insert(name.to_owned(), *q);
                continue;
            }
            let start = within_limits(joint, *q, notes);
            joints.q_start.push(start);
            joints.v_start.push(*v);
            joints.moving.push(joint);
            if let Target::Joints(goal) = target {
                let goal = goal.get(name);
                (joints.q_goal).extend(goal.map(|q| goal_near(joint, *q, start, notes)));
            }
        }
        Ok(joints)
    }
}

/// The positions and velocities of joints by name.
pub(super) struct States(pub BTreeMap<String, [f64; 2]>);

impl States {
    /// Reads a state. Joints that the robot lacks, such as the wheels of its base, are noted. `key` is the position of
    /// the state in `file`.
    pub fn of(state: &RobotState, model: &Model, [file, key]: [&str; 2], notes: &mut LoadReport) -> Result<Self> {
        let refuse = |what: &str, condition: String| Err(Error::input(file, format!("{key}.{what}"), condition));
        let joints = &state.joint_state;
        let count = joints.name.len();
        if count != joints.position.len() {
            let positions = joints.position.len();
            let condition = format!("it has {count} names, but {positions} positions");
            return refuse("joint_state", condition);
        }
        let velocities = match joints.velocity.len() {
            0 => &vec![0.0; count],
            given if given == count => &joints.velocity,
            given => {
                let condition = format!("it has {count} names, but {given} velocities");
                return refuse("joint_state", condition);
            }
        };
        let transforms = &state.multi_dof_joint_state.transforms;
        if let Some(i) = transforms.iter().position(|of| !of.is_identity()) {
            let what = format!("multi_dof_joint_state.transforms[{i}]");
            return refuse(&what, "it moves the robot, whose base is fixed".to_owned());
        }
        let mut states = BTreeMap::new();
        let values = joints.position.iter().zip(velocities);
        for (i, (name, (q, v))) in joints.name.iter().zip(values).enumerate() {
            if !has_joint(model, name) {
                let note = LoadNote::Missing { joint: name.clone() };
                if !notes.contains(&note) {
                    notes.push(note);
                }
            }
            if states.insert(name.clone(), [*q, *v]).is_some() {
                let condition = format!("joint '{name}' is named twice");
                return refuse(&format!("joint_state.name[{i}]"), condition);
            }
        }
        Ok(Self(states))
    }
}

/// The goal of a joint; of a continuous one, where a position means the angle, as near as possible to its start.
fn goal_near(joint: &Joint<f64>, goal: f64, start: f64, notes: &mut LoadReport) -> f64 {
    if joint.kind() != JointKind::Continuous {
        return within_limits(joint, goal, notes);
    }
    let near = nearest_turn(goal, start, [f64::NEG_INFINITY, f64::INFINITY]);
    if near != goal {
        let turns = plain(((near - goal) / TAU).round());
        let unit = if ["1", "-1"].contains(&turns.as_str()) { "turn" } else { "turns" };
        notes.push(LoadNote::Turned { joint: joint.name().to_owned(), by: format!("{turns} {unit}") });
    }
    near
}

/// The position of a joint, or its limit if that is exceeded by [`ROUNDING`] at most, which is noted.
fn within_limits(joint: &Joint<f64>, position: f64, notes: &mut LoadReport) -> f64 {
    let limits = joint.limits();
    let inside = position.max(limits.lower).min(limits.upper);
    let by = (position - inside).abs();
    if by == 0.0 || by > ROUNDING {
        return position;
    }
    notes.push(LoadNote::AtLimit { joint: joint.name().to_owned(), by: format!("{by:.1e}") });
    inside
}

/// Returns true if the robot has a moving or fixed joint of this name.
fn has_joint(model: &Model, name: &str) -> bool {
    let carriers = model.frames().iter().filter_map(|f| f.carrier.as_ref());
    let mut names = carriers.map(|carrier| carrier.joint.as_str());
    names.any(|joint| joint == name)
}
