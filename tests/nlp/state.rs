//! The beginning and the end of a search.

use crate::dense::{Dense, accurate};
use crate::problems::{assert_near, corner, hs71};
use aghf::cost::HyperDual64;
use aghf::nlp::{Options, Status};

/// Each way to stop before the end is reported.
#[test]
fn stops_are_reported() {
    let program = || Dense::new(hs71, &[1.0, 5.0, 5.0, 1.0], 1, 10);
    let few = Options { iterations: 2, ..accurate() };
    assert_eq!(program().solve(&few).status, Status::Iterations);
    let mut stopped = Dense { stopped: true, ..program() };
    assert_eq!(stopped.solve(&accurate()).status, Status::Stopped);
    let mut coarse = Dense { coarse: true, ..program() };
    assert_eq!(coarse.solve(&accurate()).status, Status::QuadratureTooCoarse);
}

/// A search with known multipliers begins with a penalty above those of its rows, so that it stays within them.
#[test]
fn the_first_penalty_is_above_known_multipliers() {
    let first = |penalty_of_multipliers| {
        let options = Options { penalty: 1e-3, penalty_of_multipliers, iterations: 1, ..accurate() };
        let mut program = Dense::new(corner, &[0.9, 1.0], 0, 3);
        let end = program.solve_from(&[0.9, 1.0], Some(&[2.0, 0.0, 0.0]), &options);
        end.iterate.barrier.nu
    };
    assert_eq!(first(2.0), 4.0);
    assert!(first(0.0) < 0.1, "{}", first(0.0));
}

/// $x^2 + 1$ with $x \ge 1$ and $x \le -1$, which contradict each other, and a row that is kept.
fn contradiction(x: &[HyperDual64]) -> (HyperDual64, Vec<HyperDual64>) {
    (x[0] * x[0] + 1.0, vec![-x[0] + 1.0, x[0] + 1.0, x[0] - 9.0])
}

/// The penalties of all rows grow if larger ones of violated rows do not reduce the violations.
#[test]
fn all_penalties_grow_where_violations_stay() {
    let options = Options { infeasible_cost: 1e6, ..accurate() };
    let end = Dense::new(contradiction, &[0.3], 0, 3).solve(&options);
    assert_eq!(end.status, Status::Infeasible);
    let [violated, _, kept] = [0, 1, 2].map(|k: usize| end.iterate.working[k].penalty);
    assert!(kept > 2.0 && violated > kept, "{violated} {kept}");
}

/// The distance from a point behind a ball.
fn behind(x: &[HyperDual64]) -> (HyperDual64, Vec<HyperDual64>) {
    let [a, b] = [x[0], x[1]];
    let away = a + 2.0;
    (away * away + b * b + 1.0, vec![-(a * a) - b * b + 1.0])
}

/// In front of a ball the distance from a point behind it is the least one but for the second derivatives of the ball.
#[test]
fn a_minimum_has_all_second_derivatives() {
    let end = Dense::new(behind, &[2.0, 0.0], 0, 1).solve(&accurate());
    assert_eq!(end.status, Status::Converged);
    assert_near("behind", end.x.as_slice(), &[-2.0, 0.0], 1e-6);
    assert_eq!(end.iterate.curvature_weight, 1.0);
}
