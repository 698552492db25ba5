//! The relaxation from planned starts.

use crate::common::relax::solved_within;
use crate::{across, outside, point, ring, wall_with_a_gap};
use aghf::constraint::{AnyConstraint, Constraints, TorqueLimits};
use aghf::relax::{RelaxSettings, RelaxSolution};

fn solve(state: Vec<AnyConstraint>, planned_starts: bool, threads: usize) -> RelaxSolution {
    let model = point();
    let problem = across(&model);
    let kept = Constraints {
        state,
        torque: TorqueLimits(Vec::new()),
    };
    let settings = RelaxSettings {
        degree: 9,
        planned_starts,
        threads,
        ..RelaxSettings::constrained()
    };
    solved_within(&problem, &settings, &kept)
}

/// The largest number of a start.
fn last_start(found: &RelaxSolution) -> Option<usize> {
    found.iterations.iter().filter_map(|i| i.start).max()
}

/// The line does not get through; one of the next two starts does, which bent ones alone do not, on any number of threads alike.
#[test]
fn a_planned_start_gets_through_a_gap() {
    let [found, again] = [1, 3].map(|threads| solve(wall_with_a_gap(), true, threads));
    assert!(found.converged, "{}", found.largest_violation);
    assert_eq!(last_start(&found), Some(2));
    assert_eq!(found.curve.x(), again.curve.x());
    assert_eq!(found.iterations, again.iterations);
    let (x, _) = found.curve.at(0.5);
    assert!((0.5..0.7).contains(&x[1]), "{x}");
    let bent = solve(wall_with_a_gap(), false, 1);
    assert!(last_start(&bent) > Some(2));
}

/// Where the first start gets there planned ones change nothing, and where there is no way all starts are tried.
#[test]
fn planned_starts_are_for_what_is_not_found() {
    let easy = || outside([[0.5, 0.05]], 0.1);
    let [with, without] = [true, false].map(|planned| solve(easy(), planned, 1));
    assert!(with.converged);
    assert_eq!(with.curve.x(), without.curve.x());
    let none = solve(ring(), true, 2);
    assert!(!none.converged && none.largest_violation > 0.01);
    assert_eq!(none.start_costs.len(), 64);
}
