//! The integrators on problems with known solutions.

use crate::common::ode::{both, error, oscillate, oscillate_jacobian, oscillator, solve, solve_by, system};
use crate::common::scenario::Scenario;
use aghf::flow::{Flow, FlowSettings, FlowSolution};
use aghf::motion::{Feedback, simulate, simulate_with};
use aghf::ode::{Bdf, Esdirk34, Failure, Integrator, IntegratorKind, Ode, Statistics, Tolerance};
use nalgebra::{DMatrix, DVector};

#[test]
fn the_error_falls_with_the_tolerance() {
    let outputs: Vec<f64> = (1..=40).map(|k| 0.25 * f64::from(k)).collect();
    let mut previous = f64::INFINITY;
    for exponent in [-4, -7, -10] {
        let tolerance = 10_f64.powi(exponent);
        let (result, seen) = solve(&mut oscillator(), 0.0, &[1.0, 0.0], &outputs, both(tolerance));
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
    let mut forced =
        system(1, |s, y, dy| dy[0] = s.cos() - 1000.0 * (y[0] - s.sin()), |_, _, jac| jac[(0, 0)] = -1000.0);
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
    let a = stiff_solution(1.0).iter().map(|y| y / stiff_solution(1.0)[0]).collect::<Vec<_>>();
    let (result, seen) = solve(&mut stiff(1.0), 0.0, &a, &decades(), both(1e-6));
    let slow = |s: f64| a.iter().map(|a| a * (-s).exp()).collect();
    assert!(error(&seen, slow) < 1e-4);
    let statistics = result.unwrap();
    println!("{statistics:?}");
    assert!(statistics.steps < 60, "{statistics:?}");
}

#[test]
fn a_wrong_jacobian_shows() {
    // checks the two tests above: with a worse Jacobian they would not pass
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
            jac.row_mut(0).copy_from_slice(&[-0.04, 1e4 * y[2], 1e4 * y[1]]);
            jac[(2, 1)] = 6e7 * y[1];
            for j in 0..3 {
                jac[(1, j)] = -jac[(0, j)] - jac[(2, j)];
            }
        },
    )
}

#[test]
fn robertson_against_published_values() {
    let tolerance = Tolerance { relative: 1e-8, absolute: 1e-14 };
    // at 40: Hairer and Wanner; at 1e11: test set for IVP solvers, problem ROBER
    let published = [
        [0.715_827_068_7, 9.185_534_764e-6, 0.284_163_745_7],
        [2.083_340_149_7e-8, 8.333_360_770e-14, 0.999_999_979_17],
    ];
    let (result, seen) = solve(&mut robertson(), 0.0, &[1.0, 0.0, 0.0], &[40.0, 1e11], tolerance);
    for ((_, y), published) in seen.iter().zip(published) {
        for (y, published) in y.iter().zip(published) {
            assert!((y - published).abs() < 1e-5 * published, "{y} {published}");
        }
    }
    assert_eq!(seen.len(), 2);
    assert!(result.unwrap().steps < 3000);
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
    // the counts are those of the actual calls, none of them beyond the end
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

#[test]
fn the_runge_kutta_method_solves_stiff_systems_too() {
    for (tolerance, bound) in [(1e-4, 300), (1e-6, 900)] {
        let start = [1.0, 0.0, -1.0];
        let (system, outputs) = (&mut stiff(1.0), decades());
        let (result, seen) = solve_by(&mut Esdirk34, system, 0.0, &start, &outputs, both(tolerance));
        let error = error(&seen, stiff_solution);
        assert!(error < 100.0 * tolerance, "{error} at {tolerance}");
        let statistics = result.unwrap();
        assert!(statistics.steps < bound, "{statistics:?}");
        assert!(statistics.factorisations > 0, "{statistics:?}");
        // The method differs from the default.
        let by_bdf = solve(&mut stiff(1.0), 0.0, &start, &outputs, both(tolerance)).0;
        assert_ne!(by_bdf.unwrap(), statistics);
    }
}

/// The linearly implicit Euler method with this number of steps between outputs.
struct LinearlyImplicitEuler(usize);

impl Integrator for LinearlyImplicitEuler {
    fn integrate(
        &mut self,
        system: &mut dyn Ode,
        s0: f64,
        y0: &[f64],
        outputs: &[f64],
        _: Tolerance,
        observe: &mut dyn FnMut(f64, &[f64]),
    ) -> Result<Statistics, Failure> {
        let n = system.dim();
        let (mut s, mut y) = (s0, DVector::from_column_slice(y0));
        let (mut dy, mut jac) = (DVector::zeros(n), DMatrix::zeros(n, n));
        let mut statistics = Statistics::default();
        for output in outputs {
            let h = (output - s) / self.0 as f64;
            for _ in 0..self.0 {
                system.rhs(s, y.as_slice(), dy.as_mut_slice());
                jac.fill(0.0);
                system.jacobian(s, y.as_slice(), &mut jac);
                let matrix = DMatrix::identity(n, n) - &jac * h;
                y += matrix.lu().solve(&(&dy * h)).expect("regular");
                s += h;
                statistics.steps += 1;
            }
            s = *output;
            observe(s, y.as_slice());
        }
        Ok(statistics)
    }
}

#[test]
fn an_integrator_of_ones_own_has_its_order() {
    let of = |steps| {
        let mut euler = LinearlyImplicitEuler(steps);
        let (_, seen) = solve_by(&mut euler, &mut oscillator(), 0.0, &[1.0, 0.0], &[1.0], both(1.0));
        error(&seen, |s| vec![s.cos(), -s.sin()])
    };
    let ratio = of(100) / of(200);
    assert!((ratio - 2.0).abs() < 0.05, "{ratio}");
}

/// The flow comes to rest at the same curve with any integrator, and follows the same path at a tight tolerance.
#[test]
fn every_integrator_takes_the_flow_to_the_same_curve() {
    let scenario = Scenario::load("pendulum_1_swingup");
    let problem = scenario.problem();
    let settings = FlowSettings { tolerance: 1e-8, ..FlowSettings::new(9, 1e3, 100.0) };
    let flow = || Flow::new(&problem, settings.clone());
    let run = |flow: Flow<'_>| -> FlowSolution {
        let solution = flow.run().expect("sound");
        assert_eq!(solution.failure, None);
        solution
    };
    let reference = run(flow());
    for (name, kind) in IntegratorKind::by_name() {
        // The integrator can be chosen by name in the settings, or passed as an object.
        let settings = FlowSettings { integrator: kind, ..settings.clone() };
        let named = run(Flow::new(&problem, settings));
        let given = run(match kind {
            IntegratorKind::Bdf => flow().integrator(Bdf),
            IntegratorKind::Esdirk34 => flow().integrator(Esdirk34),
        });
        assert_eq!(named.curve.x(), given.curve.x(), "{name}");
        assert_eq!(named.statistics, given.statistics, "{name}");
        let distance = (given.curve.x() - reference.curve.x()).amax();
        assert!(distance < 1e-5, "{name}: {distance}");
        for (own, other) in named.history.iter().zip(&reference.history) {
            let (own, other) = (own.action_at_nodes, other.action_at_nodes);
            assert!((own - other).abs() < 1e-5 * other, "{name}: {own} beside {other}");
        }
    }
    assert_ne!(run(flow().integrator(Esdirk34)).statistics, reference.statistics, "the two are the same method");
    let own = run(flow().integrator(LinearlyImplicitEuler(20)));
    let distance = (own.curve.x() - reference.curve.x()).amax();
    assert!(distance < 1e-2, "{distance}");
}

#[test]
fn simulations_agree_between_integrators() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let (model, problem) = (&scenario.model, scenario.problem());
    let settings = FlowSettings::new(12, 1e6, 10.0);
    let solution = Flow::new(&problem, settings).run().expect("sound");
    assert_eq!(solution.failure, None);
    let curve = solution.curve;
    let feedback = Feedback { kp: 10.0, kv: 10.0 };
    let by_bdf = simulate(model, &curve, feedback, &[]).expect("sound");
    let other = simulate_with(model, &curve, feedback, &[], &mut Esdirk34).expect("sound");
    assert_eq!(by_bdf.failure, None);
    assert_eq!(other.failure, None);
    assert_ne!(by_bdf.statistics, other.statistics);
    for (a, b) in by_bdf.state.iter().zip(&other.state) {
        assert!((a - b).abs() < 1e-5 * (1.0 + a.abs()), "{a} beside {b}");
    }
}
