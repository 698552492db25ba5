//! Motions of several polynomials, and degrees that grow until they are enough.

use crate::common::direct::{size, solved, solved_within};
use crate::common::scenario::Scenario;
use crate::common::{assert_refused, robot, slider};
use aghf::constraint::{AnyConstraint, Bound, Bounds, Constraints, Side, TorqueLimits};
use aghf::curve::{Chebyshev, Curve};
use aghf::direct::{Direct, DirectSettings, DirectSolution};
use aghf::dynamics::{Data, aba};
use aghf::flow::effort_of;
use aghf::model::Model;
use aghf::motion::{Feedback, Problem, control_at, replay_error, sample, simulate};
use nalgebra::{DMatrix, DVector};

const HORIZON: f64 = 2.4;

/// Parts of degree 4, all joints alike: a line with bends $b_e s^2 (h - s)^2$, so that the acceleration jumps where two
/// meet.
fn bent(model: &Model, bends: &[f64]) -> Curve {
    let (n, segments) = (model.dof(), bends.len());
    let h = HORIZON / segments as f64;
    let nodes = Chebyshev::new(4, h).expect("valid");
    let x = DMatrix::from_fn(2 * n, 5 * segments, |row, column| {
        let (e, node) = (column / 5, column % 5);
        // At both ends of a part there is nothing of its bend.
        let s = if node == 4 { 0.0 } else { nodes.times()[node] };
        let t = h * (e + node / 4) as f64 + s;
        if row < n {
            0.3 + 0.2 * t + bends[e] * (s * (h - s)).powi(2)
        } else {
            0.2 + 2.0 * bends[e] * s * (h - s) * (h - 2.0 * s)
        }
    });
    Curve::piecewise(HORIZON, segments, x).expect("valid")
}

/// With $u = m a$ the effort of such a curve is $m^2 \sum_e \tfrac45 b_e^2 h^5$. Simpson's rule across a jump would be
/// off by the part of an interval in the whole.
#[test]
fn measures_of_a_curve_of_parts() {
    let (mass, bends) = (3.0, [1.0, -2.0, 0.5, 1.5, -0.7, 2.0, -1.0]);
    let model = slider(mass);
    let curve = bent(&model, &bends);
    let effort = effort_of(&model, &curve, 10.0).expect("same robot");
    let squares: f64 = bends.iter().map(|b| b * b).sum();
    let exact = 0.8 * mass * mass * squares * (HORIZON / 7.0).powi(5);
    // On 286 intervals a part Simpson's rule itself is off by 24 / 286^4.
    assert!((effort.control_effort - exact).abs() < 1e-8 * exact);
    assert!((effort.action - exact).abs() < 1e-8 * exact);
    // The square of the control has the degree of the parts, for which the weights of the nodes are exact.
    assert!((effort.action_at_nodes - exact).abs() < 1e-12 * exact);
    assert!(effort.dynamics_defect < 1e-13);
    let samples = sample(&model, &curve, 70).expect("same robot");
    let after = curve.at_in(3, curve.breakpoints()[3]).1[1];
    assert!((samples[30].a[0] - after).abs() < 1e-9 && (samples[70].t, samples[0].t) == (2.4, 0.0));
}

/// The control of a consistent curve takes the robot along it through all joints.
#[test]
fn simulations_go_through_joints() {
    for (name, bends, drift, steps) in [
        ("pendulum_1", &[3.0, -20.0, 40.0][..], 1e-4, 160),
        ("pendulum_2", &[3.0, -9.0, 20.0], 1e-2, 200),
        ("pendulum_2", &[1.0, -4.0, 9.0, 3.0, -20.0], 0.5, 300),
    ] {
        let model = robot(name);
        let curve = bent(&model, bends);
        let simulated = |feedback| {
            let end = simulate(&model, &curve, feedback, &[]).expect("same robot");
            assert_eq!(end.failure, None);
            end
        };
        let held = simulated(Feedback { kp: 20.0, kv: 20.0 });
        assert!(held.error_inf < 1e-6, "{name}: {:e}", held.error_inf);
        // Open loop the 1e-8 of each step grow on the way.
        let end = simulated(Feedback::NONE);
        assert!(end.error_inf < drift, "{name}: {:e}", end.error_inf);
        // To find each jump by steps that fail takes 1.4 times as many.
        let made = end.statistics.steps;
        assert!((steps / 2..steps).contains(&made), "{name}: {made}");
    }
}

/// The double integrator again: the cubic is in every basis.
#[test]
fn the_cubic_is_found_on_pieces() {
    let (mass, horizon) = (3.0, 1.7);
    let model = slider(mass);
    let problem = Problem::new(&model, vec![0.2, 0.0], vec![1.0, 0.0], horizon).expect("valid");
    let exact = 12.0 * (mass * 0.8_f64).powi(2) / horizon.powi(3);
    for (segments, p) in [(3, 5), (2, 4), (7, 4), (6, 9)] {
        let solution = solved(&problem, &size(segments, p));
        assert!(solution.converged && (solution.cost - exact).abs() < 1e-11 * exact);
        assert_eq!((solution.curve.segments(), solution.unknowns), (segments, segments * (p - 1) - 2));
        for s in [0.0, 0.1, 0.5, 0.7, 1.0_f64] {
            let (x, xdot) = solution.curve.at(s * horizon);
            assert!((x[0] - (0.2 + 0.8 * s * s * (3.0 - 2.0 * s))).abs() < 1e-11);
            let a = 0.8 * (6.0 - 12.0 * s) / horizon.powi(2);
            assert!((xdot[1] - a).abs() < 1e-9, "{} {a}", xdot[1]);
        }
        let x = solution.curve.x();
        assert_eq!(x.column(0).as_slice(), problem.start());
        assert_eq!(x.column(x.ncols() - 1).as_slice(), problem.goal());
    }
}

/// A curve of one size is one of every size that has its breakpoints and its degree, so it costs no more there.
#[test]
fn finer_pieces_cost_no_more() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let problem = scenario.problem();
    let from = |start: &DirectSolution, segments, p| {
        let settings =
            DirectSettings { start: Some(start.curve.clone()), quadrature_tolerance: 1e-7, ..size(segments, p) };
        let solution = solved(&problem, &settings);
        assert!(solution.converged, "{segments} {p}");
        solution
    };
    let first = from(&solved(&problem, &size(1, 9)), 1, 9);
    let [two, three] = [2, 3].map(|segments| from(&first, segments, 9));
    let [four, six, higher] = [(4, 9), (6, 9), (2, 12)].map(|(n, p)| from(&two, n, p));
    // As well as the quadratures agree.
    for (finer, coarser) in [(&two, &first), (&three, &first), (&four, &two), (&six, &two), (&higher, &two)] {
        assert!(finer.cost <= coarser.cost * (1.0 + 1e-6));
    }
    assert!(two.cost < 0.99 * first.cost && four.cost < two.cost);
    let effort = effort_of(&scenario.model, &four.curve, 1.0).expect("same robot");
    assert!((effort.control_effort - four.cost).abs() < 1e-5 * four.cost);
    assert!(effort.dynamics_defect < 1e-9);

    // From its own end there is nothing left to do; fewer segments are a start like any other.
    let again = from(&four, 4, 9);
    assert!(again.iterations.len() <= 2, "{:?}", again.iterations);
    assert_close!(again.curve.x(), four.curve.x(), 1e-8);
    assert!(from(&four, 1, 9).cost >= four.cost);
    assert!(from(&four, 3, 7).converged);
}

fn limited(segments: usize, requirements: &Constraints<Vec<AnyConstraint>>) -> DirectSolution {
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let settings = DirectSettings { degree: 6, segments, ..DirectSettings::constrained() };
    solved_within(&problem, &settings, requirements)
}

/// The velocity rises as a parabola for a quarter, stays at the limit and falls: exactly so on four segments.
#[test]
fn limits_are_kept_on_pieces() {
    let bound = Bound { entry: 1, side: Side::Upper, value: 1.2 };
    let velocity = Constraints {
        state: vec![AnyConstraint::Bounds(Bounds(vec![bound]))],
        torque: TorqueLimits(Vec::new()),
        stage: Default::default(),
    };
    let exact = 8.0 * 1.44 / 3.0 / 0.25;
    let solution = limited(4, &velocity);
    assert!(solution.converged && solution.largest_violation <= 1e-6, "{solution:?}");
    let excess = solution.cost / exact - 1.0;
    // What the reserve of the rows costs.
    assert!((-1e-6..1e-5).contains(&excess), "{excess:e}");
    assert!(solution.start_costs.is_sorted());

    // The control jumps where segments meet: its limit holds on both sides.
    let torque = Constraints { state: Vec::new(), torque: TorqueLimits(vec![Some(4.6)]), stage: Default::default() };
    for segments in [2, 3, 5] {
        let solution = limited(segments, &torque);
        assert!(solution.converged && solution.largest_violation <= 1e-6, "{solution:?}");
        let curve = &solution.curve;
        for (part, ends) in curve.breakpoints().windows(2).enumerate() {
            for i in 0..=1000 {
                let t = ends[0] + (ends[1] - ends[0]) * f64::from(i) / 1000.0;
                let u = curve.at_in(part, t).1[1];
                assert!(u.abs() <= 4.6 + 2e-6, "{segments} {part} {t}: {u}");
            }
        }
    }
}

#[test]
fn an_adaptive_degree_ends_where_it_is_enough() {
    let scenario = Scenario::load("pendulum_1_swingup");
    let problem = scenario.problem();
    let settings = DirectSettings { degree_tolerance: Some(0.01), ..size(1, 9) };
    let solution = solved(&problem, &settings);
    let adapted = solution.adapted.expect("it was asked for");
    assert!(adapted.converged && solution.converged && adapted.tolerance == 0.01);
    let reached = solution.curve.degree();
    assert!(adapted.degrees.first() == Some(&9) && adapted.degrees.last() == Some(&reached));
    assert!((16..64).contains(&reached), "{adapted:?}");
    assert_eq!(adapted.costs.last(), Some(&solution.cost));
    let changes: Vec<f64> = (adapted.costs.windows(2)).map(|w| (w[0] - w[1]) / w[1]).collect();
    let (last, before) = changes.split_last().expect("two degrees at least");
    assert!(*last <= 0.01 && before.iter().all(|c| *c > 0.01));
    assert!(solved(&problem, &size(1, 9)).adapted.is_none());
}

#[test]
fn a_degree_that_is_not_enough_is_told() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let problem = scenario.problem();
    for (segments, p, degrees) in [(1, 48, vec![48, 64]), (8, 24, vec![24, 32])] {
        let settings = DirectSettings { degree_tolerance: Some(1e-9), ..size(segments, p) };
        let solution = solved(&problem, &settings);
        let adapted = solution.adapted.expect("it was asked for");
        assert!(!adapted.converged && adapted.degrees == degrees, "{adapted:?}");
    }
    // A degree at which the search does not converge says nothing about the next.
    let settings = DirectSettings { degree_tolerance: Some(0.01), iterations: 1, ..size(1, 9) };
    let adapted = solved(&problem, &settings).adapted.expect("asked for");
    assert_eq!((adapted.converged, adapted.degrees), (false, vec![9]));
}

#[test]
fn an_adaptive_degree_keeps_constraints() {
    let bound = Bound { entry: 1, side: Side::Upper, value: 1.2 };
    let kept = Constraints {
        state: vec![AnyConstraint::Bounds(Bounds(vec![bound]))],
        torque: TorqueLimits(Vec::new()),
        stage: Default::default(),
    };
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let settings = DirectSettings { degree: 9, degree_tolerance: Some(0.01), ..DirectSettings::constrained() };
    let solution = solved_within(&problem, &settings, &kept);
    let adapted = solution.adapted.expect("it was asked for");
    assert!(solution.converged && adapted.converged, "{adapted:?}");
    assert!(solution.largest_violation <= 1e-6 && adapted.degrees.len() >= 2);
    // The cost falls towards that of the parabolas and the straight line between.
    let exact = 8.0 * 1.44 / 3.0 / 0.25;
    assert!((1.0..1.02).contains(&(solution.cost / exact)));
}

/// Against the method of Runge and Kutta with the polynomial by Lagrange's formula.
#[test]
fn the_error_of_an_interval_by_nodes() {
    let model = robot("pendulum_2");
    let chebyshev = Chebyshev::new(5, 1.3).expect("valid");
    let times = chebyshev.times().to_vec();
    let mut x = DMatrix::from_fn(4, 6, |i, j| 0.3 * ((1 + i) as f64 * times[j]).sin());
    let velocities = x.rows(0, 2) * chebyshev.d().transpose();
    x.rows_mut(2, 2).copy_from(&velocities);
    let curve = Curve::new(chebyshev, x.clone()).expect("valid");
    let mut data = Data::new(&model);
    let mut nodes = DMatrix::zeros(2, 6);
    for (i, t) in times.iter().enumerate() {
        let (x, xdot) = curve.at(*t);
        let mut u = [0.0; 2];
        control_at(&model, &mut data, &x, &xdot, &mut u).expect("same robot");
        nodes.column_mut(i).copy_from_slice(&u);
    }
    let mut rates = |t: f64, y: &DVector<f64>| {
        let lagrange = |i: usize| {
            let others = (0..6).filter(|j| *j != i);
            others.fold(1.0, |w, j| w * (t - times[j]) / (times[i] - times[j]))
        };
        let u = &nodes * DVector::from_fn(6, |i, _| lagrange(i));
        let (mut out, y) = (DVector::zeros(4), y.as_slice());
        let (qdot, a) = out.as_mut_slice().split_at_mut(2);
        qdot.copy_from_slice(&y[2..]);
        aba(&model, &mut data, &y[..2], &y[2..], u.as_slice(), a).expect("lengths agree");
        out
    };
    let mut worst = 0.0_f64;
    for i in 0..5 {
        let (mut y, h) = (x.column(i).into_owned(), (times[i + 1] - times[i]) / 100.0);
        for step in 0..100 {
            let t = times[i] + h * f64::from(step);
            let a = rates(t, &y);
            let b = rates(t + 0.5 * h, &(&y + &a * (0.5 * h)));
            let c = rates(t + 0.5 * h, &(&y + &b * (0.5 * h)));
            let d = rates(t + h, &(&y + &c * h));
            y += (a + (b + c) * 2.0 + d) * (h / 6.0);
        }
        worst = worst.max((y - x.column(i + 1)).amax());
    }
    let error = replay_error(&model, &curve, &[]).expect("same robot");
    let error = error.expect("it ends");
    // The integrator of the library keeps 1e-8 a step.
    assert!((error - worst).abs() < 1e-6 && worst > 1e-4, "{error} {worst}");

    // Where the control is a polynomial of that degree there is none.
    let model = slider(2.0);
    let error = replay_error(&model, &bent(&model, &[1.0, -2.0, 3.0]), &[]).expect("same robot");
    assert!(error.is_some_and(|e| e < 1e-7), "{error:?}");
    let of_another = replay_error(&model, &curve, &[]);
    assert_refused(of_another, "curve: expected 1 entries, found 2");
}

#[test]
fn bad_sizes_are_errors() {
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let degree_tolerance = |tolerance| DirectSettings { degree_tolerance: Some(tolerance), ..Default::default() };
    for (settings, words) in [
        (size(0, 9), "segments: it is 0 and must be at least 1"),
        (size(29, 9), "segments: it is 29 and must be at least 1 and for degree 9 at most 28"),
        (size(usize::MAX, 9), "segments: it is 18446744073709551615"),
        (size(2, 3), "degree: it is 3 and must be at least 4"),
        (degree_tolerance(0.0), "degree_tolerance: it is 0 and must be a positive number"),
        (degree_tolerance(-0.1), "degree_tolerance: it is -0.1"),
        (degree_tolerance(f64::NAN), "degree_tolerance: it is NaN"),
    ] {
        let direct = Direct::new(&problem).settings(settings);
        let error = direct.solve().expect_err(words);
        assert!(error.to_string().contains(words), "{error}; want {words}");
    }
}
