//! The direct method: optima that are known, and what it says of itself.

use crate::common::direct::{degree, solved};
use crate::common::scenario::Scenario;
use crate::common::{robot, slider};
use aghf::curve::{Curve, gauss_legendre};
use aghf::direct::{Direct, DirectSettings};
use aghf::dynamics::{Data, crba};
use aghf::flow::{ControlForm, Node, RightHandSide, effort_of};
use aghf::motion::Problem;
use nalgebra::{DMatrix, DVector};
use num_dual::{Dual64, DualNum};

/// The double integrator: least $\int u^2 dt$ from rest over a distance `d` in `T` is the cubic, and costs
/// $12 m^2 d^2 / T^3$.
#[test]
fn the_optimum_of_a_double_integrator_is_the_cubic() {
    let (mass, horizon) = (3.0, 1.7);
    let model = slider(mass);
    let problem = Problem::new(&model, vec![0.2, 0.0], vec![1.0, 0.0], horizon).expect("valid");
    let solution = solved(&problem, &degree(9));
    let exact = 12.0 * (mass * 0.8_f64).powi(2) / horizon.powi(3);
    assert!(solution.converged && (solution.cost - exact).abs() < 1e-12 * exact, "{solution:?}");
    assert!((solution.smallest_curvature - 1.0).abs() < 1e-9);
    let (x, _) = solution.curve.at(0.3 * horizon);
    let s = 0.3_f64;
    assert!((x[0] - (0.2 + 0.8 * s * s * (3.0 - 2.0 * s))).abs() < 1e-12);
    // From a velocity to another: Hermite's cubic again, and Simpson's rule is exact for its square.
    let problem = Problem::new(&model, vec![0.2, -1.0], vec![1.0, 2.0], horizon).expect("valid");
    let solution = solved(&problem, &degree(6));
    let (d, v0, v1) = (0.8, -1.0, 2.0);
    let accelerations = [6.0 * d / horizon - 4.0 * v0 - 2.0 * v1, -6.0 * d / horizon + 2.0 * v0 + 4.0 * v1];
    let [a, b] = accelerations.map(|x| mass * x / horizon);
    let exact = horizon * (a * a + a * b + b * b) / 3.0;
    assert!((solution.cost - exact).abs() < 1e-12 * exact, "{} {exact}", solution.cost);
}

/// A robot that has nothing to do does nothing, and that is a minimum.
#[test]
fn no_effort_is_a_minimum() {
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.5, 0.0], vec![0.5, 0.0], 1.0).expect("valid");
    let solution = solved(&problem, &degree(8));
    assert!(solution.converged && solution.cost < 1e-20, "{solution:?}");
}

/// The gradient vanishes, the curvature is positive, no neighbour is lower, and a second call gives the same bits.
#[test]
fn it_ends_at_a_minimum() {
    let scenario = Scenario::load("pendulum_3_swingup");
    let problem = scenario.problem();
    let settings = DirectSettings { tolerance: 1e-11, ..degree(9) };
    let solution = solved(&problem, &settings);
    assert!(solution.converged && solution.gradient_norm <= 1e-11, "{solution:?}");
    assert!(solution.smallest_curvature > 0.0);
    let x = solution.curve.x();
    assert_eq!(x.column(0).as_slice(), problem.start());
    assert_eq!(x.column(9).as_slice(), problem.goal());
    let effort = effort_of(&scenario.model, &solution.curve, 1.0).expect("the same robot");
    assert!((effort.control_effort - solution.cost).abs() <= 1e-3 * solution.cost);
    let again = solved(&problem, &settings);
    assert_eq!(again.curve.x(), x);
    assert_eq!(again.iterations, solution.iterations);

    // Started from its own end it has nothing left to do, and from a coarser end little.
    let warm = DirectSettings { start: Some(solution.curve.clone()), ..degree(9) };
    let warm = solved(&problem, &warm);
    assert!(warm.converged && warm.iterations.len() <= 2, "{:?}", warm.iterations);
    assert_close!(warm.curve.x(), x, 1e-9);
    let finer = DirectSettings { start: Some(solution.curve.clone()), ..degree(12) };
    let finer = solved(&problem, &finer);
    assert!(finer.converged && finer.cost <= solution.cost);
}

/// More starts find nothing worse at the lowest degree, and the line is one of them.
#[test]
fn more_starts_are_no_worse() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let problem = scenario.problem();
    let starts = |starts| solved(&problem, &DirectSettings { starts, ..degree(7) }).start_costs;
    let (one, five) = (starts(1), starts(5));
    assert_eq!((one.len(), five.len()), (1, 5));
    assert!(five.contains(&one[0]) && five[0] <= one[0], "{one:?} {five:?}");
    assert!(five.windows(2).all(|w| w[0] <= w[1]));
}

/// At the least effort the flow pushes no way that keeps $v = \dot q$: for variations $(\varphi, \dot\varphi)$ of
/// the state that vanish with their slope at both ends, $\int (\varphi, \dot\varphi)^T G\, \Omega\, dt = 0$, whatever
/// the penalty.
#[test]
fn the_flow_of_the_optimum_vanishes_on_the_basis() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let (model, problem) = (&scenario.model, scenario.problem());
    let fine = DirectSettings { quadrature_tolerance: 1e-9, ..degree(12) };
    let curve = solved(&problem, &fine).curve;
    let (chebyshev, k) = (curve.chebyshev(0), 10.0);
    let xddot = Curve::new(chebyshev.clone(), curve.x() * chebyshev.d().transpose()).expect("as many nodes");
    let (nodes, weights) = gauss_legendre(200);
    let mut h = DMatrix::zeros(2, 2);
    for power in 0..5 {
        for joint in 0..2 {
            let (mut push, mut size) = (0.0, 0.0);
            for (s, w) in nodes.iter().zip(&weights) {
                let t = 0.5 * problem.horizon() * (1.0 + s);
                let ((x, xdot), (_, xddot)) = (curve.at(t), xddot.at(t));
                let node = Node { t, x: x.as_slice(), xdot: xdot.as_slice(), xddot: xddot.as_slice() };
                let mut omega = DVector::zeros(4);
                ControlForm::new(model).omega(node, k, omega.as_mut_slice()).expect("lengths agree");
                crba(model, &mut Data::new(model), &x.as_slice()[..2], &mut h).expect("lengths agree");
                let lower = &h * &h * omega.rows(2, 2);
                let s = Dual64::from(*s).derivative();
                let variation = (Dual64::from(1.0) - s * s).powi(2) * s.powi(power);
                let parts = [variation.re * k * omega[joint], variation.eps * 2.0 / problem.horizon() * lower[joint]];
                push += w * (parts[0] + parts[1]);
                size += w * (parts[0].abs() + parts[1].abs());
            }
            // The minimiser's quadrature agrees with a finer one to 1e-9 in the cost, and to fewer digits in its slope.
            assert!(push.abs() < 1e-6 * size, "{power} {joint}: {push:e} {size:e}");
        }
    }
}

#[test]
fn bad_settings_are_errors() {
    type Change = fn(&mut DirectSettings);
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.0, 0.0, 0.0], 1.0).expect("valid");
    let refused = |settings: DirectSettings, words: &str| {
        let direct = Direct::new(&problem).settings(settings);
        let error = direct.solve().expect_err(words).to_string();
        assert!(error.contains(words), "{error}; want {words}");
    };
    let words = "settings: degree: it is 3 and must be at least 4 and at most 64";
    refused(degree(3), words);
    refused(degree(65), "settings: degree: it is 65");
    let changes: [(Change, &str); 7] = [
        (|s| s.tolerance = 0.0, "tolerance: it is 0 and must be a positive number"),
        (|s| s.tolerance = f64::NAN, "tolerance: it is NaN"),
        (|s| s.quadrature_tolerance = -1.0, "quadrature_tolerance: it is -1"),
        (|s| s.start_amplitude = f64::INFINITY, "start_amplitude: it is inf"),
        (|s| s.lowest_degree = 1, "lowest_degree: it is 1"),
        (|s| s.starts = 0, "starts: it is 0 and must be at least 1"),
        (|s| s.iterations = 0, "iterations: it is 0"),
    ];
    for (change, words) in changes {
        let mut settings = DirectSettings::default();
        change(&mut settings);
        refused(settings, words);
    }
    let slider = slider(1.0);
    let other = Problem::new(&slider, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let start = DirectSettings { start: Some(solved(&other, &degree(5)).curve), ..DirectSettings::default() };
    refused(start, "start: expected 2 entries, found 1");
}

/// A search that is cut short says so.
#[test]
fn too_few_iterations_are_told() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let settings = DirectSettings { iterations: 1, starts: 1, ..degree(9) };
    let solution = solved(&scenario.problem(), &settings);
    assert!(!solution.converged && solution.gradient_norm > settings.tolerance);
}
