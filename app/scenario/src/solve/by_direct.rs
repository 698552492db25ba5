//! Solving a scenario by the direct method.

use crate::results::report::{Record, Solution, Trace};
use crate::results::summary::{Details, DirectDetails, HorizonBound, LastSearch, ReachedEnd};
use crate::solve::search::Search;
use crate::solve::warm_start::{MultipliersFile, start_from};
use crate::{DirectOptions, Scenario, Solved};
use aghf::direct::{DirectSettings, DirectSolution, GoalSet, Iteration};
use aghf::error::Result;
use aghf::flow::effort_of;
use aghf::motion::{Interrupt, replay_error};
use std::time::Instant;

/// Searches by the direct method, from another motion if there is one; returns the motion, and its result for a report.
pub(crate) fn search_directly(
    scenario: &Scenario,
    options: &DirectOptions,
    (start, interrupt): (Option<&Solved>, Interrupt),
    observe: &mut dyn FnMut(&Record),
    search: impl FnOnce(&mut Search<'_, '_>) -> Result<DirectSolution>,
) -> Result<(DirectSolution, Solution)> {
    let started = Instant::now();
    let settings = DirectSettings {
        interrupt,
        goal: scenario.goal_with_ends()?,
        waypoints: scenario.waypoints_with_guesses()?,
        ..options.settings(scenario)?
    };
    let observe = &mut |iteration: &Iteration| observe(&Record::Direct(*iteration));
    let mut own = Search::new(scenario, settings, observe);
    let start = start.map(|start| start_from(start, options, &mut own)).transpose()?;
    let found = search(&mut own)?;
    let seconds = started.elapsed().as_secs_f64();
    let solution = solution_of(scenario, (&own.settings, own.tried), (start, found.clone()), seconds)?;
    Ok((found, solution))
}

/// The result of a direct solve for a report, with the number of ends to which motions were compared one by one.
pub(crate) fn solution_of(
    scenario: &Scenario,
    (settings, tried): (&DirectSettings, Option<usize>),
    (start, solution): (Option<String>, DirectSolution),
    solve_seconds: f64,
) -> Result<Solution> {
    let stopped = solution.stopped;
    let failure = failure_of(&solution, settings).map(|missed| match stopped {
        Some(stopped) => format!("{stopped}: the motion is the best until then; {missed}"),
        None => missed,
    });
    let DirectSolution { curve, iterations, .. } = solution;
    let trace = Trace {
        first_guess: Some(solution.first_guess),
        minima: solution.minima_curves,
        best_start: solution.best_start,
    };
    let (horizon, starts) = (curve.horizon(), solution.start_costs.len());
    let time = settings.free_horizon.map(|free| free.weight * horizon);
    let details = Details::Direct(Box::new(DirectDetails {
        start,
        multipliers: MultipliersFile::new(&solution.multipliers),
        last_search: solution.free_horizon.map(LastSearch::from),
        horizon_s: horizon,
        horizon_bound: settings.free_horizon.and_then(|_| scenario.horizon_bound()),
        cost: solution.cost + time.unwrap_or(0.0),
        tolerance: settings.tolerance,
        gradient_norm: solution.gradient_norm,
        smallest_curvature: solution.smallest_curvature,
        largest_violation: (!scenario.is_free()).then_some(solution.largest_violation),
        unknowns: solution.unknowns,
        replay_error_inf: replay_error(&scenario.model, &curve, &scenario.passive())?,
        adapted: solution.adapted,
        quadrature_points: solution.points,
        starts_tried: starts,
        start_costs: solution.start_costs,
        stationarity: solution.stationarity,
        complementarity: (!scenario.is_free()).then_some(solution.complementarity),
        minima: solution.minima,
        iterations: iterations.len(),
        factorisations: iterations.iter().map(|i| i.factorisations).sum(),
        waypoint_times_s: solution.waypoint_times,
        end: settings.goal.as_ref().map(|GoalSet { ends, .. }| ReachedEnd {
            goal: solution.alternative,
            measure: scenario.measure().to_owned(),
            found: ends.len(),
            tried: tried.unwrap_or(ends.len().min(starts)),
            q: curve.at(horizon).0.as_slice()[..curve.dof()].to_vec(),
        }),
    }));
    let history = iterations.into_iter().map(Record::Direct).collect();
    // No reported value depends on the penalty.
    let effort = effort_of(&scenario.model, &curve, 1.0)?;
    Ok(Solution { curve, effort, history, details, solve_seconds, failure, stopped, trace })
}

impl Scenario {
    /// The shortest horizon that the limits of a joint allow.
    fn horizon_bound(&self) -> Option<HorizonBound> {
        let (joint, limit, least_s) = self.least_horizon()?;
        Some(HorizonBound { least_s, joint: self.model.joints()[joint].name().to_owned(), limit })
    }
}

/// The reason why a direct solve found no minimum, if it found none.
fn failure_of(solution: &DirectSolution, settings: &DirectSettings) -> Option<String> {
    let DirectSolution {
        converged,
        gradient_norm,
        quadrature_error,
        smallest_curvature,
        largest_violation,
        start_costs,
        ..
    } = solution;
    if *largest_violation > DirectSettings::FEASIBLE {
        if solution.stopped.is_some() {
            return Some("no motion within the constraints was found".to_owned());
        }
        let starts = start_costs.len().max(1);
        let plural = if starts == 1 { "" } else { "s" };
        return Some(format!(
            "no motion within the constraints was found from {starts} start{plural}, which does not prove that there \
             is none"
        ));
    }
    if !converged {
        let off = [
            ("gradient norm", *gradient_norm, settings.tolerance),
            ("error of the quadrature", *quadrature_error, settings.quadrature_tolerance),
        ];
        let off = off.into_iter().filter(|(_, reached, asked)| reached.is_nan() || reached > asked);
        let off: Vec<_> = off
            .map(|(what, reached, asked)| {
                if reached.is_finite() {
                    format!("the {what} is {reached:.1e}, tolerance {asked:e}")
                } else {
                    format!("the {what} is not known")
                }
            })
            .collect();
        return Some(if off.is_empty() {
            "stopped before convergence".to_owned()
        } else {
            format!("not converged: {}", off.join(", "))
        });
    }
    (*smallest_curvature <= 0.0)
        .then(|| format!("a stationary point but not a minimum: the smallest curvature is {smallest_curvature:.1e}"))
}
