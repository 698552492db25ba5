//! Solving a scenario and testing whether that was a success.

use super::{Feasibility, Scenario};
use crate::aghf::constraint::Penalty;
use crate::aghf::jacobian::JacobianKind;
use crate::aghf::{Penalised, TorquePenalty};
use crate::error::Result;
use crate::pseudospectral::Curve;
use crate::solve::{
    Feedback, FlowRecord, FlowSettings, FlowSolution, Guess, flow, flow_constrained, measure,
    sample, simulate,
};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// At how many intervals of time feasibility is looked at.
const INTERVALS: usize = 2000;
/// By how much a limit that is enforced may be exceeded, in its own unit: penalties give way a little.
const LIMIT_TOLERANCE: f64 = 1e-3;

/// How a scenario is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The Affine Geometric Heat Flow as published (Algorithm B3).
    #[default]
    Flow,
}

/// What overrides the parameters of a scenario.
#[derive(Clone, Copy, Debug, Default)]
pub struct SolveOptions {
    /// How to solve it.
    pub method: Method,
    /// How the Jacobian is computed.
    pub jacobian: JacobianKind,
    /// Degree of the polynomial.
    pub p: Option<usize>,
    /// Penalty of (11).
    pub k: Option<f64>,
    /// How far the flow runs.
    pub s_max: Option<f64>,
    /// Absolute and relative tolerance of the integrator.
    pub tolerance: Option<f64>,
    /// The curve to start from.
    pub guess: Option<Guess>,
    /// Weight of the constraints in (A2).
    pub k_cons: Option<f64>,
    /// Sharpness of their activation in (A3).
    pub c_cons: Option<f64>,
    /// The wall time after which the solve stops, as a failure.
    pub time_limit: Option<Duration>,
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
            jacobian: self.jacobian,
            time_limit: self.time_limit,
        }
    }

    /// The penalty of the constraints of `scenario`, likewise.
    #[must_use]
    pub fn penalty(&self, scenario: &Scenario) -> Penalty {
        Penalty {
            k_cons: self.k_cons.unwrap_or(scenario.file.flow.k_cons),
            c_cons: self.c_cons.unwrap_or(scenario.file.flow.c_cons),
        }
    }
}

/// What came of a solve, in numbers. `None` where a simulation could not be carried to its end.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The name of the scenario.
    pub scenario: String,
    /// The name of the robot.
    pub robot: String,
    /// How it was solved.
    pub method: Method,
    /// How the Jacobian was computed.
    pub jacobian: JacobianKind,
    /// Degree of the polynomial.
    pub p: usize,
    /// Penalty of (11).
    pub k: f64,
    /// How far the flow was to run.
    pub s_max: f64,
    /// Tolerance of the integrator.
    pub tolerance: f64,
    /// The curve it started from.
    pub guess: Guess,
    /// Weight of the constraints in (A2), where there are any.
    pub k_cons: Option<f64>,
    /// Sharpness of their activation in (A3).
    pub c_cons: Option<f64>,
    /// Whether the flow came to its end, the simulation with feedback ended within the threshold of the goal, the curve hits
    /// nothing and keeps the limits that are enforced.
    pub success: bool,
    /// The threshold.
    pub success_threshold: f64,
    /// The final error of the simulation with feedback: the largest of all positions and velocities.
    pub final_error_inf: Option<f64>,
    /// The same without feedback.
    pub open_loop_error_inf: Option<f64>,
    /// The gains of the feedback.
    pub feedback: Feedback,
    /// $\int |u|^2 dt$ on 2001 times.
    pub control_effort: f64,
    /// The action on 2001 times.
    pub action: f64,
    /// The action by quadrature over the nodes, which is what the flow sees.
    pub action_at_nodes: f64,
    /// The action at the nodes before the flow.
    pub action_at_nodes_of_guess: f64,
    /// $\max |\dot q - v|_\infty$ on 2001 times.
    pub dynamics_defect: f64,
    /// Wall time of the flow, s.
    pub solve_seconds: f64,
    /// Accepted steps of the integrator.
    pub steps: usize,
    /// Rejected steps.
    pub rejected_steps: usize,
    /// Evaluations of $\Omega$, each at one node.
    pub omega_evaluations: usize,
    /// Evaluations of the Jacobian of $\Omega$, each at one node.
    pub jacobian_evaluations: usize,
    /// LU factorisations of the Newton matrix.
    pub factorisations: usize,
    /// Why the flow did not come to its end, if it did not.
    pub failure: Option<String>,
    /// What the curve keeps clear of and which limits it breaks.
    #[serde(flatten)]
    pub feasibility: Feasibility,
    /// Boundary positions outside joint limits.
    pub outside_limits: Vec<String>,
}

/// What came of a solve.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// In numbers.
    pub summary: Summary,
    /// The curve; the last good one if the flow failed.
    pub curve: Curve,
    /// The action along the flow.
    pub history: Vec<FlowRecord>,
    /// Whether the time limit stopped the flow.
    pub timed_out: bool,
}

/// Solves `scenario` and tests the result by forward simulation. `observe` is called as the flow proceeds.
///
/// # Errors
/// Bad input. A solve that fails is an outcome whose summary says so.
pub fn solve(
    scenario: &Scenario,
    options: &SolveOptions,
    observe: &mut dyn FnMut(FlowRecord),
) -> Result<Outcome> {
    let settings = options.flow_settings(scenario);
    let problem = scenario.problem()?;
    let penalty = options.penalty(scenario);
    let constraints = Penalised {
        state: scenario.state_constraints()?,
        penalty,
        torque: TorquePenalty {
            limits: scenario.torque_limits(),
            penalty,
        },
    };
    let started = Instant::now();
    let outcome = if scenario.is_free() {
        flow(&problem, &settings, observe)?
    } else {
        flow_constrained(&problem, &settings, &constraints, observe)?
    };
    let solve_seconds = started.elapsed().as_secs_f64();
    let mut timed_out = false;
    let (solution, failure) = match outcome {
        Ok(solution) => (solution, None),
        Err(failure) => {
            let reason = failure.to_string();
            timed_out = failure.timed_out;
            let kept = FlowSolution {
                curve: failure.last_good,
                history: failure.history,
                statistics: failure.statistics,
            };
            (kept, Some(reason))
        }
    };
    let summary = summarise(
        scenario,
        options,
        &settings,
        &solution,
        solve_seconds,
        failure,
    )?;
    Ok(Outcome {
        summary,
        curve: solution.curve,
        history: solution.history,
        timed_out,
    })
}

/// A solve in numbers: how it was done, what it cost, and what can be measured of its curve.
fn summarise(
    scenario: &Scenario,
    options: &SolveOptions,
    settings: &FlowSettings,
    solution: &FlowSolution,
    solve_seconds: f64,
    failure: Option<String>,
) -> Result<Summary> {
    let model = &scenario.model;
    let FlowSolution {
        curve,
        history,
        statistics,
    } = solution;
    let effort = measure(model, curve, settings.k)?;
    let final_error = |feedback| -> Result<Option<f64>> {
        Ok(simulate(model, curve, feedback)?
            .ok()
            .map(|simulation| simulation.error_inf))
    };
    let final_error_inf = final_error(scenario.file.feedback)?;
    let success_threshold = scenario.file.success_threshold;
    let interior = settings.p - 1;
    let feasibility = Feasibility::of(scenario, &sample(model, curve, INTERVALS)?)?;
    let reached = final_error_inf.is_some_and(|e| e < success_threshold);
    let penalty = options.penalty(scenario);
    let constrained = !scenario.is_free();
    Ok(Summary {
        scenario: scenario.name.clone(),
        robot: scenario.file.robot.clone(),
        method: options.method,
        jacobian: settings.jacobian,
        p: settings.p,
        k: settings.k,
        s_max: settings.s_max,
        tolerance: settings.tolerance,
        guess: settings.guess,
        k_cons: constrained.then_some(penalty.k_cons),
        c_cons: constrained.then_some(penalty.c_cons),
        success: failure.is_none() && reached && feasibility.holds(scenario, LIMIT_TOLERANCE),
        success_threshold,
        final_error_inf,
        open_loop_error_inf: final_error(Feedback::NONE)?,
        feedback: scenario.file.feedback,
        control_effort: effort.control_effort,
        action: effort.action,
        action_at_nodes: effort.action_at_nodes,
        action_at_nodes_of_guess: history.first().map_or(f64::NAN, |r| r.action_at_nodes),
        dynamics_defect: effort.dynamics_defect,
        solve_seconds,
        steps: statistics.steps,
        rejected_steps: statistics.rejected_steps,
        omega_evaluations: statistics.rhs_evaluations * interior,
        jacobian_evaluations: statistics.jacobian_evaluations * interior,
        factorisations: statistics.factorisations,
        failure,
        feasibility,
        outside_limits: scenario.outside_limits(),
    })
}
