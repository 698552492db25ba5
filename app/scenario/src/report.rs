//! Solving a scenario and testing the result.

use super::by_flow::{solve_by_flow, solve_by_flow_to_rest};
use super::passive::effort_of_joints;
use super::summary::{Details, RelaxDetails, Summary};
use super::{CurveFile, Feasibility, Method, Provenance, Scenario, SolveOptions};
use aghf::curve::Curve;
use aghf::error::Result;
use aghf::flow::rest::RestRecord;
use aghf::flow::{EffortSummary, FlowRecord, effort_of};
use aghf::motion::{Feedback, Stopped, replay_error, simulate};
use aghf::relax::{Iteration, PlannedStarts, RelaxSettings, RelaxSolution, Relaxation};
use std::time::Instant;

/// The allowed violation of enforced quantities after the flow, in their own unit: penalties are not exact.
const LIMIT_TOLERANCE: f64 = 1e-3;

/// The number of intervals on which the effort of passive joints is integrated.
const INTERVALS: usize = 2000;

/// The progress of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Record {
    /// Progress of the published flow.
    Flow(FlowRecord),
    /// Progress of a flow to rest.
    Rest(RestRecord),
    /// Progress of the relaxation.
    Relax(Iteration),
}

/// The result of a solve.
#[derive(Clone, Debug)]
pub struct SolveReport {
    /// The result in numbers.
    pub summary: Summary,
    /// The curve; the last good one if the solve failed.
    pub curve: Curve,
    /// The progress of the method.
    pub history: Vec<Record>,
    /// True if the method terminated normally.
    pub completed: bool,
    /// The reason of an early stop, if there was one.
    pub stopped: Option<Stopped>,
    /// The initial and intermediate curves.
    pub trace: Trace,
}

/// The curves at which a search began, and its other minima.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// The initial curve of the motion; `None` for a flow to rest.
    pub first_guess: Option<Curve>,
    /// For the relaxation: the curves of the first few [minima](RelaxSolution::minima), that of the motion included.
    pub minima: Vec<Curve>,
    /// For the relaxation: the number of the start that led to the motion.
    pub best_start: Option<usize>,
}

/// Solves `scenario` and tests the result by forward simulation. `observe` is called with the progress.
///
/// # Errors
/// Invalid input, such as a scenario that [has no solution for an obvious reason](Scenario::check_feasible). A failed
/// solve is not an error: its summary gives the reason.
pub fn solve(
    scenario: &Scenario,
    options: &SolveOptions,
    observe: &mut dyn FnMut(&Record),
) -> Result<SolveReport> {
    options.check()?;
    scenario.check_feasible()?;
    match options.method {
        Method::Flow => {
            scenario.check_for_flow(options.flows_to_rest())?;
            if options.flows_to_rest() {
                return solve_by_flow_to_rest(scenario, options, observe);
            }
            solve_by_flow(scenario, options, observe)
        }
        Method::Relax => solve_by_relaxation(scenario, options, observe),
    }
}

fn solve_by_relaxation(
    scenario: &Scenario,
    options: &SolveOptions,
    observe: &mut dyn FnMut(&Record),
) -> Result<SolveReport> {
    let problem = scenario.problem()?;
    let settings = &options.relax_settings(scenario);
    let started = Instant::now();
    let constraints = scenario.constraints();
    let observe = &mut |iteration: &Iteration| observe(&Record::Relax(*iteration));
    let solution = Relaxation::new(&problem)
        .cost(scenario.running_cost()?)
        .constraints(&constraints)
        .settings(settings.clone())
        .observe(observe)
        .solve()?;
    let solve_seconds = started.elapsed().as_secs_f64();
    let stopped = solution.stopped;
    let missed = failure_of(&solution, settings);
    // With `PlannedStarts::First` a feasible motion is a success, minimum or not.
    let content = settings.planned_starts == PlannedStarts::First && solution.kept;
    let (failure, note) = match (missed, stopped) {
        (Some(missed), _) if content => (None, Some(format!("no minimum: {missed}"))),
        (Some(missed), Some(stopped)) => {
            let failure = format!("{stopped}: the motion is the best until then; {missed}");
            (Some(failure), None)
        }
        (missed, _) => (missed, None),
    };
    let limited = "no minimum was found on horizons beyond this one, towards which the cost falls: another horizon_s, \
                   or more starts, may lead to one";
    let note = note.or_else(|| solution.horizon_limited.then(|| limited.to_owned()));
    let RelaxSolution {
        curve, iterations, ..
    } = solution;
    let trace = Trace {
        first_guess: Some(solution.first_guess),
        minima: solution.minima_curves,
        best_start: solution.best_start,
    };
    // The cost is reported only if it is not the control effort alone.
    let horizon = curve.horizon();
    let time = settings.free_horizon.map(|free| free.weight * horizon);
    let other = time.is_some() || scenario.has_running_cost();
    let details = Details::Relax(RelaxDetails {
        horizon_s: horizon,
        cost: other.then(|| solution.cost + time.unwrap_or(0.0)),
        tolerance: settings.tolerance,
        gradient_norm: solution.gradient_norm,
        smallest_curvature: solution.smallest_curvature,
        largest_violation: (!scenario.is_free()).then_some(solution.largest_violation),
        unknowns: solution.unknowns,
        replay_error_inf: replay_error(&scenario.model, &curve, &scenario.passive())?,
        adapted: solution.adapted,
        quadrature_points: solution.points,
        efforts_of_starts: solution.start_costs,
        complementarity: (!scenario.is_free()).then_some(solution.complementarity),
        minima: solution.minima,
        iterations: iterations.len(),
        factorisations: iterations.iter().map(|i| i.factorisations).sum(),
    });
    let history = iterations.into_iter().map(Record::Relax).collect();
    // No reported value depends on the penalty.
    let effort = effort_of(&scenario.model, &curve, 1.0)?;
    let found = Solution {
        curve,
        effort,
        history,
        details,
        solve_seconds,
        failure,
        note,
        stopped,
        trace,
    };
    report_of(scenario, options, found)
}

/// The reason why a relaxation found no minimum, if it found none.
fn failure_of(solution: &RelaxSolution, settings: &RelaxSettings) -> Option<String> {
    let RelaxSolution {
        converged,
        gradient_norm,
        quadrature_error,
        smallest_curvature,
        largest_violation,
        start_costs,
        ..
    } = solution;
    if *largest_violation > RelaxSettings::FEASIBLE {
        if solution.stopped.is_some() {
            return Some("no motion within the constraints was found".to_owned());
        }
        let starts = match start_costs.len() {
            0 | 1 => "the one start did not lead".to_owned(),
            starts => format!("none of {starts} starts led"),
        };
        return Some(format!(
            "{starts} to a motion within the constraints, which is the end of the search and no proof that there is none"
        ));
    }
    if !converged {
        let off = [
            ("gradient norm", *gradient_norm, settings.tolerance),
            (
                "error of the quadrature",
                *quadrature_error,
                settings.quadrature_tolerance,
            ),
        ];
        let off = off
            .into_iter()
            .filter(|(_, reached, asked)| reached.is_nan() || reached > asked);
        let off: Vec<_> = off
            .map(|(what, reached, asked)| {
                format!("the {what} is {reached:.1e}, {asked:e} was asked for")
            })
            .collect();
        return Some(if off.is_empty() {
            "the search ended before a minimum was sure".to_owned()
        } else {
            format!("where the search ended {}", off.join(", "))
        });
    }
    (*smallest_curvature <= 0.0).then(|| {
        format!("where the gradient vanishes the smallest curvature is {smallest_curvature:.1e}: no minimum")
    })
}

/// The result of a method.
pub(super) struct Solution {
    pub curve: Curve,
    pub effort: EffortSummary,
    pub history: Vec<Record>,
    pub details: Details,
    pub solve_seconds: f64,
    pub failure: Option<String>,
    /// A remark that is not a failure.
    pub note: Option<String>,
    pub stopped: Option<Stopped>,
    pub trace: Trace,
}

/// The report of a curve, independent of the method.
pub(super) fn report_of(
    scenario: &Scenario,
    options: &SolveOptions,
    found: Solution,
) -> Result<SolveReport> {
    let Solution {
        curve,
        effort,
        history,
        details,
        solve_seconds,
        failure,
        note,
        stopped,
        trace,
    } = found;
    let (model, passive) = (&scenario.model, scenario.passive());
    let final_error = |feedback| -> Result<Option<f64>> {
        let simulation = simulate(model, &curve, feedback, &passive)?;
        Ok(simulation.failure.is_none().then_some(simulation.error_inf))
    };
    let final_error_inf = final_error(scenario.file.feedback)?;
    let success_threshold = scenario.file.success_threshold;
    let reached = final_error_inf.is_some_and(|e| e < success_threshold);
    let feasibility = Feasibility::of(scenario, &curve)?;
    let (method, tolerance) = match details {
        Details::Flow(_) | Details::Rest(_) => (Method::Flow, LIMIT_TOLERANCE),
        Details::Relax(_) => (Method::Relax, RelaxSettings::FEASIBLE),
    };
    let feasible = feasibility.holds(tolerance);
    let missed = (!reached).then(|| match final_error_inf {
        Some(error) => format!(
            "the forward simulation with feedback ends {error:.2e} from the goal, beyond {success_threshold}"
        ),
        None => "the forward simulation with feedback stopped before its end".to_owned(),
    });
    let completed = failure.is_none();
    // After a flow the simulation decides on success. After the relaxation it only measures sensitivity, except with
    // passive joints, where it shows whether zero torque there suffices.
    let simulated = method == Method::Flow || !passive.is_empty();
    let success = completed && feasible && (reached || !simulated);
    let mut notes = scenario.notes(options);
    notes.extend(note);
    if let (true, Some(missed)) = (success, &missed) {
        notes.push(format!("{missed}: the motion needs a better controller"));
    }
    // The reasons include all violations, and the simulation where it decides.
    let missed = missed.filter(|_| completed && simulated);
    let reasons = [failure, feasibility.reason(tolerance), missed];
    let reasons: Vec<String> = reasons.into_iter().flatten().collect();
    let failure = (!success).then(|| reasons.join("; "));
    if let (true, Some(stopped)) = (success, stopped) {
        notes.push(format!("{stopped}: the motion is the best until then"));
    }
    let joints = model.joints().iter().map(|joint| joint.name().to_owned());
    let effort_of_passive = effort_of_joints(model, &curve, &passive, INTERVALS)?;
    let summary = Summary {
        scenario: scenario.name.clone(),
        robot: scenario.file.robot.clone(),
        method,
        p: curve.chebyshev().degree(),
        pieces: curve.segments(),
        success,
        success_threshold,
        final_error_inf,
        open_loop_error_inf: final_error(Feedback::NONE)?,
        feedback: scenario.file.feedback,
        // A difference below zero is a rounding error.
        control_effort: (effort.control_effort - effort_of_passive).max(0.0),
        dynamics_defect: effort.dynamics_defect,
        solve_seconds,
        details,
        failure,
        feasibility,
        outside_limits: scenario.outside_limits(),
        notes,
        provenance: Provenance::new(scenario, options),
        curve: CurveFile::new(&curve, joints.collect()),
    };
    Ok(SolveReport {
        summary,
        curve,
        history,
        completed,
        stopped,
        trace,
    })
}
