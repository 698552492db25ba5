//! The steps of a search.

use crate::dense::{Dense, accurate};
use crate::leave_saddle::two_wells;
use aghf::cost::HyperDual64;
use aghf::nlp::{Options, Status};

/// Beside a saddle, where the multiple of the norm makes steps short, they are extended along negative curvature, and
/// derivatives are still those at the iterates.
#[test]
fn steps_along_negative_curvature_are_long() {
    let mut program = Dense::new(two_wells, &[0.01, 0.5], 0, 0);
    let (mut fractions, start) = (Vec::new(), program.start.clone());
    let (x, kkt) = (nalgebra::DVector::from_vec(start), program.kkt());
    let end = aghf::nlp::solve(&mut program, x, None, kkt, &accurate(), &mut |progress| {
        fractions.push(progress.alpha);
    });
    let end = end.expect("no function fails");
    assert_eq!(end.status, Status::Converged);
    assert_close!(&end.x, &[1.0, 0.0], 1e-6);
    assert!(fractions.iter().any(|alpha| *alpha > 2.0), "{fractions:?}");
    assert!(fractions.len() < 15, "{fractions:?}");
}

/// $\tfrac12 (x - 1)^2 + y + 1$ above the parabola $y = x^2 / 2$.
fn above_a_parabola(x: &[HyperDual64]) -> (HyperDual64, Vec<HyperDual64>) {
    let off = x[0] - 1.0;
    (off * off * 0.5 + x[1] + 1.0, vec![x[0] * x[0] * 0.5 - x[1]])
}

/// A row that a step violates by its curvature keeps the multiplier of the linearised row, and does not get that of a
/// violation, its penalty.
#[test]
fn multipliers_follow_the_linearised_rows() {
    let options = Options { iterations: 1, warm_barrier: 1e-6, min_warm_barrier: 1e-6, ..accurate() };
    let start = [0.0, 1e-6];
    let mut program = Dense::new(above_a_parabola, &start, 0, 1);
    let end = program.solve_from(&start, Some(&[1.0]), &options);
    let [state] = end.iterate.working[..] else {
        panic!("there is one row");
    };
    assert_eq!(end.status, Status::Iterations);
    assert!(end.x[0] > 0.1, "{}", end.x);
    assert!((state.multiplier - 1.0).abs() < 0.1, "{state:?}");
}

/// The multiplier of an equality takes the Newton step of the saddle-point equations, and the fraction of it that is
/// taken of the step.
#[test]
fn multipliers_of_equalities_take_the_newton_step() {
    let options = Options { iterations: 1, ..accurate() };
    let start = [0.0, 0.5];
    let mut program = Dense::new(above_a_parabola, &start, 1, 1);
    let end = program.solve_from(&start, None, &options);
    let [equality] = end.iterate.equalities[..] else {
        panic!("there is one equality");
    };
    assert!(end.x[0] > 0.1, "{}", end.x);
    // The whole step is one in the first unknown, and in the multiplier from zero to that of the minimum.
    let off = equality.multiplier - end.x[0];
    assert!(off.abs() < 1e-6, "{equality:?} {}", end.x);
}
