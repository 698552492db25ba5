//! The grid of the flow: the paper's parameters.

use super::{Refusal, check_list, check_optional, entry, length, not_positive, optional};
use aghf::curve::Chebyshev;
use aghf::motion::Guess;
use aghf_scenario::{Method, Scenario, SolveOptions};
use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize};

/// Lists of parameters of the flow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowGrid {
    /// Degrees of the polynomial.
    pub p: Vec<usize>,
    /// Penalties of (11).
    pub k: Vec<f64>,
    /// The values of `s` at which the flow stops.
    pub s_max: Vec<f64>,
    /// The initial curves; by default the line of the paper's released code.
    #[serde(default = "line")]
    pub guess: Vec<Guess>,
    /// Weights (A2) of the constraints; by default that of the scenario.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k_cons: Option<Vec<f64>>,
    /// Sharpnesses (A3) of the constraints; by default that of the scenario.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c_cons: Option<Vec<f64>>,
}

fn line() -> Vec<Guess> {
    vec![Guess::default()]
}

/// One set of parameters of the flow. The columns of results have the names of its fields.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct FlowPoint {
    /// Degree of the polynomial.
    pub p: usize,
    /// Penalty of (11).
    pub k: f64,
    /// The value of `s` at which the flow stops.
    pub s_max: f64,
    /// The initial curve.
    pub guess: Guess,
    /// Weight (A2) of the constraints; `None` for that of the scenario.
    pub k_cons: Option<f64>,
    /// Sharpness (A3) of the constraints; `None` for that of the scenario.
    pub c_cons: Option<f64>,
}

impl FlowGrid {
    /// The names of its lists.
    pub(super) const KEYS: [&str; 6] = ["p", "k", "s_max", "guess", "k_cons", "c_cons"];

    pub(super) fn check(&self) -> Result<(), Refusal> {
        check_list("k", &self.k, not_positive)?;
        check_list("s_max", &self.s_max, not_positive)?;
        check_optional("k_cons", &self.k_cons, not_positive)?;
        check_optional("c_cons", &self.c_cons, not_positive)?;
        check_list("p", &self.p, |p| Chebyshev::check_degree(*p).err())?;
        check_list("guess", &self.guess, |_| None)
    }

    pub(super) fn check_for(&self, scenario: &Scenario) -> Result<(), String> {
        let constrained = self.k_cons.is_some() || self.c_cons.is_some();
        if constrained && scenario.is_free() {
            let name = &scenario.name;
            return Err(format!("k_cons and c_cons: '{name}' has no constraints"));
        }
        Ok(())
    }

    pub(super) fn lengths(&self) -> Vec<usize> {
        vec![
            length(&self.c_cons),
            length(&self.k_cons),
            self.guess.len(),
            self.s_max.len(),
            self.k.len(),
            self.p.len(),
        ]
    }

    pub(super) fn point(&self, mut index: usize) -> FlowPoint {
        // From the list that runs fastest.
        let index = &mut index;
        let (c_cons, k_cons) = (optional(&self.c_cons, index), optional(&self.k_cons, index));
        let (guess, s_max) = (entry(&self.guess, index), entry(&self.s_max, index));
        let (k, p) = (entry(&self.k, index), entry(&self.p, index));
        FlowPoint {
            p,
            k,
            s_max,
            guess,
            k_cons,
            c_cons,
        }
    }
}

impl FlowPoint {
    pub(super) fn options(&self) -> SolveOptions {
        SolveOptions {
            method: Method::Flow,
            degree: Some(self.p),
            k: Some(self.k),
            s_max: Some(self.s_max),
            guess: Some(self.guess),
            k_cons: self.k_cons,
            c_cons: self.c_cons,
            ..SolveOptions::default()
        }
    }

    pub(super) fn columns<S: SerializeStruct>(&self, row: &mut S) -> Result<(), S::Error> {
        row.serialize_field("p", &self.p)?;
        row.serialize_field("k", &self.k)?;
        row.serialize_field("s_max", &self.s_max)?;
        row.serialize_field("guess", &self.guess)?;
        row.serialize_field("k_cons", &self.k_cons)?;
        row.serialize_field("c_cons", &self.c_cons)
    }

    pub(super) fn cells(&self) -> Vec<(&'static str, String)> {
        let exponent = |x: f64| format!("{x:e}");
        let given = |x: Option<f64>| x.map_or("-".to_owned(), exponent);
        vec![
            ("p", self.p.to_string()),
            ("k", exponent(self.k)),
            ("s_max", exponent(self.s_max)),
            ("guess", self.guess.to_string()),
            ("k_cons", given(self.k_cons)),
            ("c_cons", given(self.c_cons)),
        ]
    }
}
