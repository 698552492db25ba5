//! The joint limits that act as constraints.

use crate::{Quantity, RateLimits, Scenario};
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, Constraint, Constraints, PowerLimits, RateLimit, Side, StageConstraint,
    StageConstraints, TorqueLimits,
};
use aghf::error::{Error, Result, plain};
use aghf::geometry::Scene;
use aghf::model::Model;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The joint limits that act as constraints; by default all limits of the robot. Violations of the others are only
/// reported.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    default,
    expecting = "an object with some of the keys position, velocity, torque, max_velocity, acceleration, jerk and power"
)]
pub struct EnforcedLimits {
    /// The position limits. A share of a range is centred; a range with one finite end is not scaled.
    pub position: Enforced,
    /// The velocity limits.
    pub velocity: Enforced,
    /// The torque and force limits.
    pub torque: Enforced,
    /// The largest velocities, rad/s or m/s, beside those of the robot: the smaller ones hold; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_velocity: Option<RateLimits>,
    /// For the direct method: the largest accelerations, rad/s^2 or m/s^2; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<RateLimits>,
    /// For the direct method: the largest rates of accelerations, rad/s^3 or m/s^3; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jerk: Option<RateLimits>,
    /// For the direct method: the largest absolute powers of the motors, torque times velocity, W, as numbers
    /// alone; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<RateLimits>,
}

/// The enforced part of one kind of limit.
///
/// In JSON: `true`, `false`, a share, or an object with the optional keys `share` and `joints`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(from = "Written", into = "Written")]
#[schemars(with = "Written")]
pub enum Enforced {
    /// No limit.
    No,
    /// The limits of some or all joints, scaled.
    Share {
        /// The usable fraction of a limit, above 0 and at most 1.
        share: f64,
        /// The names of the joints; `None` for all.
        joints: Option<Vec<String>>,
    },
}

impl Default for Enforced {
    /// All limits, unscaled.
    fn default() -> Self {
        Self::Share { share: whole(), joints: None }
    }
}

impl EnforcedLimits {
    /// No limits.
    pub const NONE: Self = Self {
        position: Enforced::No,
        velocity: Enforced::No,
        torque: Enforced::No,
        max_velocity: None,
        acceleration: None,
        jerk: None,
        power: None,
    };

    /// The limits that are numbers, with their keys.
    pub(crate) fn numbers(&self) -> [(Quantity, &'static str, &Option<RateLimits>); 4] {
        [
            (Quantity::Velocity, "max_velocity", &self.max_velocity),
            (Quantity::Acceleration, "acceleration", &self.acceleration),
            (Quantity::Jerk, "jerk", &self.jerk),
            (Quantity::Power, "power", &self.power),
        ]
    }

    /// The same to change them.
    pub(crate) fn numbers_mut(&mut self) -> [(Quantity, &'static str, &mut Option<RateLimits>); 4] {
        [
            (Quantity::Velocity, "max_velocity", &mut self.max_velocity),
            (Quantity::Acceleration, "acceleration", &mut self.acceleration),
            (Quantity::Jerk, "jerk", &mut self.jerk),
            (Quantity::Power, "power", &mut self.power),
        ]
    }

    /// Returns true if limits of any kind are enforced, whether or not the robot has such limits.
    #[must_use]
    pub fn any(&self) -> bool {
        *self != Self::NONE
    }

    /// The enforced lower and upper bound on a quantity of joint `joint` of `model`, in its unit; one of them may be
    /// infinite. `None` if nothing is enforced, or if `limit` is not a limit of a joint.
    #[must_use]
    pub fn bound(&self, model: &Model, limit: Quantity, joint: usize) -> Option<[f64; 2]> {
        let of_robot = self.bound_of_robot(model, limit, joint);
        let number =
            self.numbers().into_iter().find(|(of, ..)| *of == limit).and_then(|(.., numbers)| numbers.as_ref());
        match number.and_then(|numbers| numbers.of(joint)) {
            None => of_robot,
            Some(most) => {
                let [lower, upper] = of_robot.unwrap_or([-most, most]);
                Some([lower.max(-most), upper.min(most)])
            }
        }
    }

    /// The enforced part of a limit of the robot.
    fn bound_of_robot(&self, model: &Model, limit: Quantity, joint: usize) -> Option<[f64; 2]> {
        let joint = model.joints().get(joint)?;
        let share = self.of(limit)?.share(joint.name())?;
        let limits = joint.limits();
        let both = |most: f64| [-share * most, share * most];
        let [lower, upper] = match limit {
            Quantity::Position => within([limits.lower, limits.upper], share),
            Quantity::Velocity => both(limits.velocity),
            Quantity::Torque => both(limits.effort),
            _ => return None,
        };
        (lower.is_finite() || upper.is_finite()).then_some([lower, upper])
    }

    /// The enforced part of a kind of limit.
    fn of(&self, limit: Quantity) -> Option<&Enforced> {
        match limit {
            Quantity::Position => Some(&self.position),
            Quantity::Velocity => Some(&self.velocity),
            Quantity::Torque => Some(&self.torque),
            _ => None,
        }
    }

    /// Refuses invalid shares and limits, and unknown joint names. `path` names the scenario.
    pub(crate) fn check(&self, model: &Model, path: &str) -> Result<()> {
        for (_, key, limits) in self.numbers() {
            if let Some(limits) = limits {
                limits.check(model.dof(), &format!("enforced_limits.{key}"), path)?;
            }
        }
        for limit in Quantity::JOINT {
            let Some(Enforced::Share { share, joints }) = self.of(limit) else {
                continue;
            };
            let key = format!("enforced_limits.{}", limit.name());
            if !(*share > 0.0 && *share <= 1.0) {
                let condition = format!("it is {}, a share is above 0 and at most 1", plain(*share));
                return Err(Error::input(path, key, condition));
            }
            let known = |name: &String| model.joints().iter().any(|joint| joint.name() == name);
            if let Some(unknown) = joints.iter().flatten().find(|name| !known(name)) {
                let condition = model.no_moving_joint(unknown);
                return Err(Error::input(path, format!("{key}.joints"), condition));
            }
        }
        Ok(())
    }
}

/// The central part of a range of relative size `share`.
fn within([lower, upper]: [f64; 2], share: f64) -> [f64; 2] {
    let cut = 0.5 * (1.0 - share) * (upper - lower);
    if cut.is_finite() { [lower + cut, upper - cut] } else { [lower, upper] }
}

impl Enforced {
    /// Returns true if the limits of all joints are enforced.
    pub(crate) fn is_of_all(&self) -> bool {
        matches!(self, Self::Share { joints: None, .. })
    }

    /// The share enforced for a joint.
    fn share(&self, joint: &str) -> Option<f64> {
        let Self::Share { share, joints } = self else {
            return None;
        };
        let named = |joints: &Vec<String>| joints.iter().any(|name| name == joint);
        joints.as_ref().is_none_or(named).then_some(*share)
    }
}

impl Scenario {
    /// The enforced bounds of this scenario, as [`EnforcedLimits::bound`] defines them. The bounds on the torque of a
    /// passive joint are always zero.
    #[must_use]
    pub fn bound(&self, limit: Quantity, joint: usize) -> Option<[f64; 2]> {
        if limit == Quantity::Torque && self.is_passive(joint) {
            return Some([0.0; 2]);
        }
        (self.file.enforced_limits).bound(&self.model, limit, joint)
    }

    /// The bounds that hold throughout: [`bound`](Self::bound), but for the position of a joint that starts outside of
    /// its limit.
    pub(crate) fn bound_throughout(&self, limit: Quantity, joint: usize) -> Option<[f64; 2]> {
        let at_start = if limit == Quantity::Position { self.bound_at_start(joint) } else { None };
        at_start.or_else(|| self.bound(limit, joint))
    }

    /// Returns true if the scenario has no constraint: no obstacle, no enforced limit, no passive joint and no
    /// user-defined constraint.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.scene.is_empty()
            && !self.limits_are_enforced()
            && self.own.constraints.is_empty()
            && self.own.stage.is_empty()
            && self.own.foot.is_none()
    }

    /// Returns true if any joint has a bound, which includes the zero torque of a passive joint.
    pub(crate) fn limits_are_enforced(&self) -> bool {
        let bounded = |limit| (0..self.model.dof()).any(|i| self.bound(limit, i).is_some());
        Quantity::JOINT.into_iter().any(bounded)
    }

    /// The constraints on the state: clearance from obstacles, enforced limits, and user-defined constraints.
    #[must_use]
    pub fn state_constraints(&self) -> Vec<AnyConstraint> {
        self.state_constraints_in(&self.scene)
    }

    /// The same among the obstacles of another scene.
    fn state_constraints_in(&self, scene: &Scene) -> Vec<AnyConstraint> {
        let mut constraints = AnyConstraint::of_scene(scene);
        let bound = |limit, joint| self.bound_throughout(limit, joint);
        constraints.extend(limits_of_state(self.model.dof(), bound));
        constraints.extend(self.own.constraints.iter().cloned());
        constraints
    }

    /// All constraints on a motion.
    #[must_use]
    pub fn constraints(&self) -> Constraints<Vec<AnyConstraint>> {
        self.constraints_in(&self.scene)
    }

    /// The same among the obstacles of another scene.
    pub(crate) fn constraints_in(&self, scene: &Scene) -> Constraints<Vec<AnyConstraint>> {
        let mut state = self.state_constraints_in(scene);
        let phases = self.phase_constraints(state.dim());
        let kept = self.phases.iter().flat_map(|phase| &phase.kept);
        state.extend(kept.cloned());
        Constraints {
            state,
            torque: self.torque_limits(),
            stage: StageConstraints { phases, ..self.stage_constraints() },
        }
    }

    /// The enforced limits of acceleration, jerk and power, a standing foot, and user-defined rows.
    #[must_use]
    pub fn stage_constraints(&self) -> StageConstraints {
        let all = [2, 3].into_iter().flat_map(|order| (0..self.model.dof()).map(move |joint| (order, joint)));
        let limit = |(order, joint): (usize, usize)| {
            let bound = self.bound(Quantity::JOINT[order], joint);
            bound.map(|[_, most]| RateLimit::both(order, joint, most))
        };
        let power = |joint| self.bound(Quantity::Power, joint).map(|[_, most]| most);
        let powers = PowerLimits((0..self.model.dof()).map(power).collect());
        let powers = (powers.dim() > 0).then(|| Arc::new(powers) as Arc<dyn StageConstraint>);
        StageConstraints {
            rates: all.filter_map(limit).flatten().collect(),
            foot: self.own.foot.clone(),
            phases: Vec::new(),
            custom: powers.into_iter().chain(self.own.stage.iter().cloned()).collect(),
        }
    }

    /// The enforced torque limits, zero for passive joints; empty if there are none.
    #[must_use]
    pub fn torque_limits(&self) -> TorqueLimits {
        let bound = |limit, joint| self.bound(limit, joint);
        limits_of_torque(self.model.dof(), bound)
    }

    /// The limits of the robot that are not enforced, not even in part.
    pub(crate) fn other_limits(&self) -> Constraints<Vec<AnyConstraint>> {
        let all = EnforcedLimits::default();
        let other = |limit, joint| match self.bound(limit, joint) {
            Some(_) => None,
            None => all.bound(&self.model, limit, joint),
        };
        let n = self.model.dof();
        Constraints { state: limits_of_state(n, other), torque: limits_of_torque(n, other), stage: Default::default() }
    }
}

/// The bounds on the positions and velocities of `n` joints as constraints, without those that have no rows.
pub(crate) fn limits_of_state(n: usize, bound: impl Fn(Quantity, usize) -> Option<[f64; 2]>) -> Vec<AnyConstraint> {
    let mut constraints = Vec::new();
    for (limit, first) in [(Quantity::Position, 0), (Quantity::Velocity, n)] {
        let bounds: Vec<Bound> = (0..n)
            .filter_map(|i| Some((first + i, bound(limit, i)?)))
            .flat_map(|(entry, bound)| {
                let sides = [Side::Lower, Side::Upper].into_iter().zip(bound);
                sides.map(move |(side, value)| Bound { entry, side, value })
            })
            .filter(|bound| bound.value.is_finite())
            .collect();
        if !bounds.is_empty() {
            constraints.push(AnyConstraint::Bounds(Bounds(bounds)));
        }
    }
    constraints
}

/// The bounds on the torques of `n` joints; empty if there are none.
fn limits_of_torque(n: usize, bound: impl Fn(Quantity, usize) -> Option<[f64; 2]>) -> TorqueLimits {
    let limits: Vec<Option<f64>> = (0..n).map(|i| bound(Quantity::Torque, i).map(|[_, most]| most)).collect();
    let any = limits.iter().any(Option::is_some);
    TorqueLimits(if any { limits } else { Vec::new() })
}

/// The JSON form of an [`Enforced`].
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "true, false, a share such as 0.8, or an object with the keys share and joints is needed"
)]
#[schemars(inline)]
enum Written {
    /// All limits, or none.
    All(bool),
    /// A share of all limits.
    Share(f64),
    /// A share of the limits of some joints.
    Part(Part),
}

/// A part of the limits, as an object.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Part {
    /// The share, above 0 and at most 1.
    #[serde(default = "whole")]
    share: f64,
    /// The names of the joints; by default all.
    #[serde(default)]
    joints: Option<Vec<String>>,
}

fn whole() -> f64 {
    1.0
}

impl From<Written> for Enforced {
    fn from(written: Written) -> Self {
        let (share, joints) = match written {
            Written::All(false) => return Self::No,
            Written::All(true) => (whole(), None),
            Written::Share(share) => (share, None),
            Written::Part(Part { share, joints }) => (share, joints),
        };
        Self::Share { share, joints }
    }
}

impl From<Enforced> for Written {
    fn from(enforced: Enforced) -> Self {
        match enforced {
            Enforced::No => Self::All(false),
            all if all == Enforced::default() => Self::All(true),
            Enforced::Share { share, joints: None } => Self::Share(share),
            Enforced::Share { share, joints } => Self::Part(Part { share, joints }),
        }
    }
}
