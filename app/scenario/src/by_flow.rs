//! Solving a scenario by a flow.

use super::report::{Record, Solution, SolveReport, Trace, report_of};
use super::summary::{Details, FlowDetails, RestDetails};
use super::{Scenario, SolveOptions};
use aghf::curve::{Chebyshev, Curve};
use aghf::error::Result;
use aghf::flow::rest::{RestRecord, flow_to_rest};
use aghf::flow::{
    FlowRecord, FlowSettings, FlowSolution, Penalised, PenaltyWeights, effort_of, flow,
    flow_constrained,
};
use std::time::Instant;

/// Solves by the published flow.
pub(super) fn solve_by_flow(
    scenario: &Scenario,
    options: &SolveOptions,
    observe: &mut dyn FnMut(&Record),
) -> Result<SolveReport> {
    let problem = scenario.problem()?;
    let settings: &FlowSettings = &options.flow_settings(scenario);
    let penalty = options.penalty(scenario);
    let constraints = Penalised {
        constraints: scenario.constraints()?,
        weights: PenaltyWeights {
            state: penalty,
            torque: penalty,
        },
    };
    let observe = &mut |record: &FlowRecord| observe(&Record::Flow(*record));
    let started = Instant::now();
    let outcome = if scenario.is_free() {
        flow(&problem, settings, observe)?
    } else {
        flow_constrained(&problem, settings, &constraints, observe)?
    };
    let solve_seconds = started.elapsed().as_secs_f64();
    let mut stopped = None;
    let (solution, failure) = match outcome {
        Ok(solution) => (solution, None),
        Err(failure) => {
            stopped = failure.stopped;
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
    let effort = effort_of(&scenario.model, &curve, settings.k)?;
    let interior = settings.p - 1;
    let details = Details::Flow(FlowDetails {
        jacobian: settings.jacobian,
        integrator: settings.integrator,
        k: settings.k,
        s_max: settings.s_max,
        tolerance: settings.tolerance,
        guess: settings.guess,
        k_cons: (!scenario.is_free()).then_some(penalty.k_cons),
        c_cons: (!scenario.is_free()).then_some(penalty.c_cons),
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
    let chebyshev = Chebyshev::new(settings.p, problem.horizon())?;
    let guess = problem.guess(settings.guess, &chebyshev);
    let found = Solution {
        curve,
        effort,
        history,
        details,
        solve_seconds,
        failure,
        note: None,
        stopped,
        trace: Trace {
            first_guess: Some(Curve::new(chebyshev, guess)?),
            ..Trace::default()
        },
    };
    report_of(scenario, options, found)
}

/// Solves by a flow to rest.
pub(super) fn solve_by_flow_to_rest(
    scenario: &Scenario,
    options: &SolveOptions,
    observe: &mut dyn FnMut(&Record),
) -> Result<SolveReport> {
    let problem = scenario.problem()?;
    let settings = &options.rest_settings(scenario);
    let constraints = &scenario.constraints()?;
    let lagrangian = options.lagrangian(scenario)?;
    let observe = &mut |record: &RestRecord| observe(&Record::Rest(*record));
    let started = Instant::now();
    let solution = flow_to_rest(&problem, settings, &lagrangian, constraints, observe)?;
    let solve_seconds = started.elapsed().as_secs_f64();
    let failure = (!solution.at_rest).then(|| match solution.stopped {
        Some(stopped) => format!("{stopped} before the flow was at rest"),
        None => format!(
            "the flow did not come to rest: gradient norm {:.1e}, slip {:.1e}, largest violation {:.1e}, passive torque {:.1e} of the largest",
            solution.gradient_norm, solution.slip, solution.violation, solution.passive_share
        ),
    });
    let details = Details::Rest(RestDetails {
        variant: options.variant.unwrap_or_default(),
        k: lagrangian.k,
        tolerance: settings.tolerance,
        gradient_norm: solution.gradient_norm,
        action: solution.action,
        slip: solution.slip,
        largest_violation: (!scenario.is_free()).then_some(solution.violation),
        guess: solution.guess,
        guesses: solution.guesses,
        steps: solution.steps,
        factorisations: solution.factorisations,
        dual_updates: solution.rounds,
    });
    let effort = effort_of(&scenario.model, &solution.curve, lagrangian.k)?;
    let found = Solution {
        curve: solution.curve,
        effort,
        history: solution.history.into_iter().map(Record::Rest).collect(),
        details,
        solve_seconds,
        failure,
        note: None,
        stopped: solution.stopped,
        trace: Trace::default(),
    };
    report_of(scenario, options, found)
}
