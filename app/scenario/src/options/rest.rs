//! The options of the flows to rest.

use super::{Method, PASSIVE_BASIS, PASSIVE_STARTS, time_limit};
use crate::Scenario;
use aghf::direct::DirectSettings;
use aghf::error::{Result, check_positive};
use aghf::flow::rest::RestSettings;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The options of the flows to rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RestOptions {
    /// Degree of the polynomial, or of each segment; by default 16, with passive joints 8.
    pub degree: Option<usize>,
    /// Number of polynomials on equal parts of the horizon; by default 1, with passive joints 8.
    pub segments: Option<usize>,
    /// Relative norm of the gradient at the end; by default 1e-6, with a flow to rest without constraints 1e-8.
    pub tolerance: Option<f64>,
    /// Number of starts; by default 1, with passive joints 40. More follow until one satisfies the constraints.
    pub starts: Option<usize>,
    /// Seed of the starts; by default 0.
    pub seed: Option<u64>,
    /// Penalty of (11) on velocities that differ from those of the curve; by default that of the scenario.
    pub k: Option<f64>,
    /// Time limit, s, after which the flow stops with the best motion so far.
    pub time_limit_s: Option<f64>,
}

impl RestOptions {
    /// The settings of this method, one of the flows to rest, for `scenario`: these options, completed by its defaults.
    ///
    /// # Errors
    /// The time limit is out of range.
    pub fn settings(&self, scenario: &Scenario, method: Method) -> Result<RestSettings> {
        let default = RestSettings::default();
        let (basis, starts) = if scenario.file.passive.is_empty() {
            ((default.degree, default.segments), default.starts)
        } else {
            (PASSIVE_BASIS, PASSIVE_STARTS)
        };
        let tolerance = if scenario.is_free() { default.tolerance } else { DirectSettings::constrained().tolerance };
        Ok(RestSettings {
            degree: self.degree.unwrap_or(basis.0),
            segments: self.segments.unwrap_or(basis.1),
            duals: method != Method::Rest,
            two_phases: method == Method::TwoPhases,
            tolerance: self.tolerance.unwrap_or(tolerance),
            starts: self.starts.unwrap_or(starts),
            seed: self.seed.unwrap_or(default.seed),
            time_limit: time_limit(self.time_limit_s)?,
            ..default
        })
    }

    /// The penalty of the slip in a flow of `scenario` to rest.
    ///
    /// # Errors
    /// The penalty is out of range.
    pub fn penalty(&self, scenario: &Scenario) -> Result<f64> {
        let k = self.k.unwrap_or(scenario.file.flow.k);
        check_positive("options", "k", k)?;
        Ok(k)
    }

    /// The same options with all defaults filled in.
    pub(super) fn in_full(&self, scenario: &Scenario, method: Method) -> Result<Self> {
        let settings = self.settings(scenario, method)?;
        Ok(Self {
            degree: Some(settings.degree),
            segments: Some(settings.segments),
            tolerance: Some(settings.tolerance),
            starts: Some(settings.starts),
            seed: Some(settings.seed),
            k: Some(self.k.unwrap_or(scenario.file.flow.k)),
            ..self.clone()
        })
    }
}
