//! The integrator on problems whose solutions are known.

use aghf::solve::{Failure, NonFinite, Ode, Statistics, Tolerance, integrate};
use nalgebra::DMatrix;

/// A system from two closures that remembers the largest s it was asked for and counts its calls.
struct System<F, J> {
    dim: usize,
    rhs: F,
    jacobian: J,
    furthest: f64,
    calls: usize,
    jacobians: usize,
}

fn system<F, J>(dim: usize, rhs: F, jacobian: J) -> System<F, J>
where
    F: FnMut(f64, &[f64], &mut [f64]),
    J: FnMut(f64, &[f64], &mut DMatrix<f64>),
{
    System {
        dim,
        rhs,
        jacobian,
        furthest: f64::NEG_INFINITY,
        calls: 0,
        jacobians: 0,
    }
}

impl<F, J> Ode for System<F, J>
where
    F: FnMut(f64, &[f64], &mut [f64]),
    J: FnMut(f64, &[f64], &mut DMatrix<f64>),
{
    fn dim(&self) -> usize {
        self.dim
    }
    fn rhs(&mut self, s: f64, y: &[f64], dy: &mut [f64]) {
        assert!(y.iter().all(|y| y.is_finite()));
        self.furthest = self.furthest.max(s);
        self.calls += 1;
        (self.rhs)(s, y, dy);
    }
    fn jacobian(&mut self, s: f64, y: &[f64], jac: &mut DMatrix<f64>) {
        assert!(jac.shape() == (self.dim, self.dim) && jac.iter().all(|x| *x == 0.0));
        self.furthest = self.furthest.max(s);
        self.jacobians += 1;
        (self.jacobian)(s, y, jac);
    }
}

fn oscillator() -> impl Ode {
    system(2, oscillate, oscillate_jacobian)
}

fn oscillate(_s: f64, y: &[f64], dy: &mut [f64]) {
    dy.copy_from_slice(&[y[1], -y[0]]);
}

fn oscillate_jacobian(_s: f64, _y: &[f64], jac: &mut DMatrix<f64>) {
    jac[(0, 1)] = 1.0;
    jac[(1, 0)] = -1.0;
}

fn both(tolerance: f64) -> Tolerance {
    Tolerance {
        relative: tolerance,
        absolute: tolerance,
    }
}

type Observed = Vec<(f64, Vec<f64>)>;

fn solve(
    system: &mut impl Ode,
    s0: f64,
    y0: &[f64],
    outputs: &[f64],
    tolerance: Tolerance,
) -> (Result<Statistics, Failure>, Observed) {
    let mut seen = Vec::new();
    let result = integrate(system, s0, y0, outputs, tolerance, &mut |s, y| {
        seen.push((s, y.to_vec()));
    });
    (result, seen)
}

/// Largest difference to the exact solution over all outputs.
fn error(seen: &Observed, exact: impl Fn(f64) -> Vec<f64>) -> f64 {
    let of = |(s, y): &(f64, Vec<f64>)| {
        let pairs = y.iter().zip(exact(*s));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    seen.iter().map(of).fold(0.0, f64::max)
}

#[test]
fn the_error_falls_with_the_tolerance() {
    let outputs: Vec<f64> = (1..=40).map(|k| 0.25 * f64::from(k)).collect();
    let mut previous = f64::INFINITY;
    for exponent in [-4, -7, -10] {
        let tolerance = 10_f64.powi(exponent);
        let (result, seen) = solve(
            &mut oscillator(),
            0.0,
            &[1.0, 0.0],
            &outputs,
            both(tolerance),
        );
        let error = error(&seen, |s| vec![s.cos(), -s.sin()]);
        assert!(error < 1000.0 * tolerance, "{error} at {tolerance}");
        assert!(error < 0.1 * previous, "{error} at {tolerance}");
        assert!(result.unwrap().steps < 500);
        previous = error;
    }
}

#[test]
fn a_right_hand_side_that_depends_on_s() {
    // y = sin s + (y0 - sin s0) exp(-1000 (s - s0)), away from s0 = 0
    let mut forced = system(
        1,
        |s, y, dy| dy[0] = s.cos() - 1000.0 * (y[0] - s.sin()),
        |_, _, jac| jac[(0, 0)] = -1000.0,
    );
    let (result, seen) = solve(&mut forced, -3.0, &[1.0], &[-2.5, 0.0, 2.0], both(1e-7));
    assert!(error(&seen, |s| vec![s.sin()]) < 1e-5);
    assert!(result.unwrap().steps < 300);
    assert_eq!(forced.furthest, 2.0);
}

/// Eigenvalues -1, -1e6 and -1e14, each component driven by the one before:
/// y0' = -y0, y1' = 1e6 (y0 - y1), y2' = 1e14 (y1 - y2). The Jacobian is off by `fidelity`.
fn stiff(fidelity: f64) -> impl Ode {
    system(
        3,
        |_, y, dy| {
            dy.copy_from_slice(&[-y[0], 1e6 * (y[0] - y[1]), 1e14 * (y[1] - y[2])]);
        },
        move |_, _, jac| {
            jac[(0, 0)] = -fidelity;
            for (i, rate) in [(1, 1e6), (2, 1e14)] {
                jac[(i, i - 1)] = rate * fidelity;
                jac[(i, i)] = -rate * fidelity;
            }
        },
    )
}

/// The solution of [`stiff`] from (1, 0, -1).
fn stiff_solution(s: f64) -> Vec<f64> {
    let (a, b) = (1e6, 1e14);
    let (slow, fast, fastest) = ((-s).exp(), (-a * s).exp(), (-b * s).exp());
    let middle = a / (a - 1.0);
    let (p, q) = (middle * b / (b - 1.0), -middle * b / (b - a));
    let last = p * slow + q * fast + (-1.0 - p - q) * fastest;
    vec![slow, middle * (slow - fast), last]
}

/// 26 points from 1e-6 to 0.1, evenly on a logarithmic scale.
fn decades() -> Vec<f64> {
    let power = |k: i32| 10_f64.powf(-6.0 + f64::from(k) / 5.0);
    let mut outputs: Vec<f64> = (0..25).map(power).collect();
    outputs.push(0.1);
    outputs
}

#[test]
fn eigenvalues_to_minus_1e14_take_few_steps() {
    for (tolerance, bound) in [(1e-4, 200), (1e-6, 350), (1e-8, 650)] {
        let start = [1.0, 0.0, -1.0];
        let (result, seen) = solve(&mut stiff(1.0), 0.0, &start, &decades(), both(tolerance));
        let error = error(&seen, stiff_solution);
        assert!(error < 100.0 * tolerance, "{error} at {tolerance}");
        let statistics = result.unwrap();
        println!("{statistics:?}");
        assert!(statistics.steps < bound, "{statistics:?}");
    }
}

#[test]
fn a_state_without_fast_components_takes_next_to_no_steps() {
    let a = stiff_solution(1.0)
        .iter()
        .map(|y| y / stiff_solution(1.0)[0])
        .collect::<Vec<_>>();
    let (result, seen) = solve(&mut stiff(1.0), 0.0, &a, &decades(), both(1e-6));
    let slow = |s: f64| a.iter().map(|a| a * (-s).exp()).collect();
    assert!(error(&seen, slow) < 1e-4);
    let statistics = result.unwrap();
    println!("{statistics:?}");
    assert!(statistics.steps < 60, "{statistics:?}");
}

#[test]
fn a_wrong_jacobian_shows() {
    // guards the two tests above: with a worse Jacobian they would not pass
    for fidelity in [0.0, 0.5] {
        let start = [1.0, 0.0, -1.0];
        let (result, _) = solve(&mut stiff(fidelity), 0.0, &start, &decades(), both(1e-6));
        println!("{result:?}");
        let steps = result.map_or(usize::MAX, |statistics| statistics.steps);
        assert!(steps > 1000, "{steps} steps at fidelity {fidelity}");
    }
}

fn robertson() -> impl Ode {
    system(
        3,
        |_, y, dy| {
            dy[0] = -0.04 * y[0] + 1e4 * y[1] * y[2];
            dy[2] = 3e7 * y[1] * y[1];
            dy[1] = -dy[0] - dy[2];
        },
        |_, y, jac| {
            jac.row_mut(0)
                .copy_from_slice(&[-0.04, 1e4 * y[2], 1e4 * y[1]]);
            jac[(2, 1)] = 6e7 * y[1];
            for j in 0..3 {
                jac[(1, j)] = -jac[(0, j)] - jac[(2, j)];
            }
        },
    )
}

#[test]
fn robertson_against_published_values() {
    let tolerance = Tolerance {
        relative: 1e-8,
        absolute: 1e-14,
    };
    // at 40: Hairer and Wanner; at 1e11: test set for IVP solvers, problem ROBER
    let published = [
        [0.715_827_068_7, 9.185_534_764e-6, 0.284_163_745_7],
        [2.083_340_149_7e-8, 8.333_360_770e-14, 0.999_999_979_17],
    ];
    let (result, seen) = solve(
        &mut robertson(),
        0.0,
        &[1.0, 0.0, 0.0],
        &[40.0, 1e11],
        tolerance,
    );
    for ((_, y), published) in seen.iter().zip(published) {
        for (y, published) in y.iter().zip(published) {
            assert!((y - published).abs() < 1e-5 * published, "{y} {published}");
        }
    }
    assert_eq!(seen.len(), 2);
    assert!(result.unwrap().steps < 3000);
}

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
    let (result, seen) = solve(
        &mut undefined,
        0.0,
        &[1.0, 0.0],
        &[0.1, 0.2, 0.9],
        both(1e-6),
    );
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
    let mut undefined = system(
        1,
        |s, _, dy| dy[0] = if s == 0.0 { 1.0 } else { f64::NAN },
        |_, _, _| {},
    );
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
    let mut undefined = system(
        2,
        |_, _, dy| dy.copy_from_slice(&[0.0, f64::NEG_INFINITY]),
        |_, _, _| {},
    );
    let (result, _) = solve(&mut undefined, 1.0, &[7.0, 8.0], &[2.0], both(1e-6));
    let failure = result.unwrap_err();
    let expected = NonFinite { s: 1.0, entry: 1 };
    assert_eq!(failure.non_finite, Some(expected));
    assert_eq!(failure.y, [7.0, 8.0]);
    assert_eq!(failure.statistics.rhs_evaluations, 1);
    assert!(
        failure
            .to_string()
            .ends_with("initial state (entry 1 of f not finite at s = 1)")
    );
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
    // y = 1 / (1 - s), with a stumble on the way that has nothing to do with the end
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

#[test]
fn the_same_call_gives_the_same_bits() {
    let start = [1.0, 0.0, -1.0];
    let run = || solve(&mut stiff(1.0), 0.0, &start, &decades(), both(1e-6));
    let ((first, seen), (second, again)) = (run(), run());
    assert_eq!(first.unwrap(), second.unwrap());
    assert_eq!(seen, again);
}

#[test]
fn outputs_are_met_exactly_and_do_not_influence_the_steps() {
    let mut alone = system(2, oscillate, oscillate_jacobian);
    let (reference, last) = solve(&mut alone, 0.3, &[1.0, 0.0], &[1.7], both(1e-6));
    let outputs = [0.3 + 1e-15, 0.31, 0.4, 1.0, 1.7 - 1e-15, 1.7];
    let mut system = system(2, oscillate, oscillate_jacobian);
    let (result, seen) = solve(&mut system, 0.3, &[1.0, 0.0], &outputs, both(1e-6));
    let times: Vec<f64> = seen.iter().map(|(s, _)| *s).collect();
    assert_eq!(times, outputs);
    assert_eq!(seen.last(), last.last());
    assert!(error(&seen, |s| vec![(s - 0.3).cos(), -(s - 0.3).sin()]) < 1e-4);
    let statistics = result.unwrap();
    assert_eq!(statistics, reference.unwrap());
    // the counts are those of the real calls, none of them beyond the end
    assert_eq!(statistics.rhs_evaluations, system.calls);
    assert_eq!(statistics.jacobian_evaluations, system.jacobians);
    assert_eq!(system.furthest, 1.7);
}

#[test]
fn rounding_does_not_lead_beyond_the_end() {
    let (s0, end) = (-0.1, 0.2);
    assert!(s0 + (end - s0) > end, "the case is in the loop");
    for end in (1..50).map(|k| f64::from(k) / 10.0) {
        let mut system = system(2, oscillate, oscillate_jacobian);
        let (result, seen) = solve(&mut system, s0, &[1.0, 0.0], &[end], both(1e-4));
        assert!(result.is_ok() && seen[0].0 == end && system.furthest <= end);
    }
}

#[test]
fn intervals_of_any_length_and_a_constant_solution() {
    for span in [1e-12, 1.0, 1e12] {
        let mut still = system(1, |_, _, dy| dy[0] = 0.0, |_, _, _| {});
        let (result, seen) = solve(&mut still, 0.0, &[3.0], &[0.5 * span, span], both(1e-6));
        assert!(result.unwrap().steps < 20);
        assert_eq!(seen, [(0.5 * span, vec![3.0]), (span, vec![3.0])]);
        // y = 2 s / span: a straight line from zero
        let mut line = system(1, |_, _, dy| dy[0] = 2.0 / span, |_, _, _| {});
        let (result, seen) = solve(&mut line, 0.0, &[0.0], &[0.5 * span, span], both(1e-6));
        assert!(result.unwrap().steps < 50);
        assert!(error(&seen, |s| vec![2.0 * s / span]) < 1e-5);
    }
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
    assert!(solve(&mut empty, 0.0, &[], &[1.0], both(1e-6)).0.is_err());
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
        let mut wild = system(
            2,
            |_, _, dy| dy.fill_with(&mut random),
            |_, _, jac| jac.iter_mut().for_each(|x| *x = other()),
        );
        let (result, _) = solve(&mut wild, 0.0, &[1.0, 0.0], &[0.5, 1.0], both(1e-3));
        assert!(result.is_ok() || !result.unwrap_err().reason.is_empty());
    }
}
