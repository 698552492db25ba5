//! The promises of a scenario: what a motion has to keep, as one list. The search, its report, the judge and the
//! certificate each go through this list and evaluate what is on it by formulas of their own.

use crate::{Quantity, Scenario, ScenarioFile};

/// A promise about a motion: a quantity between two bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Promise {
    /// The limited quantity.
    pub quantity: Quantity,
    /// The index of the joint for a quantity of a joint, or of the element of the key, if that is a list.
    pub index: Option<usize>,
    /// The bounds of a quantity of a joint, in rad or m, per s, s^2 or s^3, N m or N, W, or of the duration, s; one of
    /// them may be infinite. Those of other quantities are in the element of the key.
    pub bounds: [f64; 2],
    /// The times at which it is kept.
    pub scope: Scope,
}

/// The times at which a promise is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scope {
    /// At the start.
    Start,
    /// At the end.
    Goal,
    /// At the waypoint of this index.
    Waypoint(usize),
    /// Between two times, s, which are infinite for the whole motion.
    Between([f64; 2]),
}

impl Scope {
    /// All times.
    pub const THROUGHOUT: Self = Self::Between([f64::NEG_INFINITY, f64::INFINITY]);
}

/// The meaning of a key for a motion.
pub(super) enum Role {
    /// It asks for these.
    Promised(Vec<Promise>),
    /// It describes the robot, its load or their shape.
    Assumed,
    /// It asks for nothing.
    NoPromise,
    /// It asks for this, which is the promise of each phase of a walk.
    OfPhases,
}

/// The role of each key; one without a role does not compile.
#[rustfmt::skip]
pub(super) fn roles(scenario: &Scenario) -> Vec<(&'static str, Role)> {
    use Role::{Assumed, NoPromise, OfPhases, Promised};
    fn row<T>(key: &'static str, _value: &T, role: Role) -> (&'static str, Role) {
        (key, role)
    }
    let none = [f64::NEG_INFINITY, f64::INFINITY];
    let promise = |quantity, scope| Promise { quantity, index: None, bounds: none, scope };
    let one = |is_asked: bool, quantity: Quantity, scope: Scope| {
        if is_asked { Promised(vec![promise(quantity, scope)]) } else { NoPromise }
    };
    let each = |scopes: Vec<Scope>, quantity: Quantity| {
        let all = scopes.into_iter().enumerate();
        Promised(all.map(|(i, scope)| Promise { index: Some(i), ..promise(quantity, scope) }).collect())
    };
    let unless = |are_phases: bool| if are_phases { OfPhases } else { NoPromise };
    let ScenarioFile {
        schema, robot, packages, root, mount, gravity, mimic, srdf, group, held_state, locked_joints, losses,
        payload, passive, horizon_s, q_start, v_start, a_start, start_tolerance, q_goal, v_goal, a_goal, turns, goal,
        keep, waypoints, stand, phases, periodic, free_final_velocity, continuity, objective, free_horizon,
        obstacles, robot_shape, self_collision, clearance_m, enforced_limits, flow, feedback, success_threshold,
    } = &scenario.file;
    let (is_free, apart) = (scenario.file.has_free_horizon(), scenario.keeps_links_clear());
    let horizon = Promise { bounds: scenario.file.horizon_bounds(), ..promise(Quantity::Duration, Scope::Goal) };
    let limits = scenario.limits().into_iter();
    let (without_motor, limits): (Vec<_>, Vec<_>) = limits.partition(|limit| limit.quantity == Quantity::Passive);
    let (limits, back): (Vec<_>, Vec<_>) = limits.into_iter().partition(|limit| limit.scope == Scope::THROUGHOUT);
    vec![
        row("$schema", schema, NoPromise),
        row("robot", robot, Assumed),
        row("packages", packages, NoPromise),
        row("root", root, Assumed),
        row("mount", mount, Assumed),
        row("gravity", gravity, Assumed),
        row("mimic", mimic, Assumed),
        row("srdf", srdf, NoPromise),
        row("group", group, NoPromise),
        row("held_state", held_state, NoPromise),
        row("locked_joints", locked_joints, Assumed),
        row("losses", losses, Assumed),
        row("payload", payload, Assumed),
        row("passive", passive, if passive.is_empty() { NoPromise } else { Promised(without_motor) }),
        row("horizon_s", horizon_s, if is_free { NoPromise } else { Promised(vec![horizon.clone()]) }),
        row("q_start", q_start, one(true, Quantity::Position, Scope::Start)),
        row("v_start", v_start, one(true, Quantity::Velocity, Scope::Start)),
        row("a_start", a_start, one(a_start.is_some(), Quantity::Acceleration, Scope::Start)),
        row("start_tolerance", start_tolerance, if start_tolerance.is_some() { Promised(back) } else { NoPromise }),
        row("q_goal", q_goal, one(goal.is_empty(), Quantity::Position, Scope::Goal)),
        row("v_goal", v_goal, one(!free_final_velocity, Quantity::Velocity, Scope::Goal)),
        row("a_goal", a_goal, one(a_goal.is_some(), Quantity::Acceleration, Scope::Goal)),
        row("turns", turns, NoPromise),
        row("goal", goal, one(!goal.is_empty(), Quantity::Frame, Scope::Goal)),
        row("keep", keep, each(keep.iter().map(|kept| Scope::Between(kept.times())).collect(), Quantity::Frame)),
        row("waypoints", waypoints, each((0..waypoints.len()).map(Scope::Waypoint).collect(), Quantity::Frame)),
        row("stand", stand, one(stand.is_some(), Quantity::Foot, Scope::THROUGHOUT)),
        row("phases", phases, unless(!phases.is_empty())),
        row("periodic", periodic, unless(*periodic)),
        row("free_final_velocity", free_final_velocity, NoPromise),
        row("continuity", continuity, one(true, Quantity::Acceleration, Scope::THROUGHOUT)),
        row("objective", objective, NoPromise),
        row("free_horizon", free_horizon, if free_horizon.is_some() { Promised(vec![horizon]) } else { NoPromise }),
        row("obstacles", obstacles, one(!obstacles.is_empty(), Quantity::Obstacles, Scope::THROUGHOUT)),
        row("robot_shape", robot_shape, Assumed),
        row("self_collision", self_collision, one(apart, Quantity::SelfCollision, Scope::THROUGHOUT)),
        row("clearance_m", clearance_m, one(apart || !obstacles.is_empty(), Quantity::Obstacles, Scope::THROUGHOUT)),
        row("enforced_limits", enforced_limits, Promised(limits)),
        row("flow", flow, NoPromise),
        row("feedback", feedback, NoPromise),
        row("success_threshold", success_threshold, NoPromise),
    ]
}

impl Scenario {
    /// All promises, each once.
    #[must_use]
    pub fn promises(&self) -> Vec<Promise> {
        let mut all: Vec<Promise> = Vec::new();
        for (_, role) in roles(self) {
            if let Role::Promised(mut own) = role {
                own.retain(|promise| !all.contains(promise));
                all.extend(own);
            }
        }
        all
    }

    /// The enforced limits of the joints, by quantities; those of the torque of a joint without a motor are zero. A
    /// joint that [starts outside](crate::StartTolerance) of its limit has two, of which one begins later.
    #[must_use]
    pub fn limits(&self) -> Vec<Promise> {
        let all = Quantity::JOINT.into_iter().flat_map(|of| (0..self.model.dof()).map(move |joint| (of, joint)));
        let limits = |(of, joint): (Quantity, usize)| {
            let quantity = if of == Quantity::Torque && self.is_passive(joint) { Quantity::Passive } else { of };
            let bounds = self.bound_throughout(of, joint).map(|bounds| (bounds, Scope::THROUGHOUT));
            let back = self.bound_when_back(joint).filter(|_| of == Quantity::Position);
            let back = back.map(|(bounds, back_s)| (bounds, Scope::Between([back_s, f64::INFINITY])));
            let all = bounds.into_iter().chain(back);
            all.map(move |(bounds, scope)| Promise { quantity, index: Some(joint), bounds, scope })
        };
        all.flat_map(limits).collect()
    }
}

/// A promise about a quantity in words, for readers.
#[must_use]
pub fn promise_in_words(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Duration => "horizon",
        Quantity::Position => "position limits",
        Quantity::Velocity => "velocity limits",
        Quantity::Acceleration => "acceleration limits",
        Quantity::Jerk => "jerk limits",
        Quantity::Torque => "torque limits",
        Quantity::Power => "power limits",
        Quantity::Passive => "passive joints",
        Quantity::Frame => "conditions along the way",
        Quantity::Foot => "standing foot",
        Quantity::Obstacles => "obstacles",
        Quantity::SelfCollision => "self-collision",
        Quantity::Other => "added constraints",
    }
}
