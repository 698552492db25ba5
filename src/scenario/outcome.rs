//! Solving a scenario and testing whether that was a success.

use super::Scenario;
use super::summary::{Details, FlowDetails, RelaxDetails, Summary};
use crate::aghf::jacobian::JacobianKind;
use crate::error::{Error, Result};
use crate::pseudospectral::Curve;
use crate::solve::{
    Feedback, FlowRecord, FlowSettings, FlowSolution, Guess, Iteration, RelaxSettings,
    RelaxSolution, flow, measure, relax, simulate,
};
use serde::Serialize;
use std::time::Instant;

/// How a scenario is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Straight to least control effort, where the flow would come to rest, by Newton's method.
    #[default]
    Relax,
    /// The Affine Geometric Heat Flow as published (Algorithm B3).
    Flow,
}

/// What overrides the parameters of a scenario or the defaults of a method.
#[derive(Clone, Copy, Debug, Default)]
pub struct SolveOptions {
    /// How to solve it.
    pub method: Method,
    /// Degree of the polynomial.
    pub p: Option<usize>,
    /// Of the flow: absolute and relative tolerance of the integrator. Of the relaxation: the relative gradient norm at the end.
    pub tolerance: Option<f64>,
    /// Of the relaxation: how many starts there are.
    pub starts: Option<usize>,
    /// Of the flow: how the Jacobian is computed.
    pub jacobian: Option<JacobianKind>,
    /// Of the flow: penalty of (11).
    pub k: Option<f64>,
    /// Of the flow: how far it runs.
    pub s_max: Option<f64>,
    /// Of the flow: the curve to start from.
    pub guess: Option<Guess>,
}

impl SolveOptions {
    /// The settings of the flow for `scenario`: these options, and the scenario's parameters where there are none.
    #[must_use]
    pub fn flow_settings(&self, scenario: &Scenario) -> FlowSettings {
        let parameters = scenario.file.flow;
        FlowSettings {
            p: self.p.unwrap_or(parameters.p),
            k: self.k.unwrap_or(parameters.k),
            s_max: self.s_max.unwrap_or(parameters.s_max),
            tolerance: self.tolerance.unwrap_or(FlowSettings::TOLERANCE),
            guess: self.guess.unwrap_or(parameters.guess),
            jacobian: self.jacobian.unwrap_or_default(),
        }
    }

    /// The settings of the relaxation: these options, and its defaults where there are none.
    #[must_use]
    pub fn relax_settings(&self) -> RelaxSettings {
        let default = RelaxSettings::default();
        RelaxSettings {
            p: self.p.unwrap_or(default.p),
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            starts: self.starts.unwrap_or(default.starts),
            ..default
        }
    }

    /// Refuses options that the method does not have.
    fn check(&self) -> Result<()> {
        let (method, foreign) = match self.method {
            Method::Flow => ("flow", vec![("starts", self.starts.is_some())]),
            Method::Relax => {
                let foreign = [
                    ("jacobian", self.jacobian.is_some()),
                    ("k", self.k.is_some()),
                    ("s_max", self.s_max.is_some()),
                    ("guess", self.guess.is_some()),
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

/// How far a solve has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Record {
    /// Of the flow.
    Flow(FlowRecord),
    /// Of the relaxation.
    Relax(Iteration),
}

/// What came of a solve.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// In numbers.
    pub summary: Summary,
    /// The curve; the last good one if the solve failed.
    pub curve: Curve,
    /// How it went.
    pub history: Vec<Record>,
}

/// Solves `scenario` and tests the result by forward simulation. `observe` is called as the solve proceeds.
///
/// # Errors
/// Bad input. A solve that fails is an outcome whose summary says so.
pub fn solve(
    scenario: &Scenario,
    options: &SolveOptions,
    observe: &mut dyn FnMut(Record),
) -> Result<Outcome> {
    options.check()?;
    match options.method {
        Method::Flow => solve_by_flow(scenario, &options.flow_settings(scenario), observe),
        Method::Relax => solve_by_relaxation(scenario, &options.relax_settings(), observe),
    }
}

fn solve_by_flow(
    scenario: &Scenario,
    settings: &FlowSettings,
    observe: &mut dyn FnMut(Record),
) -> Result<Outcome> {
    let problem = scenario.problem()?;
    let started = Instant::now();
    let outcome = flow(&problem, settings, &mut |record| {
        observe(Record::Flow(record));
    })?;
    let solve_seconds = started.elapsed().as_secs_f64();
    let (solution, failure) = match outcome {
        Ok(solution) => (solution, None),
        Err(failure) => {
            let reason = failure.to_string();
            let kept = FlowSolution {
                curve: failure.last_good,
                history: failure.history,
                statistics: failure.statistics,
            };
            (kept, Some(reason))
        }
    };
    let FlowSolution {
        curve,
        history,
        statistics,
    } = solution;
    let effort = measure(&scenario.model, &curve, settings.k)?;
    let interior = settings.p - 1;
    let details = Details::Flow(FlowDetails {
        jacobian: settings.jacobian,
        k: settings.k,
        s_max: settings.s_max,
        tolerance: settings.tolerance,
        guess: settings.guess,
        action: effort.action,
        action_at_nodes: effort.action_at_nodes,
        action_at_nodes_of_guess: history.first().map_or(f64::NAN, |r| r.action_at_nodes),
        steps: statistics.steps,
        rejected_steps: statistics.rejected_steps,
        omega_evaluations: statistics.rhs_evaluations * interior,
        jacobian_evaluations: statistics.jacobian_evaluations * interior,
        factorisations: statistics.factorisations,
    });
    let history = history.into_iter().map(Record::Flow).collect();
    outcome_of(scenario, curve, history, details, solve_seconds, failure)
}

fn solve_by_relaxation(
    scenario: &Scenario,
    settings: &RelaxSettings,
    observe: &mut dyn FnMut(Record),
) -> Result<Outcome> {
    let problem = scenario.problem()?;
    let started = Instant::now();
    let solution = relax(&problem, settings, &mut |iteration| {
        observe(Record::Relax(*iteration));
    })?;
    let solve_seconds = started.elapsed().as_secs_f64();
    let failure = failure_of(&solution, settings);
    let RelaxSolution {
        curve, iterations, ..
    } = solution;
    let details = Details::Relax(RelaxDetails {
        tolerance: settings.tolerance,
        gradient_norm: solution.gradient_norm,
        smallest_curvature: solution.smallest_curvature,
        quadrature_points: solution.points,
        efforts_of_starts: solution.starts,
        iterations: iterations.len(),
        factorisations: iterations.iter().map(|i| i.factorisations).sum(),
    });
    let history = iterations.into_iter().map(Record::Relax).collect();
    outcome_of(scenario, curve, history, details, solve_seconds, failure)
}

/// Why a relaxation did not find a minimum, if it did not.
fn failure_of(solution: &RelaxSolution, settings: &RelaxSettings) -> Option<String> {
    let RelaxSolution {
        converged,
        gradient_norm,
        quadrature_error,
        smallest_curvature,
        ..
    } = solution;
    if !converged {
        let (tolerance, agreement) = (settings.tolerance, settings.agreement);
        return Some(format!(
            "where the search ended the gradient norm is {gradient_norm:.1e}, {tolerance:e} was asked for, \
             and the quadrature is off by {quadrature_error:.1e}, {agreement:e} was asked for"
        ));
    }
    (*smallest_curvature <= 0.0).then(|| {
        format!("where the gradient vanishes the smallest curvature is {smallest_curvature:.1e}: no minimum")
    })
}

/// What can be measured of a curve, whatever found it.
fn outcome_of(
    scenario: &Scenario,
    curve: Curve,
    history: Vec<Record>,
    details: Details,
    solve_seconds: f64,
    failure: Option<String>,
) -> Result<Outcome> {
    let model = &scenario.model;
    // Neither number depends on the penalty.
    let effort = measure(model, &curve, 1.0)?;
    let final_error = |feedback| -> Result<Option<f64>> {
        Ok(simulate(model, &curve, feedback)?
            .ok()
            .map(|simulation| simulation.error_inf))
    };
    let final_error_inf = final_error(scenario.file.feedback)?;
    let success_threshold = scenario.file.success_threshold;
    let summary = Summary {
        scenario: scenario.name.clone(),
        robot: scenario.file.robot.clone(),
        method: match details {
            Details::Flow(_) => Method::Flow,
            Details::Relax(_) => Method::Relax,
        },
        p: curve.chebyshev().degree(),
        success: failure.is_none() && final_error_inf.is_some_and(|e| e < success_threshold),
        success_threshold,
        final_error_inf,
        open_loop_error_inf: final_error(Feedback::NONE)?,
        feedback: scenario.file.feedback,
        control_effort: effort.control_effort,
        dynamics_defect: effort.dynamics_defect,
        solve_seconds,
        details,
        failure,
        outside_limits: scenario.outside_limits(),
    };
    Ok(Outcome {
        summary,
        curve,
        history,
    })
}
