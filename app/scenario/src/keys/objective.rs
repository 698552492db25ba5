//! The keys of a scenario that change the objective of the direct method from least control effort between two states.

use crate::keys::schema::one_of;
use crate::{Method, Quantity, Scenario, ScenarioFile};
use aghf::direct::FreeHorizon;
use aghf::error::{Error, Result, plain};
use aghf::model::Model;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt;

/// The objective: a preset by its name, or weights. The control effort by default.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Objective {
    /// A preset.
    Preset(Preset),
    /// The weights of a sum.
    Weights(ObjectiveWeights),
}

aghf::names::named_enum! {
/// An objective that means the same for every robot.
pub enum Preset("objective") {
    /// The least control effort; where the horizon is free, a second costs nothing.
    LeastEffort = "least-effort",
    /// The least duration within the limits: the weight of the effort vanishes in steps.
    LeastTime = "least-time",
    /// The least control effort that takes at most 1.25 times the least duration that was found.
    Balanced = "balanced",
}
}

impl Default for Objective {
    fn default() -> Self {
        Self::Preset(Preset::LeastEffort)
    }
}

impl Objective {
    /// The preset, if it is one: a weight of time alone is least time.
    #[must_use]
    pub fn preset(&self) -> Option<Preset> {
        match self {
            Self::Preset(preset) => Some(*preset),
            Self::Weights(weights) => weights.is_time_alone().then_some(Preset::LeastTime),
        }
    }

    /// Returns true if a shorter motion is a better one, so that the horizon is an unknown.
    #[must_use]
    pub fn weighs_time(&self) -> bool {
        match self {
            Self::Preset(preset) => *preset != Preset::LeastEffort,
            Self::Weights(weights) => weights.time > 0.0,
        }
    }
}

impl<'de> Deserialize<'de> for Objective {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Objective;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of an objective, or an object with weights")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> std::result::Result<Objective, E> {
                name.parse().map(Objective::Preset).map_err(E::custom)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Objective, A::Error> {
                ObjectiveWeights::deserialize(MapAccessDeserializer::new(map)).map(Objective::Weights)
            }
        }
        from.deserialize_any(Either)
    }
}

impl JsonSchema for Objective {
    fn schema_name() -> Cow<'static, str> {
        "Objective".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let weights = generator.subschema_for::<ObjectiveWeights>();
        json_schema!({ "anyOf": [one_of::<Preset>(generator), weights] })
    }
}

/// The weights of an objective $w^t T + \int \sum_i w^u_i u_i^2 + w^v_i v_i^2 + w^a_i a_i^2 + w^j_i \dot a_i^2\, dt$.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ObjectiveWeights {
    /// The units in which the terms are measured.
    #[schemars(schema_with = "one_of::<Units>")]
    pub units: Units,
    /// Weight of the duration, zero by default. Where it is positive the horizon is an unknown; alone it is
    /// `least-time`.
    pub time: f64,
    /// Weights of squared torques or forces, one by default.
    pub effort: PerJoint,
    /// Weights of squared velocities, zero by default.
    pub velocity: PerJoint,
    /// Weights of squared accelerations, zero by default.
    pub acceleration: PerJoint,
    /// For the direct method: weights of the squared rates of accelerations, zero by default.
    pub jerk: PerJoint,
}

aghf::names::named_enum! {
/// The units of the terms of an objective.
pub enum Units("units") {
    /// Each term in units of its value for the straight motion between the ends in twice the least horizon, the
    /// duration in units of the least horizon, so that weights mean the same for every robot.
    Scaled = "scaled",
    /// Seconds, and the integrals of squares in N m, rad/s and so on.
    Si = "si",
}
}

impl Default for ObjectiveWeights {
    /// The control effort.
    fn default() -> Self {
        let zero = PerJoint::Same(0.0);
        Self {
            units: Units::default(),
            time: 0.0,
            effort: PerJoint::Same(1.0),
            velocity: zero.clone(),
            acceleration: zero.clone(),
            jerk: zero,
        }
    }
}

impl ObjectiveWeights {
    /// The weights of the integrals, each with its key.
    pub(crate) fn integrals(&self) -> [(&'static str, &PerJoint); 4] {
        [
            ("effort", &self.effort),
            ("velocity", &self.velocity),
            ("acceleration", &self.acceleration),
            ("jerk", &self.jerk),
        ]
    }

    /// Returns true if nothing but time has a weight.
    fn is_time_alone(&self) -> bool {
        self.time > 0.0 && self.has_no_integral()
    }

    /// Returns true if no integral has a weight.
    fn has_no_integral(&self) -> bool {
        self.integrals().iter().all(|(_, weights)| weights.is_zero())
    }

    /// Refuses weights that are negative, for another number of joints than `dof`, or all zero. `path` names the
    /// scenario.
    fn check(&self, dof: usize, path: &str) -> Result<()> {
        let refuse = |key: &str, condition: String| Err(Error::input(path, format!("objective{key}"), condition));
        let negative = |w: &f64| !(w.is_finite() && *w >= 0.0);
        let fault = |w: f64| format!("it is {}, a weight is not negative", plain(w));
        if negative(&self.time) {
            return refuse(".time", fault(self.time));
        }
        for (key, weights) in self.integrals() {
            let (key, weights) = (format!(".{key}"), weights.all(dof));
            if weights.len() != dof {
                let found = weights.len();
                let joints = format!("the robot has {dof} joints, but {found} values are given");
                return refuse(&key, joints);
            }
            if let Some(w) = weights.iter().copied().find(negative) {
                return refuse(&key, fault(w));
            }
        }
        if self.has_no_integral() && self.time == 0.0 {
            return refuse("", "all are zero, at least one is needed".to_owned());
        }
        Ok(())
    }
}

/// One number per joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a number is needed, or a list with one for each joint")]
pub enum PerJoint {
    /// The same number for all joints.
    Same(f64),
    /// One number per joint, in their order.
    Each(Vec<f64>),
}

impl PerJoint {
    /// One number for each of `dof` joints, or as many as there are in a list.
    pub(crate) fn all(&self, dof: usize) -> Vec<f64> {
        match self {
            Self::Same(number) => vec![*number; dof],
            Self::Each(numbers) => numbers.clone(),
        }
    }

    /// Returns true if all are zero.
    fn is_zero(&self) -> bool {
        match self {
            Self::Same(number) => *number == 0.0,
            Self::Each(numbers) => numbers.iter().all(|number| *number == 0.0),
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
        let default = if self.passive.is_empty() && self.phases.is_empty() {
            Continuous::Acceleration
        } else {
            Continuous::Velocity
        };
        self.continuity.unwrap_or(default)
    }
}

/// The bounds of a free horizon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys shortest_s and longest_s")]
pub struct HorizonBounds {
    /// The shortest horizon, s.
    pub shortest_s: f64,
    /// The longest horizon, s.
    pub longest_s: f64,
}

impl HorizonBounds {
    /// The free horizon with this cost of a second.
    pub(crate) fn weighted(self, weight: f64) -> FreeHorizon {
        FreeHorizon { shortest: self.shortest_s, longest: self.longest_s, weight }
    }
}

/// Refuses keys of this file that are invalid for a robot. `path` names the scenario.
pub(crate) fn check_objective(file: &ScenarioFile, model: &Model, path: &str) -> Result<()> {
    let jumps = file.continuity() == Continuous::Velocity;
    let condition = "the continuity is 'velocity', with which accelerations jump";
    if let Objective::Weights(weights) = &file.objective {
        weights.check(model.dof(), path)?;
        if jumps && !weights.jerk.is_zero() {
            return Err(Error::input(path, "objective.jerk", condition));
        }
    }
    if file.enforced_limits.jerk.is_some() && jumps {
        return Err(Error::input(path, "enforced_limits.jerk", condition));
    }
    let preset = file.objective.preset();
    let timed = preset.is_some_and(|preset| preset != Preset::LeastEffort);
    if timed && file.free_horizon.is_none() && !file.bounds_time(model) {
        let condition = "without limits there is no least time: limits of rates or torques or free_horizon are needed";
        return Err(Error::input(path, "objective", condition));
    }
    if let Some(bounds) = file.free_horizon {
        let checked = bounds.weighted(0.0).check(file.horizon_s);
        checked.map_err(|error| match error {
            Error::Input { element, condition, .. } => Error::input(path, format!("{element}_s"), condition),
            other => other,
        })?;
    }
    Ok(())
}

impl Scenario {
    /// Refuses an objective that is incompatible with the other keys.
    pub(crate) fn check_objective(&self) -> Result<()> {
        check_objective(&self.file, &self.model, &self.name)
    }

    /// Refuses keys that the method does not support: those of the direct method alone, and passive joints in the
    /// published flow.
    pub(crate) fn check_for(&self, method: Method) -> Result<()> {
        let file = &self.file;
        let of_jerk = |weights: &ObjectiveWeights| !weights.jerk.is_zero();
        let jerk = matches!(&file.objective, Objective::Weights(weights) if of_jerk(weights));
        let keys = [
            ("objective with a weight of time", file.objective.weighs_time()),
            ("objective.jerk", jerk),
            ("free_final_velocity", file.free_final_velocity),
            ("a_start", file.a_start.is_some()),
            ("a_goal", file.a_goal.is_some()),
            ("q_start outside of a limit of position", self.notes_on_start().next().is_some()),
            ("goal", !file.goal.is_empty()),
            ("keep", !file.keep.is_empty()),
            ("waypoints", !file.waypoints.is_empty()),
            ("stand", file.stand.is_some() && method != Method::Flow),
            ("free_horizon", file.free_horizon.is_some()),
            ("rows in (t, q, v, a, u)", !self.own.stage.is_empty()),
        ];
        let limits = file.enforced_limits.numbers().into_iter();
        let limits = limits.filter(|(quantity, _, given)| *quantity != Quantity::Velocity && given.is_some());
        let mut unknown = keys.iter().filter(|(_, given)| *given).map(|(key, _)| (*key).to_owned());
        let unknown = unknown.next().or(limits.map(|(_, key, _)| format!("enforced_limits.{key}")).next());
        if let (Some(key), true) = (unknown, method != Method::Direct) {
            let condition = format!("supported by the method 'direct' only, not by '{method}'");
            return Err(Error::input(&self.name, key, condition));
        }
        if method == Method::Flow && self.own.running_cost.is_some() {
            let condition = "not supported by the published flow, but by all other methods";
            return Err(Error::input(&self.name, "running cost of one's own", condition));
        }
        if method == Method::Flow && !file.passive.is_empty() {
            let condition = "supported by the methods 'duals' and 'two_phases', not by the published flow";
            return Err(Error::input(&self.name, "passive", condition));
        }
        Ok(())
    }
}
