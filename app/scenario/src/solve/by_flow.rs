//! Solving a scenario by a flow.

use crate::results::report::{Record, Solution, Trace};
use crate::results::summary::{Details, FlowDetails, RestDetails};
use crate::{FlowOptions, Method, RestOptions, Scenario};
use aghf::curve::{Chebyshev, Curve};
use aghf::error::Result;
use aghf::flow::rest::{FlowToRest, RestSettings};
use aghf::flow::{Flow, FlowSettings, Penalised, PenaltyWeights, effort_of};
use aghf::motion::Interrupt;
use std::time::Instant;

/// Solves by the published flow.
pub(crate) fn solve_by_flow(
    scenario: &Scenario,
    options: &FlowOptions,
    interrupt: Interrupt,
    observe: &mut dyn FnMut(&Record),
) -> Result<Solution> {
    let problem = scenario.problem()?;
    let settings = FlowSettings { interrupt, ..options.settings(scenario)? };
    let penalty = options.penalty(scenario);
    let constraints =
        Penalised { constraints: scenario.constraints(), weights: PenaltyWeights { state: penalty, torque: penalty } };
    let started = Instant::now();
    let mut flow = Flow::new(&problem, settings.clone()).observe(|record| observe(&Record::Flow(*record)));
    if !scenario.is_free() {
        flow = flow.constraints(&constraints);
    }
    let solution = flow.run()?;
    let solve_seconds = started.elapsed().as_secs_f64();
    let statistics = solution.statistics;
    let effort = effort_of(&scenario.model, &solution.curve, settings.k)?;
    let interior = settings.degree - 1;
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
        action_at_nodes_of_guess: solution.history.first().map(|r| r.action_at_nodes),
        steps: statistics.steps,
        rejected_steps: statistics.rejected_steps,
        omega_evaluations: statistics.rhs_evaluations * interior,
        jacobian_evaluations: statistics.jacobian_evaluations * interior,
        factorisations: statistics.factorisations,
    });
    let chebyshev = Chebyshev::new(settings.degree, problem.horizon())?;
    let guess = problem.guess(settings.guess, &chebyshev);
    Ok(Solution {
        curve: solution.curve,
        effort,
        history: solution.history.into_iter().map(Record::Flow).collect(),
        details,
        solve_seconds,
        failure: solution.failure,
        stopped: solution.stopped,
        trace: Trace { first_guess: Some(Curve::new(chebyshev, guess)?), ..Trace::default() },
    })
}

/// Solves by a flow to rest.
pub(crate) fn solve_by_flow_to_rest(
    scenario: &Scenario,
    options: &RestOptions,
    method: Method,
    interrupt: Interrupt,
    observe: &mut dyn FnMut(&Record),
) -> Result<Solution> {
    let problem = scenario.problem()?;
    let settings = RestSettings { interrupt, ..options.settings(scenario, method)? };
    let tolerance = settings.tolerance;
    let constraints = &scenario.constraints();
    let k = options.penalty(scenario)?;
    let started = Instant::now();
    let solution = FlowToRest::new(&problem, k)
        .cost(scenario.running_cost()?)
        .settings(settings)
        .constraints(constraints)
        .observe(|record| observe(&Record::Rest(*record)))
        .run()?;
    let solve_seconds = started.elapsed().as_secs_f64();
    let failure = (!solution.at_rest).then(|| match solution.stopped {
        Some(stopped) => format!("{stopped} before the flow was at rest"),
        None => format!(
            "the flow did not come to rest: gradient norm {:.1e}, slip {:.1e}, largest violation {:.1e}, passive \
            torque {:.1e} of the largest",
            solution.gradient_norm, solution.slip, solution.violation, solution.passive_share
        ),
    });
    let details = Details::Rest(RestDetails {
        k,
        tolerance,
        gradient_norm: solution.gradient_norm,
        action: solution.action,
        slip: solution.slip,
        largest_violation: (!scenario.is_free()).then_some(solution.violation),
        best_start: solution.guess,
        starts_tried: solution.starts,
        steps: solution.steps,
        factorisations: solution.factorisations,
        dual_updates: solution.rounds,
    });
    let effort = effort_of(&scenario.model, &solution.curve, k)?;
    Ok(Solution {
        curve: solution.curve,
        effort,
        history: solution.history.into_iter().map(Record::Rest).collect(),
        details,
        solve_seconds,
        failure,
        stopped: solution.stopped,
        trace: Trace::default(),
    })
}
