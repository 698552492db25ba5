//! The parameters of the published flow.

use crate::keys::schema::one_of;
use aghf::motion::Guess;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The parameters of the flow for a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FlowParameters {
    /// Degree of the polynomial.
    pub degree: usize,
    /// Penalty of (11).
    pub k: f64,
    /// The value of `s` at which the flow stops.
    pub s_max: f64,
    /// The initial curve.
    #[schemars(schema_with = "one_of::<Guess>")]
    pub guess: Guess,
    /// Weight of the constraints in (A2).
    pub k_cons: f64,
    /// Sharpness of the activation of the constraints in (A3).
    pub c_cons: f64,
}

impl Default for FlowParameters {
    /// The paper's best values for Kinova: the constraint weights of the scenario with obstacles, the rest from the one
    /// without.
    fn default() -> Self {
        Self { degree: 9, k: 1e9, s_max: 0.1, guess: Guess::default(), k_cons: 1e9, c_cons: 1.0 }
    }
}
