//! The keys of a scenario that change the objective of the direct method from least control effort between two states.

use super::{IgnoredPair, Method, RobotShape, Scenario, ScenarioFile};
use aghf::cost::WeightedSquares;
use aghf::direct::FreeHorizon;
use aghf::error::{Error, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The weights of a running cost $\sum_i w^u_i u_i^2 + w^v_i v_i^2 + w^a_i a_i^2$.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RunningCostWeights {
    /// Weights of squared torques or forces, one by default.
    pub torque: PerJoint,
    /// Weights of squared velocities, zero by default.
    pub velocity: PerJoint,
    /// Weights of squared accelerations, zero by default.
    pub acceleration: PerJoint,
}

impl Default for RunningCostWeights {
    /// The control effort.
    fn default() -> Self {
        Self {
            torque: PerJoint::Same(1.0),
            velocity: PerJoint::Same(0.0),
            acceleration: PerJoint::Same(0.0),
        }
    }
}

impl RunningCostWeights {
    /// The running cost for a robot with `dof` joints.
    ///
    /// # Errors
    /// Those of [`WeightedSquares::new`].
    pub fn weighted(&self, dof: usize) -> Result<WeightedSquares> {
        let [torque, velocity, acceleration] =
            [&self.torque, &self.velocity, &self.acceleration].map(|weights| weights.all(dof));
        WeightedSquares::new(dof, torque, velocity, acceleration)
    }
}

/// One number per joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a number is needed, or a list with one for each joint"
)]
pub enum PerJoint {
    /// The same number for all joints.
    Same(f64),
    /// One number per joint, in their order.
    Each(Vec<f64>),
}

impl PerJoint {
    /// One number for each of `dof` joints, or as many as there are in a list.
    pub(super) fn all(&self, dof: usize) -> Vec<f64> {
        match self {
            Self::Same(number) => vec![*number; dof],
            Self::Each(numbers) => numbers.clone(),
        }
    }
}

aghf::names::named_enum! {
/// The highest derivative of a motion that is continuous.
pub enum Continuous("continuity") {
    /// The acceleration.
    Acceleration = "acceleration",
    /// The velocity; accelerations jump between segments, and at the ends.
    Velocity = "velocity",
}
}

impl ScenarioFile {
    /// The highest continuous derivative of motions by the direct method.
    #[must_use]
    pub fn continuity(&self) -> Continuous {
        let default = match self.passive.is_empty() {
            true => Continuous::Acceleration,
            false => Continuous::Velocity,
        };
        self.continuity.unwrap_or(default)
    }
}

/// The bounds and the weight of a free horizon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "an object with the keys shortest_s, longest_s and weight"
)]
pub struct HorizonBounds {
    /// The shortest horizon, s.
    pub shortest_s: f64,
    /// The longest horizon, s.
    pub longest_s: f64,
    /// The cost per second.
    pub weight: f64,
}

impl From<HorizonBounds> for FreeHorizon {
    fn from(bounds: HorizonBounds) -> Self {
        Self {
            shortest: bounds.shortest_s,
            longest: bounds.longest_s,
            weight: bounds.weight,
        }
    }
}

/// Refuses keys of this file that are invalid for a robot with `dof` joints. `path` names the scenario.
pub(super) fn check_objective(file: &ScenarioFile, dof: usize, path: &str) -> Result<()> {
    let named = |error: Error, key: &dyn Fn(&str) -> String| match error {
        Error::Input {
            element, condition, ..
        } => Error::input(path, key(&element), condition),
        other => other,
    };
    if let Some(weights) = &file.running_cost {
        let key = |element: &str| match element {
            "all" => "running_cost".to_owned(),
            _ => format!("running_cost.{element}"),
        };
        weights.weighted(dof).map_err(|error| named(error, &key))?;
    }
    if file.enforced_limits.jerk.is_some() && file.continuity() == Continuous::Velocity {
        let condition = "the continuity is 'velocity', with which accelerations jump";
        return Err(Error::input(path, "enforced_limits.jerk", condition));
    }
    if let Some(bounds) = file.free_horizon {
        let key = |element: &str| match element {
            "free_horizon.weight" => element.to_owned(),
            bound => format!("{bound}_s"),
        };
        let checked = FreeHorizon::from(bounds).check(file.horizon_s);
        checked.map_err(|error| named(error, &key))?;
    }
    Ok(())
}

impl Scenario {
    /// The keys of this scenario that the method ignores, and what keeps clear of what though no key says so, in words.
    pub(super) fn notes(&self, method: Method) -> Vec<String> {
        let unnamed = |IgnoredPair {
                           links: [a, b],
                           reason,
                       }: &IgnoredPair| {
            format!(
                "self_collision: links '{a}' and '{b}' {reason}, so they are not kept clear of each other"
            )
        };
        let mut notes: Vec<_> = self.overlapping.iter().map(unnamed).collect();
        notes.extend(self.kept_clear().map(str::to_owned));
        if method == Method::Flow && self.file.running_cost.is_some() {
            let note = "running_cost: the published flow minimises the control effort alone";
            notes.push(note.to_owned());
        }
        notes
    }

    /// The note on what keeps clear of what by default.
    fn kept_clear(&self) -> Option<&'static str> {
        let file = &self.file;
        match (self.robot_shape(), &file.robot_shape, &file.self_collision) {
            (RobotShape::JointFrames, None, _) if !file.obstacles.is_empty() => Some(
                "robot_shape: the robot has no collision shapes, so only the origins of joint frames keep clear of \
                 obstacles; \"swept_links\" takes its links with a radius",
            ),
            (RobotShape::Collision { .. }, None, None) => Some(
                "robot_shape: the collision shapes of the robot keep clear of obstacles, and of each other but for \
                 neighbours; \"joint_frames\" plans without them",
            ),
            (RobotShape::Collision { .. }, None, Some(_)) if !file.obstacles.is_empty() => Some(
                "robot_shape: the collision shapes of the robot keep clear of obstacles; \"joint_frames\" plans \
                 without them",
            ),
            (RobotShape::Collision { .. }, Some(_), None) => Some(
                "self_collision: links keep clear of each other but for neighbours; \"off\" lets them overlap",
            ),
            _ => None,
        }
    }

    /// Refuses keys that the method does not support: those of the direct method alone, and passive joints in the
    /// published flow.
    pub(super) fn check_for(&self, method: Method) -> Result<()> {
        let file = &self.file;
        let keys = [
            ("free_final_velocity", file.free_final_velocity),
            ("goal", !file.goal.is_empty()),
            ("keep", !file.keep.is_empty()),
            ("stand", file.stand.is_some()),
            ("free_horizon", file.free_horizon.is_some()),
            (
                "enforced_limits.acceleration",
                file.enforced_limits.acceleration.is_some(),
            ),
            ("enforced_limits.jerk", file.enforced_limits.jerk.is_some()),
            ("rows in (t, q, v, a, u)", !self.own.stage.is_empty()),
        ];
        let unknown = keys.iter().find(|(_, given)| *given);
        if let (Some((key, _)), true) = (unknown, method != Method::Direct) {
            let condition = format!("the method '{method}' does not know it, only 'direct' does");
            return Err(Error::input(&self.name, *key, condition));
        }
        if method == Method::Flow && self.own.running_cost.is_some() {
            let condition = "the published flow does not know it, all other methods do";
            return Err(Error::input(
                &self.name,
                "running cost of one's own",
                condition,
            ));
        }
        if method == Method::Flow && !file.passive.is_empty() {
            let condition =
                "the published flow does not know it; the methods 'duals' and 'two_phases' do";
            return Err(Error::input(&self.name, "passive", condition));
        }
        Ok(())
    }
}
