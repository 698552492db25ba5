//! The options of a solve, by method: each is declared once, as a field of a struct, from which its key in JSON, its
//! flag, its entry in the schema and its list in a sweep follow.

mod direct;
mod flow;
mod rest;

pub use direct::DirectOptions;
pub use flow::FlowOptions;
pub use rest::RestOptions;

use super::Scenario;
use crate::keys::json::read_keys;
use aghf::direct::DirectSettings;
use aghf::error::{Error, Result, plain};
use aghf::names::Named;
use serde::de::Error as _;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value, json};
use std::time::Duration;

aghf::names::named_enum! {
/// A method for solving a scenario. All flows minimise the action of a Lagrangian.
pub enum Method("method") {
    /// Direct minimisation of the objective within all constraints, by an interior-point method.
    Direct = "direct",
    /// The Affine Geometric Heat Flow as published (Algorithm B3): collocated, constraints as penalties.
    Flow = "flow",
    /// Flow to rest by an implicit scheme with growing steps, with the slip and the violations that penalties leave.
    Rest = "rest",
    /// Flow to rest with duals, which replace large penalties (the idea of EL-AGHF).
    Duals = "duals",
    /// Flow with duals in two phases: first to a motion within the constraints, then to least cost (the idea of BLAZE).
    TwoPhases = "two_phases",
}
}

impl Method {
    /// The key of the method beside its options.
    pub const KEY: &'static str = "method";
}

/// The method of a solve and its options, which override the parameters of the scenario and the defaults of the
/// method. In JSON an object with the options and the key `method`, by default `direct`.
#[derive(Clone, Debug, PartialEq)]
pub enum SolveOptions {
    /// Options of [`Method::Direct`].
    Direct(DirectOptions),
    /// Options of [`Method::Flow`].
    Flow(FlowOptions),
    /// Options of [`Method::Rest`].
    Rest(RestOptions),
    /// Options of [`Method::Duals`].
    Duals(RestOptions),
    /// Options of [`Method::TwoPhases`].
    TwoPhases(RestOptions),
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self::Direct(DirectOptions::default())
    }
}

impl From<DirectOptions> for SolveOptions {
    fn from(options: DirectOptions) -> Self {
        Self::Direct(options)
    }
}

impl From<FlowOptions> for SolveOptions {
    fn from(options: FlowOptions) -> Self {
        Self::Flow(options)
    }
}

impl SolveOptions {
    /// The longest time limit, one year, s.
    pub const MAX_TIME_LIMIT_S: f64 = 31_536_000.0;

    /// The options of a method from their JSON keys.
    ///
    /// # Errors
    /// A key is unknown to the method, or its value has another type.
    pub fn from_keys(method: Method, keys: Map<String, Value>) -> Result<Self> {
        Ok(match method {
            Method::Direct => Self::Direct(read_keys(keys, "options")?),
            Method::Flow => Self::Flow(read_keys(keys, "options")?),
            Method::Rest => Self::Rest(read_keys(keys, "options")?),
            Method::Duals => Self::Duals(read_keys(keys, "options")?),
            Method::TwoPhases => Self::TwoPhases(read_keys(keys, "options")?),
        })
    }

    /// The JSON keys of the options that are given, without the method.
    ///
    /// # Errors
    /// None for options that were read or checked.
    pub fn keys(&self) -> Result<Map<String, Value>> {
        let value = match self {
            Self::Direct(options) => serde_json::to_value(options),
            Self::Flow(options) => serde_json::to_value(options),
            Self::Rest(options) | Self::Duals(options) | Self::TwoPhases(options) => serde_json::to_value(options),
        };
        match value {
            Ok(Value::Object(keys)) => Ok(keys.into_iter().filter(|(_, v)| !v.is_null()).collect()),
            Ok(other) => Err(Error::input("options", "options", format!("{other}"))),
            Err(error) => Err(Error::input("options", "options", error.to_string())),
        }
    }

    /// The method.
    #[must_use]
    pub fn method(&self) -> Method {
        match self {
            Self::Direct(_) => Method::Direct,
            Self::Flow(_) => Method::Flow,
            Self::Rest(_) => Method::Rest,
            Self::Duals(_) => Method::Duals,
            Self::TwoPhases(_) => Method::TwoPhases,
        }
    }

    /// The same options with all defaults filled in: a solve of `scenario` that is repeated with them does not depend
    /// on later defaults.
    ///
    /// # Errors
    /// Those of [`check`](Self::check).
    pub fn in_full(&self, scenario: &Scenario) -> Result<Self> {
        Ok(match self {
            Self::Direct(options) => Self::Direct(options.in_full(scenario)?),
            Self::Flow(options) => Self::Flow(options.in_full(scenario)?),
            Self::Rest(options) => Self::Rest(options.in_full(scenario, Method::Rest)?),
            Self::Duals(options) => Self::Duals(options.in_full(scenario, Method::Duals)?),
            Self::TwoPhases(options) => Self::TwoPhases(options.in_full(scenario, Method::TwoPhases)?),
        })
    }

    /// Refuses values that are out of range, or have no meaning in `scenario`.
    ///
    /// # Errors
    /// Names the option and its fault.
    pub fn check(&self, scenario: &Scenario) -> Result<()> {
        let problem = scenario.problem()?;
        match self {
            Self::Direct(options) => options.settings(scenario)?.check(&problem),
            Self::Flow(options) => options.check(scenario),
            Self::Rest(options) | Self::Duals(options) | Self::TwoPhases(options) => {
                options.penalty(scenario)?;
                options.settings(scenario, self.method())?.check(&problem)
            }
        }
    }

    /// The JSON Schema of the options of one method, without the key of the method.
    #[must_use]
    pub fn schema_of(method: Method) -> Value {
        let schema = match method {
            Method::Direct => schemars::schema_for!(DirectOptions),
            Method::Flow => schemars::schema_for!(FlowOptions),
            Method::Rest | Method::Duals | Method::TwoPhases => schemars::schema_for!(RestOptions),
        };
        schema.to_value()
    }

    /// The JSON Schema of all options: one alternative per method.
    #[must_use]
    pub fn schema() -> Value {
        let alternatives = Method::ALL.iter().map(|(method, name, help)| {
            let mut schema = Self::schema_of(*method);
            schema["description"] = json!(help.trim());
            schema["properties"][Method::KEY] = json!({ "const": name });
            if *method != Method::default() {
                schema["required"] = json!([Method::KEY]);
            }
            schema
        });
        json!({ "oneOf": alternatives.collect::<Vec<_>>() })
    }
}

impl Serialize for SolveOptions {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        let mut all = Map::new();
        all.insert(Method::KEY.to_owned(), json!(self.method()));
        all.extend(self.keys().map_err(S::Error::custom)?);
        all.serialize(to)
    }
}

impl<'de> Deserialize<'de> for SolveOptions {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        let mut keys = Map::<String, Value>::deserialize(from)?;
        let method = match keys.remove(Method::KEY) {
            None => Method::default(),
            Some(Value::String(name)) => name.parse().map_err(D::Error::custom)?,
            Some(other) => {
                return Err(D::Error::custom(format!("method: it is {other}, no name")));
            }
        };
        Self::from_keys(method, keys).map_err(D::Error::custom)
    }
}

/// The time limit of this many seconds, if one is given.
fn time_limit(seconds: Option<f64>) -> Result<Option<Duration>> {
    let longest = SolveOptions::MAX_TIME_LIMIT_S;
    match seconds {
        Some(s) if !(0.0..=longest).contains(&s) => {
            let condition = format!("it is {} and must be at least 0 and at most {longest} s", plain(s));
            Err(Error::input("options", "time_limit_s", condition))
        }
        seconds => Ok(seconds.map(Duration::from_secs_f64)),
    }
}

/// The default degree and number of segments of motions with passive joints.
const PASSIVE_BASIS: (usize, usize) = (8, 8);
/// The default number of starts for motions with passive joints, which have many local minima.
const PASSIVE_STARTS: usize = 40;

/// The largest number of iterations of a start with passive joints: with many starts, another one is worth more than a
/// long one.
const PASSIVE_ITERATIONS: usize = 150;

/// The default number of starts for a robot with `dof` joints: at least 4, and otherwise as many as take about the time
/// of 32 for an arm of 7.
fn starts_of(dof: usize) -> usize {
    (224 / dof.max(1)).clamp(4, DirectSettings::default().starts)
}
