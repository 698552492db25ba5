//! The direct method from planned starts.

use crate::common::direct::solved_within;
use crate::{across, outside, point, ring, wall_with_a_gap};
use aghf::constraint::{AnyConstraint, Bound, Bounds, Constraints, Side, TorqueLimits};
use aghf::direct::{Direct, DirectSettings, DirectSolution, FreeHorizon, PlannedStarts};
use aghf::motion::Interrupt;
use std::collections::HashSet;
use std::time::Duration;

/// Rows of the state alone.
fn keeping(state: Vec<AnyConstraint>) -> Constraints<Vec<AnyConstraint>> {
    Constraints { state, torque: TorqueLimits(Vec::new()), stage: Default::default() }
}

fn solve(state: Vec<AnyConstraint>, planned_starts: PlannedStarts, threads: usize) -> DirectSolution {
    let model = point();
    let problem = across(&model);
    let kept = keeping(state);
    let settings = DirectSettings { degree: 9, planned_starts, threads, ..DirectSettings::constrained() };
    solved_within(&problem, &settings, &kept)
}

/// The largest number of a start.
fn last_start(found: &DirectSolution) -> Option<usize> {
    found.iterations.iter().filter_map(|i| i.start).max()
}

/// The straight line collides; the next start, which is planned, leads to a motion and bent ones alone do not, for any
/// number of threads.
#[test]
fn a_planned_start_gets_through_a_gap() {
    let [found, again] = [1, 3].map(|threads| solve(wall_with_a_gap(), PlannedStarts::Later, threads));
    assert!(found.converged, "{}", found.largest_violation);
    assert_eq!(last_start(&found), Some(1));
    assert_eq!(found.curve.x(), again.curve.x());
    assert_eq!(found.iterations, again.iterations);
    let (x, _) = found.curve.at(0.5);
    assert!((0.95..1.05).contains(&x[1]), "{x}");
    let bent = solve(wall_with_a_gap(), PlannedStarts::Never, 1);
    assert!(last_start(&bent) > Some(2), "{:?}", last_start(&bent));
}

/// A gap narrower than twice the margin of the planner has planned starts, too.
#[test]
fn a_planned_start_gets_through_a_gap_without_a_margin() {
    // The balls of radius 0.1 leave 8 mm.
    let narrow = || {
        outside(
            (-24..=24)
                .map(|k| [0.5, 0.05 * f64::from(k)])
                .filter(|[_, y]| !(0.86..1.14).contains(y))
                .chain([[0.5, 0.896], [0.5, 1.104]]),
            0.1,
        )
    };
    let found = solve(narrow(), PlannedStarts::Later, 2);
    assert!(found.converged, "{}", found.largest_violation);
    let (x, _) = found.curve.at(0.5);
    assert!((0.99..1.01).contains(&x[1]), "{x}");
    assert!(last_start(&found) <= Some(6), "{:?}", last_start(&found));
}

/// A planned start with a small penalty leaves its path; the penalty of the next one is larger, unless that is beyond
/// the largest one: then it is the first again.
#[test]
fn later_planned_starts_have_larger_penalties() {
    let model = point();
    let problem = across(&model);
    let kept = keeping(wall_with_a_gap());
    let found = |factor, largest| {
        let mut settings =
            DirectSettings { degree: 9, planned_starts: PlannedStarts::Later, ..DirectSettings::constrained() };
        settings.search.planned_penalty = 1e-6;
        settings.search.planned_penalty_factor = factor;
        settings.search.largest_planned_penalty = largest;
        settings.search.most_starts = 6;
        let found = solved_within(&problem, &settings, &kept);
        (found.converged, last_start(&found))
    };
    // Every other start is planned.
    assert_eq!(found(1e7, 1000.0), (true, Some(3)));
    assert_eq!(found(1.0, 1000.0), (false, Some(5)));
    assert_eq!(found(1e7, 1.0), (false, Some(5)));
}

/// If the first start succeeds, planned ones change nothing; if no path exists, all starts are tried.
#[test]
fn planned_starts_are_for_what_is_not_found() {
    let easy = || outside([[0.5, 0.05]], 0.1);
    let [with, without] = [PlannedStarts::Later, PlannedStarts::Never].map(|planned| solve(easy(), planned, 1));
    assert!(with.converged);
    assert_eq!(with.curve.x(), without.curve.x());
    let none = solve(ring(), PlannedStarts::Later, 2);
    assert!(!none.converged && none.largest_violation > 0.01);
    assert_eq!(none.start_costs.len(), 64);
    // Without paths all starts are bent, each in another way.
    let pairs = none.start_costs.windows(2);
    assert!(pairs.filter(|pair| pair[0] == pair[1]).count() < 8, "{:?}", none.start_costs);
}

/// If the straight line is free, it is the only path: one start has it, and all others differ from it and from each
/// other.
#[test]
fn no_two_starts_are_the_same() {
    let too_slow = Bound { entry: 2, side: Side::Upper, value: 0.9 };
    let mut state = outside([[0.5, 5.0]], 0.1);
    state.push(AnyConstraint::Bounds(Bounds(vec![too_slow])));
    let found = solve(state, PlannedStarts::Later, 2);
    assert!(!found.converged);
    let first = |start| found.iterations.iter().find(|i| i.start == Some(start)).map(|i| i.cost.to_bits());
    let first: HashSet<_> = (0..64).map(|start| first(start).expect("it was tried")).collect();
    assert_eq!(first.len(), 64);
}

/// A planned first start satisfies the constraints from the beginning: after any number of iterations, so does the
/// motion.
#[test]
fn a_planned_first_start_keeps_what_is_asked() {
    let model = point();
    let problem = across(&model);
    let kept = keeping(wall_with_a_gap());
    let solve = |iterations| {
        let settings =
            DirectSettings { planned_starts: PlannedStarts::First, iterations, ..DirectSettings::constrained() };
        let solver = Direct::new(&problem).constraints(&kept);
        let found = solver.settings(settings).solve().expect("valid");
        assert!(found.largest_violation <= DirectSettings::FEASIBLE);
        assert_eq!(last_start(&found), Some(0));
        found
    };
    let whole = solve(500);
    assert!(whole.converged && !whole.kept);
    let costs = [1, 5].map(|iterations| {
        let found = solve(iterations);
        assert!(!found.converged && found.kept);
        found.cost
    });
    assert!(costs[0] >= costs[1] && costs[1] > whole.cost, "{costs:?}");
}

/// A planned first start that is too fast for its limits gets a longer horizon within the allowed range, no longer than
/// necessary.
#[test]
fn a_planned_first_start_has_the_time_that_it_needs() {
    let model = point();
    let problem = across(&model);
    let solve = |longest| {
        let kept = Constraints {
            state: wall_with_a_gap(),
            torque: TorqueLimits(vec![Some(3.0); 2]),
            stage: Default::default(),
        };
        let settings = DirectSettings {
            planned_starts: PlannedStarts::First,
            longest_horizon: longest,
            tolerance: 0.3,
            ..DirectSettings::constrained()
        };
        let solver = Direct::new(&problem).constraints(&kept);
        let found = solver.settings(settings).solve().expect("valid");
        found.curve.horizon()
    };
    let horizon = problem.horizon();
    assert_eq!(solve(None), horizon);
    assert_eq!(solve(Some(1.1 * horizon)), 1.1 * horizon);
    let [long, longer] = [50.0, 100.0].map(|most| solve(Some(most * horizon)));
    assert!(long > 1.1 * horizon && long < 20.0 * horizon && long == longer, "{long}");
}

/// Where the horizon is free, any planned start has the time that its limits need, and begins within them.
#[test]
fn a_planned_start_has_the_time_that_it_needs() {
    let model = point();
    let problem = across(&model);
    let kept =
        Constraints { state: wall_with_a_gap(), torque: TorqueLimits(vec![Some(30.0); 2]), stage: Default::default() };
    let settings = DirectSettings {
        degree: 9,
        free_horizon: Some(FreeHorizon { shortest: 0.1, longest: 50.0, weight: 100.0 }),
        ..DirectSettings::constrained()
    };
    let found = solved_within(&problem, &settings, &kept);
    assert!(found.converged, "{}", found.largest_violation);
    // Start 0 goes straight through the wall.
    let first = |start| found.iterations.iter().find(|i| i.start == Some(start));
    let [straight, planned] = [0, 1].map(|start| first(start).expect("it was tried"));
    assert!(straight.horizon == problem.horizon() && straight.violation > 0.01);
    assert!(planned.horizon > 1.1 * problem.horizon(), "{}", planned.horizon);
    assert!(planned.violation <= DirectSettings::FEASIBLE, "{}", planned.violation);
}

/// A search with a time limit that is stopped at its first iteration ends with the planned start, which satisfies the
/// constraints.
#[test]
fn a_search_that_is_cut_off_has_a_planned_motion() {
    let model = point();
    let problem = across(&model);
    let kept = keeping(wall_with_a_gap());
    let cut_off = |time_limit| {
        let interrupt = Interrupt::default();
        let settings = DirectSettings { time_limit, interrupt: interrupt.clone(), ..DirectSettings::constrained() };
        let solver = Direct::new(&problem).constraints(&kept).settings(settings);
        let solver = solver.observe(|_| interrupt.raise());
        solver.solve().expect("valid")
    };
    let found = cut_off(Some(Duration::from_secs(3600)));
    assert!(found.kept && !found.converged);
    assert!(found.largest_violation <= DirectSettings::FEASIBLE);
    assert_eq!(found.best_start, Some(1));
    assert!(found.smallest_curvature.is_nan());
    // The other start, which violates them, was not continued.
    let mut others = found.iterations.iter().filter(|i| i.start == Some(0));
    assert!(others.all(|i| i.degree == found.iterations[0].degree));
    // Without a limit paths are planned when other starts have failed.
    let without = cut_off(None);
    assert!(!without.kept && without.largest_violation > 0.01);
}

/// A search that ends before its time limit is the one without it.
#[test]
fn a_limit_that_is_not_reached_changes_nothing() {
    let model = point();
    let problem = across(&model);
    let kept = keeping(wall_with_a_gap());
    for free_horizon in [None, Some(FreeHorizon { shortest: 0.5, longest: 8.0, weight: 1.0 })] {
        let [with, without] = [Some(Duration::from_secs(3600)), None].map(|time_limit| {
            let settings = DirectSettings { time_limit, free_horizon, ..DirectSettings::constrained() };
            Direct::new(&problem).constraints(&kept).settings(settings).solve().expect("valid")
        });
        assert!(without.converged && without.best_start > Some(0), "{:?}", without.best_start);
        assert_eq!((with.curve.x(), with.minima), (without.curve.x(), without.minima));
        assert_eq!(with.iterations.len(), without.iterations.len());
    }
}
