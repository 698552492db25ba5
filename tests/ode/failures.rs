//! The integrators on problems that they cannot finish, and on invalid input.

use crate::common::ode::{both, error, oscillate, oscillate_jacobian, oscillator, solve, system};
use aghf::ode::{NonFinite, Statistics, Tolerance};

#[test]
fn three_non_finite_calls_in_a_row_are_overcome() {
    let outputs = [5.0, 10.0];
    for bad in [f64::NAN, f64::INFINITY] {
        let mut call = 0;
        let mut stumbling = system(
            2,
            |s, y, dy| {
                oscillate(s, y, dy);
                call += 1;
                if (40..43).contains(&call) {
                    dy[1] = bad;
                }
            },
            oscillate_jacobian,
        );
        let (result, seen) = solve(&mut stumbling, 0.0, &[1.0, 0.0], &outputs, both(1e-6));
        assert!(result.unwrap().rejected_steps >= 3);
        assert!(error(&seen, |s| vec![s.cos(), -s.sin()]) < 1e-3);
    }
}

#[test]
fn stumbling_again_and_again_is_overcome() {
    let mut call = 0;
    let mut stumbling = system(
        2,
        |s, y, dy| {
            oscillate(s, y, dy);
            call += 1;
            if call % 7 == 0 {
                dy[0] = f64::NAN;
            }
        },
        oscillate_jacobian,
    );
    let (result, seen) = solve(&mut stumbling, 0.0, &[1.0, 0.0], &[100.0], both(1e-6));
    assert!(result.unwrap().rejected_steps > 100);
    assert!(error(&seen, |s| vec![s.cos(), -s.sin()]) < 1e-3);
}

#[test]
fn a_system_undefined_from_some_point_on_ends_there() {
    let mut undefined = system(
        2,
        |s, y, dy| {
            oscillate(s, y, dy);
            if s > 0.5 {
                dy[1] = f64::NAN;
            }
        },
        oscillate_jacobian,
    );
    let (result, seen) = solve(&mut undefined, 0.0, &[1.0, 0.0], &[0.1, 0.2, 0.9], both(1e-6));
    let failure = result.unwrap_err();
    println!("{failure} {:?}", failure.statistics);
    let non_finite = failure.non_finite.unwrap();
    assert_eq!(non_finite.entry, 1);
    assert!(failure.s <= 0.5 && failure.s > 0.5 - 1e-9, "{}", failure.s);
    assert!(non_finite.s > 0.5 && non_finite.s < 0.5 + 1e-9);
    assert!((failure.y[0] - failure.s.cos()).abs() < 1e-4);
    assert!((failure.y[1] + failure.s.sin()).abs() < 1e-4);
    assert!(failure.reason.contains("Step size is too small"));
    assert!(failure.statistics.steps < 1000 && failure.statistics.steps > 0);
    let times: Vec<f64> = seen.iter().map(|(s, _)| *s).collect();
    assert_eq!(times, [0.1, 0.2]);
}

#[test]
fn undefined_everywhere_but_at_the_start() {
    let mut undefined = system(1, |s, _, dy| dy[0] = if s == 0.0 { 1.0 } else { f64::NAN }, |_, _, _| {});
    let (result, seen) = solve(&mut undefined, 0.0, &[7.0], &[2.0], both(1e-6));
    let failure = result.unwrap_err();
    assert_eq!((failure.s, failure.y.as_slice()), (0.0, [7.0].as_slice()));
    assert_eq!(failure.non_finite.unwrap().entry, 0);
    assert_eq!(failure.statistics.steps, 0);
    assert!(failure.statistics.rhs_evaluations < 1000);
    assert!(seen.is_empty());
}

#[test]
fn undefined_at_the_start() {
    let mut undefined = system(2, |_, _, dy| dy.copy_from_slice(&[0.0, f64::NEG_INFINITY]), |_, _, _| {});
    let (result, _) = solve(&mut undefined, 1.0, &[7.0, 8.0], &[2.0], both(1e-6));
    let failure = result.unwrap_err();
    let expected = NonFinite { s: 1.0, entry: 1 };
    assert_eq!(failure.non_finite, Some(expected));
    assert_eq!(failure.y, [7.0, 8.0]);
    assert_eq!(failure.statistics.rhs_evaluations, 1);
    assert!(failure.to_string().ends_with("initial state (entry 1 of f not finite at s = 1)"));
}

#[test]
fn a_jacobian_that_is_not_finite_is_named() {
    let mut undefined = system(2, oscillate, |_, _, jac| jac[(1, 0)] = f64::NAN);
    let (result, _) = solve(&mut undefined, 0.0, &[1.0, 0.0], &[1.0], both(1e-6));
    let failure = result.unwrap_err();
    assert!(failure.reason.contains("Jacobian at s = 0 is not finite"));
    assert_eq!((failure.s, failure.non_finite), (0.0, None));
}

#[test]
fn a_solution_that_blows_up_ends_in_a_failure() {
    // y = 1 / (1 - s), with one unrelated failure on the way
    let mut call = 0;
    let mut explosive = system(
        1,
        |_, y, dy| {
            call += 1;
            dy[0] = if call == 50 { f64::NAN } else { y[0] * y[0] };
        },
        |_, y, jac| jac[(0, 0)] = 2.0 * y[0],
    );
    let (result, _) = solve(&mut explosive, 0.0, &[1.0], &[2.0], both(1e-8));
    let failure = result.unwrap_err();
    println!("{failure} {:?}", failure.statistics);
    assert!((failure.s - 1.0).abs() < 1e-5);
    assert_eq!(failure.non_finite, None);
}

#[test]
fn too_many_steps_end_in_a_failure() {
    // 1e6 radians at a few dozen steps per period
    let (result, _) = solve(&mut oscillator(), 0.0, &[1.0, 0.0], &[1e6], both(1e-6));
    let failure = result.unwrap_err();
    assert_eq!(failure.statistics.steps, 100_000);
    assert!(failure.reason.contains("100000 steps"));
    assert!(failure.s > 1000.0 && failure.non_finite.is_none());
}

/// s0, y0, outputs, relative and absolute tolerance.
type Input<'a> = (f64, &'a [f64], &'a [f64], f64, f64);

#[test]
fn bad_input_is_refused() {
    let nan = f64::NAN;
    let y: &[f64] = &[1.0, 0.0];
    let bad: &[Input] = &[
        (0.0, &[1.0], &[1.0], 1e-6, 1e-6),
        (0.0, &[1.0, nan], &[1.0], 1e-6, 1e-6),
        (0.0, &[f64::INFINITY, 0.0], &[1.0], 1e-6, 1e-6),
        (nan, y, &[1.0], 1e-6, 1e-6),
        (f64::NEG_INFINITY, y, &[1.0], 1e-6, 1e-6),
        (0.0, y, &[nan], 1e-6, 1e-6),
        (0.0, y, &[nan, 1.0], 1e-6, 1e-6),
        (0.0, y, &[0.5, f64::INFINITY], 1e-6, 1e-6),
        (-1e308, y, &[1e308], 1e-6, 1e-6),
        (0.0, y, &[2.0, 1.0], 1e-6, 1e-6),
        (0.0, y, &[1.0, 1.0], 1e-6, 1e-6),
        (0.0, y, &[0.0, 1.0], 1e-6, 1e-6),
        (0.0, y, &[-1.0], 1e-6, 1e-6),
        (0.0, y, &[1.0], 0.0, 1e-6),
        (0.0, y, &[1.0], 1e-6, 0.0),
        (0.0, y, &[1.0], -1e-6, 1e-6),
        (0.0, y, &[1.0], nan, 1e-6),
        (0.0, y, &[1.0], 1e-6, f64::INFINITY),
    ];
    for &(s0, y0, outputs, relative, absolute) in bad {
        let tolerance = Tolerance { relative, absolute };
        let (result, seen) = solve(&mut oscillator(), s0, y0, outputs, tolerance);
        let failure = result.unwrap_err();
        assert!(failure.reason.starts_with("invalid input: "), "{failure}");
        assert_eq!(failure.statistics, Statistics::default());
        assert!(failure.y.len() == y0.len() && seen.is_empty());
    }
    let mut empty = system(0, |_, _, _| {}, |_, _, _| {});
    let of_nothing = solve(&mut empty, 0.0, &[], &[1.0], both(1e-6)).0;
    let reason = of_nothing.unwrap_err().reason;
    assert_eq!(reason, "invalid input: dimension 0, but 0 initial values");
    let (nothing, _) = solve(&mut oscillator(), 0.0, y, &[], both(1e-6));
    assert_eq!(nothing.unwrap(), Statistics::default());
}

#[test]
fn a_system_that_answers_at_random_neither_panics_nor_hangs() {
    let mut seed = 1_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let wild = [0.0, f64::NAN, f64::INFINITY, 1e300, -1e300, 1e-300];
        let index = usize::try_from(seed >> 60).unwrap();
        let tame = (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        wild.get(index).copied().unwrap_or(tame)
    };
    for _ in 0..100 {
        let mut other = random;
        let mut wild =
            system(2, |_, _, dy| dy.fill_with(&mut random), |_, _, jac| jac.iter_mut().for_each(|x| *x = other()));
        let (result, _) = solve(&mut wild, 0.0, &[1.0, 0.0], &[0.5, 1.0], both(1e-3));
        assert!(result.is_ok() || !result.unwrap_err().reason.is_empty());
    }
}
