//! The options of the published flow.

use super::time_limit;
use crate::Scenario;
use crate::keys::schema::one_of;
use aghf::error::{Error, Result, check_positive};
use aghf::flow::jacobian::JacobianKind;
use aghf::flow::{FlowSettings, Penalty};
use aghf::motion::Guess;
use aghf::ode::IntegratorKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The options of the published flow.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FlowOptions {
    /// Degree of the polynomial; by default that of the scenario.
    pub degree: Option<usize>,
    /// Penalty of (11) on velocities that differ from those of the curve; by default that of the scenario.
    pub k: Option<f64>,
    /// Value of `s` at which the flow stops; by default that of the scenario.
    pub s_max: Option<f64>,
    /// Absolute and relative tolerance of the integrator; by default 1e-4.
    pub tolerance: Option<f64>,
    /// Initial curve, a line in the whole state or in the configuration with the corresponding velocity; by default
    /// that of the scenario.
    #[schemars(schema_with = "one_of::<Guess>")]
    pub guess: Option<Guess>,
    /// Method of computing the Jacobian; by default `control_form`.
    #[schemars(schema_with = "one_of::<JacobianKind>")]
    pub jacobian: Option<JacobianKind>,
    /// Integrator; by default `bdf`.
    #[schemars(schema_with = "one_of::<IntegratorKind>")]
    pub integrator: Option<IntegratorKind>,
    /// Weight of the constraints in (A2); by default that of the scenario.
    pub k_cons: Option<f64>,
    /// Sharpness of the activation of the constraints in (A3); by default that of the scenario.
    pub c_cons: Option<f64>,
    /// Time limit, s, after which the flow fails.
    pub time_limit_s: Option<f64>,
}

impl FlowOptions {
    /// The settings of the flow for `scenario`: these options, completed by the parameters of the scenario.
    ///
    /// # Errors
    /// The time limit is out of range.
    pub fn settings(&self, scenario: &Scenario) -> Result<FlowSettings> {
        let parameters = scenario.file.flow;
        Ok(FlowSettings {
            tolerance: self.tolerance.unwrap_or(FlowSettings::TOLERANCE),
            guess: self.guess.unwrap_or(parameters.guess),
            jacobian: self.jacobian.unwrap_or_default(),
            integrator: self.integrator.unwrap_or_default(),
            time_limit: time_limit(self.time_limit_s)?,
            ..FlowSettings::new(
                self.degree.unwrap_or(parameters.degree),
                self.k.unwrap_or(parameters.k),
                self.s_max.unwrap_or(parameters.s_max),
            )
        })
    }

    /// The constraint penalty of the flow of `scenario`, completed in the same way.
    #[must_use]
    pub fn penalty(&self, scenario: &Scenario) -> Penalty {
        Penalty {
            k_cons: self.k_cons.unwrap_or(scenario.file.flow.k_cons),
            c_cons: self.c_cons.unwrap_or(scenario.file.flow.c_cons),
        }
    }

    /// Refuses values out of range, and penalties where there is no constraint.
    pub(super) fn check(&self, scenario: &Scenario) -> Result<()> {
        self.settings(scenario)?.check(scenario.model.dof())?;
        for (key, given) in [("k_cons", self.k_cons), ("c_cons", self.c_cons)] {
            let Some(value) = given else { continue };
            check_positive("options", key, value)?;
            if scenario.is_free() {
                let condition = format!("'{}' has no constraints", scenario.name);
                return Err(Error::input("options", key, condition));
            }
        }
        Ok(())
    }

    /// The same options with all defaults filled in.
    pub(super) fn in_full(&self, scenario: &Scenario) -> Result<Self> {
        let settings = self.settings(scenario)?;
        let penalty = (!scenario.is_free()).then(|| self.penalty(scenario));
        Ok(Self {
            degree: Some(settings.degree),
            k: Some(settings.k),
            s_max: Some(settings.s_max),
            tolerance: Some(settings.tolerance),
            guess: Some(settings.guess),
            jacobian: Some(settings.jacobian),
            integrator: Some(settings.integrator),
            k_cons: penalty.map(|penalty| penalty.k_cons),
            c_cons: penalty.map(|penalty| penalty.c_cons),
            ..self.clone()
        })
    }
}
