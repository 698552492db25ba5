//! Searches that are stopped before their end.

use crate::common::direct::{degree, solved};
use crate::common::scenario::Scenario;
use aghf::direct::{Direct, DirectSettings, DirectSolution, FreeHorizon, Iteration};
use aghf::motion::{Interrupt, Stopped};
use std::collections::BTreeSet;
use std::time::Duration;

/// The solution where the interrupt is raised at the first iteration of which `when` is true.
fn stopped_when(settings: DirectSettings, when: impl Fn(&Iteration) -> bool) -> DirectSolution {
    let scenario = Scenario::load("pendulum_3_swingup");
    let problem = scenario.problem();
    let interrupt = Interrupt::default();
    let settings = DirectSettings { interrupt: interrupt.clone(), ..settings };
    let raise = |iteration: &Iteration| {
        if when(iteration) {
            interrupt.raise();
        }
    };
    let solution = Direct::new(&problem).settings(settings).observe(raise).solve().expect("good input");
    assert_eq!(solution.stopped, Some(Stopped::Interrupt));
    let x = solution.curve.x();
    assert_eq!(x.column(0).as_slice(), problem.start());
    assert_eq!(x.column(x.ncols() - 1).as_slice(), problem.goal());
    solution
}

#[test]
fn a_search_without_time_is_its_first_guess() {
    let scenario = Scenario::load("kinova_free_02");
    let problem = scenario.problem();
    // The limit of the settings, and that of a handle.
    let none = Some(Duration::ZERO);
    for (time_limit, interrupt) in [(none, Interrupt::default()), (None, Interrupt::after(Duration::ZERO))] {
        let settings = DirectSettings { time_limit, interrupt, starts: 3, ..degree(16) };
        let solution = solved(&problem, &settings);
        assert_eq!(solution.stopped, none.map(Stopped::TimeLimit));
        assert!(!solution.converged && solution.minima.is_empty());
        assert!(solution.iterations.iter().all(|i| i.step == 0.0), "nothing moved");
        assert!(solution.iterations.iter().all(|i| i.start == Some(0)), "no other start was begun");
        assert!(solution.cost.is_finite() && solution.cost > 0.0);
    }
}

#[test]
fn what_was_found_before_the_interrupt_is_kept() {
    let settings = |starts| DirectSettings { starts, ..degree(9) };
    let scenario = Scenario::load("pendulum_3_swingup");
    let few = solved(&scenario.problem(), &settings(8));
    assert_eq!(few.stopped, None);
    let all: BTreeSet<_> = few.iterations.iter().map(|i| i.start).collect();
    assert_eq!(all, (0..8).map(Some).collect());
    // Starts come in batches of eight.
    let stopped = stopped_when(settings(400), |i| i.start >= Some(8));
    assert!(stopped.converged);
    assert_eq!((stopped.cost, &stopped.minima), (few.cost, &few.minima));
    assert!(stopped.iterations.iter().all(|i| i.start < Some(16)), "none was begun after it");
}

/// The best of them goes on to the degree that was asked for without another step.
#[test]
fn a_search_that_is_stopped_on_the_way_ends_at_its_degree() {
    let solution = stopped_when(DirectSettings { starts: 2, ..degree(16) }, |_| true);
    assert!(!solution.converged);
    assert_eq!(solution.curve.degree(), 16);
    let after: Vec<_> = solution.iterations.iter().filter(|i| i.degree > 6).collect();
    assert!(!after.is_empty() && after.iter().all(|i| i.step == 0.0));
}

/// A search with a free horizon that is stopped on the way has the horizon of its last step.
#[test]
fn the_horizon_at_the_interrupt_is_kept() {
    let free = FreeHorizon { shortest: 0.5, longest: 20.0, weight: 30.0 };
    let settings = DirectSettings { starts: 1, free_horizon: Some(free), ..degree(9) };
    let complete = {
        let scenario = Scenario::load("pendulum_3_swingup");
        solved(&scenario.problem(), &settings)
    };
    assert!(complete.converged);
    let stopped = stopped_when(settings, |i| i.horizon != 2.0);
    assert!(!stopped.converged, "the horizon is not stationary");
    let last = stopped.iterations.last().expect("there are iterations");
    assert_eq!(stopped.curve.horizon(), last.horizon);
    assert_ne!(last.horizon, complete.curve.horizon());
}

#[test]
fn a_seed_bends_the_starts() {
    let scenario = Scenario::load("pendulum_3_swingup");
    let problem = scenario.problem();
    let of = |seed| {
        let settings = DirectSettings { seed, starts: 3, ..degree(6) };
        solved(&problem, &settings).start_costs
    };
    let costs = [of(0), of(1), of(1)];
    assert_eq!(costs[1], costs[2]);
    let shared = costs[0].iter().filter(|cost| costs[1].contains(cost));
    assert_eq!(shared.count(), 1, "the line has no bends: {costs:?}");
}
