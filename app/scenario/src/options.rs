//! The options of a solve.

use super::Scenario;
use aghf::error::{Error, Result};
use aghf::flow::jacobian::JacobianKind;
use aghf::flow::rest::RestSettings;
use aghf::flow::weak::AnalyticLagrangian;
use aghf::flow::{FlowSettings, Penalty};
use aghf::motion::{Guess, Interrupt};
use aghf::ode::IntegratorKind;
use aghf::relax::{PlannedStarts, RelaxSettings};
use serde::{Deserialize, Serialize};
use std::time::Duration;

aghf::names::named_enum! {
/// A method for solving a scenario.
pub enum Method("method") {
    /// Direct minimisation of the control effort by Newton's method, to the limit of the flow.
    Relax = "relax",
    /// The Affine Geometric Heat Flow as published (Algorithm B3).
    Flow = "flow",
}
}

aghf::names::named_enum! {
/// A variant of the flow; all minimise the action of a Lagrangian.
pub enum FlowVariant("variant") {
    /// The published flow: collocated, the penalty `k`, constraints as penalties, integrated to `s_max`.
    Published = "published",
    /// Flow to rest by an implicit scheme with growing steps, with the slip and the violations that penalties leave.
    Rest = "rest",
    /// Flow to rest with duals, which replace large penalties (the idea of EL-AGHF).
    Duals = "duals",
    /// Flow with duals in two phases: first to a motion within the constraints, then to least cost (the idea of BLAZE).
    TwoPhases = "two-phases",
}
}

/// The method, and values that override the parameters of a scenario or the defaults of the method.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SolveOptions {
    /// The method.
    pub method: Method,
    /// For the flow: the variant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variant: Option<FlowVariant>,
    /// Degree of the polynomial, or of each segment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degree: Option<usize>,
    /// For the relaxation: the number of polynomial segments of the motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segments: Option<usize>,
    /// For the relaxation: the relative change of the effort between two degrees at which the degree stops growing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degree_tolerance: Option<f64>,
    /// For the flow: absolute and relative tolerance of the integrator. For the relaxation: the relative gradient norm
    /// at the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// For the relaxation: the number of starts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub num_starts: Option<usize>,
    /// For the relaxation: the number of threads for the starts; all cores by default. The result does not depend on
    /// it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threads: Option<usize>,
    /// For the flow: the method of computing the Jacobian.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jacobian: Option<JacobianKind>,
    /// For the flow: the integrator.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub integrator: Option<IntegratorKind>,
    /// For the flow: the penalty `k` of (11).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k: Option<f64>,
    /// For the flow: the value of `s` at which it stops.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub s_max: Option<f64>,
    /// For the flow: the initial curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guess: Option<Guess>,
    /// For the flow: the weight of the constraints in (A2).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k_cons: Option<f64>,
    /// For the flow: the sharpness of the activation in (A3).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub c_cons: Option<f64>,
    /// For the relaxation: the seed of its random starts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// For the relaxation: the starts that follow planned paths around obstacles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planned_starts: Option<PlannedStarts>,
    /// The limit on wall time: a flow then fails, and a relaxation, which tries starts until then, returns its best
    /// motion.
    #[serde(
        rename = "time_limit_s",
        with = "seconds",
        skip_serializing_if = "Option::is_none"
    )]
    pub time_limit: Option<Duration>,
    /// The handle by which another thread stops the solve in the same way.
    #[serde(skip)]
    pub interrupt: Interrupt,
}

impl SolveOptions {
    /// The settings of the flow for `scenario`: these options, completed by the parameters of the scenario.
    #[must_use]
    pub fn flow_settings(&self, scenario: &Scenario) -> FlowSettings {
        let parameters = scenario.file.flow;
        FlowSettings {
            p: self.degree.unwrap_or(parameters.p),
            k: self.k.unwrap_or(parameters.k),
            s_max: self.s_max.unwrap_or(parameters.s_max),
            tolerance: self.tolerance.unwrap_or(FlowSettings::TOLERANCE),
            guess: self.guess.unwrap_or(parameters.guess),
            jacobian: self.jacobian.unwrap_or_default(),
            integrator: self.integrator.unwrap_or_default(),
            time_limit: self.time_limit,
            interrupt: self.interrupt.clone(),
        }
    }

    /// The settings of a flow to rest for `scenario`, completed in the same way.
    #[must_use]
    pub fn rest_settings(&self, scenario: &Scenario) -> RestSettings {
        let default = RestSettings::default();
        let passive = !scenario.file.passive.is_empty();
        let (degree, segments) = if passive {
            PASSIVE_BASIS
        } else {
            (default.degree, default.segments)
        };
        let tolerance = if scenario.is_free() {
            default.tolerance
        } else {
            RelaxSettings::constrained().tolerance
        };
        let variant = self.variant.unwrap_or_default();
        RestSettings {
            degree: self.degree.unwrap_or(degree),
            segments: self.segments.unwrap_or(segments),
            duals: variant != FlowVariant::Rest,
            two_phases: variant == FlowVariant::TwoPhases,
            tolerance: self.tolerance.unwrap_or(tolerance),
            guesses: self.num_starts.unwrap_or(if passive {
                PASSIVE_GUESSES
            } else {
                default.guesses
            }),
            seed: self.seed.unwrap_or(default.seed),
            time_limit: self.time_limit,
            interrupt: self.interrupt.clone(),
            ..default
        }
    }

    /// The Lagrangian of a flow of `scenario` to rest without its constraints, that is its running cost. The torque
    /// cost of a passive joint tends to zero during the flow, and keeps the torque small between the points at which it
    /// is an equality.
    ///
    /// # Errors
    /// A weight of the running cost is out of range.
    pub fn lagrangian<'m>(&self, scenario: &'m Scenario) -> Result<AnalyticLagrangian<'m>> {
        let k = self.k.unwrap_or(scenario.file.flow.k);
        let mut lagrangian = AnalyticLagrangian::new(&scenario.model, k);
        if let Some(weights) = &scenario.file.running_cost {
            let weights = weights.weighted(scenario.model.dof())?;
            let all = [weights.torque(), weights.velocity(), weights.acceleration()];
            for (to, from) in lagrangian.weights.iter_mut().zip(all) {
                to.copy_from_slice(from);
            }
        }
        Ok(lagrangian)
    }

    /// The constraint penalty of the flow of `scenario`, completed in the same way.
    #[must_use]
    pub fn penalty(&self, scenario: &Scenario) -> Penalty {
        Penalty {
            k_cons: self.k_cons.unwrap_or(scenario.file.flow.k_cons),
            c_cons: self.c_cons.unwrap_or(scenario.file.flow.c_cons),
        }
    }

    /// The settings of the relaxation for `scenario`: these options, completed by its defaults.
    #[must_use]
    pub fn relax_settings(&self, scenario: &Scenario) -> RelaxSettings {
        let mut default = if scenario.is_free() {
            RelaxSettings::default()
        } else {
            RelaxSettings::constrained()
        };
        if !scenario.file.passive.is_empty() {
            (default.degree, default.segments) = PASSIVE_BASIS;
            default.num_starts = PASSIVE_GUESSES;
            default.start_amplitude = RelaxSettings::default().start_amplitude;
        } else if !scenario.limits_are_enforced() {
            // Limits leave little to choose between; without them there are many minima.
            default.num_starts = starts_of(scenario.model.dof());
        }
        RelaxSettings {
            degree: self.degree.unwrap_or(default.degree),
            segments: self.segments.unwrap_or(default.segments),
            degree_tolerance: self.degree_tolerance,
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            num_starts: self.num_starts.unwrap_or(default.num_starts),
            seed: self.seed.unwrap_or(default.seed),
            planned_starts: self.planned_starts.unwrap_or_default(),
            time_limit: self.time_limit,
            interrupt: self.interrupt.clone(),
            threads: self.threads.unwrap_or_else(all_cores),
            free_final_velocity: scenario.file.free_final_velocity,
            free_horizon: scenario.file.free_horizon.map(Into::into),
            ..default
        }
    }

    /// The longest time limit, one year, s.
    pub const LONGEST_TIME_LIMIT: Duration = Duration::from_secs(31_536_000);

    /// The same options with all defaults filled in: a solve of `scenario` that is repeated with them does not depend
    /// on later defaults.
    #[must_use]
    pub fn in_full(&self, scenario: &Scenario) -> Self {
        let common = Self {
            method: self.method,
            degree_tolerance: self.degree_tolerance,
            threads: self.threads,
            time_limit: self.time_limit,
            ..Self::default()
        };
        match self.method {
            Method::Relax => {
                let settings = self.relax_settings(scenario);
                Self {
                    degree: Some(settings.degree),
                    segments: Some(settings.segments),
                    tolerance: Some(settings.tolerance),
                    num_starts: Some(settings.num_starts),
                    seed: Some(settings.seed),
                    planned_starts: Some(settings.planned_starts),
                    ..common
                }
            }
            Method::Flow if self.flows_to_rest() => {
                let settings = self.rest_settings(scenario);
                Self {
                    variant: self.variant,
                    degree: Some(settings.degree),
                    segments: Some(settings.segments),
                    tolerance: Some(settings.tolerance),
                    num_starts: Some(settings.guesses),
                    seed: Some(settings.seed),
                    k: Some(self.k.unwrap_or(scenario.file.flow.k)),
                    ..common
                }
            }
            Method::Flow => {
                let settings = self.flow_settings(scenario);
                let penalty = self.penalty(scenario);
                Self {
                    variant: self.variant,
                    degree: Some(settings.p),
                    tolerance: Some(settings.tolerance),
                    jacobian: Some(settings.jacobian),
                    integrator: Some(settings.integrator),
                    k: Some(settings.k),
                    s_max: Some(settings.s_max),
                    guess: Some(settings.guess),
                    k_cons: Some(penalty.k_cons),
                    c_cons: Some(penalty.c_cons),
                    ..common
                }
            }
        }
    }

    /// Returns true if the variant of the flow goes to rest.
    #[must_use]
    pub fn flows_to_rest(&self) -> bool {
        self.variant.unwrap_or_default() != FlowVariant::Published
    }

    /// Refuses options that the method does not have, and an invalid time limit.
    pub(super) fn check(&self) -> Result<()> {
        let longest = Self::LONGEST_TIME_LIMIT;
        if let Some(limit) = self.time_limit.filter(|limit| *limit > longest) {
            let condition = format!("it is {limit:?}, at most {longest:?} is needed");
            return Err(Error::input("options", "time_limit", condition));
        }
        let (method, foreign) = match self.method {
            Method::Flow if self.flows_to_rest() => {
                let foreign = [
                    ("degree_tolerance", self.degree_tolerance.is_some()),
                    ("planned_starts", self.planned_starts.is_some()),
                    ("threads", self.threads.is_some()),
                    ("jacobian", self.jacobian.is_some()),
                    ("integrator", self.integrator.is_some()),
                    ("s_max", self.s_max.is_some()),
                    ("guess", self.guess.is_some()),
                    ("k_cons", self.k_cons.is_some()),
                    ("c_cons", self.c_cons.is_some()),
                ];
                ("flow to rest", foreign.to_vec())
            }
            Method::Flow => {
                let foreign = [
                    ("segments", self.segments.is_some()),
                    ("degree_tolerance", self.degree_tolerance.is_some()),
                    ("num_starts", self.num_starts.is_some()),
                    ("seed", self.seed.is_some()),
                    ("planned_starts", self.planned_starts.is_some()),
                    ("threads", self.threads.is_some()),
                ];
                ("flow", foreign.to_vec())
            }
            Method::Relax => {
                let foreign = [
                    ("variant", self.variant.is_some()),
                    ("jacobian", self.jacobian.is_some()),
                    ("integrator", self.integrator.is_some()),
                    ("k", self.k.is_some()),
                    ("s_max", self.s_max.is_some()),
                    ("guess", self.guess.is_some()),
                    ("k_cons", self.k_cons.is_some()),
                    ("c_cons", self.c_cons.is_some()),
                ];
                ("relax", foreign.to_vec())
            }
        };
        match foreign.iter().find(|(_, given)| *given) {
            Some((what, _)) => {
                let condition = format!("the method '{method}' has no such parameter");
                Err(Error::input("options", *what, condition))
            }
            None => Ok(()),
        }
    }
}

/// The default degree and number of segments of motions with passive joints.
const PASSIVE_BASIS: (usize, usize) = (8, 8);
/// The default number of guesses for motions with passive joints, which have many local minima.
const PASSIVE_GUESSES: usize = 40;

/// A duration as a number of seconds.
mod seconds {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
    use std::time::Duration;

    pub fn serialize<S: Serializer>(value: &Option<Duration>, to: S) -> Result<S::Ok, S::Error> {
        value.map(|duration| duration.as_secs_f64()).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Duration>, D::Error> {
        let seconds = Option::<f64>::deserialize(from)?;
        let duration = |s| Duration::try_from_secs_f64(s).map_err(D::Error::custom);
        seconds.map(duration).transpose()
    }
}

/// The default number of starts for a robot with `dof` joints: at least 4, and otherwise as many as take about the time
/// of 16 for an arm of 7.
fn starts_of(dof: usize) -> usize {
    (112 / dof.max(1)).clamp(4, RelaxSettings::default().num_starts)
}

/// The number of cores on which threads can run.
fn all_cores() -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    cores.min(RelaxSettings::MOST_THREADS)
}
