//! Points on the way.

use crate::common::direct::{solved, solved_within};
use crate::common::{assert_refused, point_mass, robot};
use aghf::constraint::{AnyConstraint, Bound, Bounds, Constraints, FrameRows, Side, StageConstraints, TorqueLimits};
use aghf::direct::{Direct, DirectSettings, DirectSolution, FreeHorizon, Waypoint};
use aghf::dynamics::{forward_kinematics, frame_placement};
use aghf::model::{Frame, Model};
use aghf::motion::Problem;
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};

fn through(waypoints: Vec<Waypoint>) -> DirectSettings {
    DirectSettings { waypoints, starts: 2, ..DirectSettings::constrained() }
}

fn stop(q: Vec<f64>) -> Waypoint {
    Waypoint { stop: true, ..Waypoint::new(q) }
}

/// Asserts that the motion converged, is at its waypoints within 1e-6, and has a zero velocity where it stops.
fn assert_passes(solution: &DirectSolution, waypoints: &[Waypoint]) {
    assert!(solution.converged, "{:e}", solution.largest_violation);
    let times = &solution.waypoint_times;
    assert_eq!(times.len(), waypoints.len());
    assert!(times.is_sorted() && times[0] > 0.0, "{times:?}");
    for (waypoint, time) in waypoints.iter().zip(times) {
        let (x, _) = solution.curve.at(*time);
        let n = solution.curve.dof();
        let off = x.rows(0, n) - nalgebra::DVector::from_column_slice(&waypoint.guesses[0]);
        assert!(off.amax() < 2e-6, "off by {:e}", off.amax());
        if waypoint.stop {
            let v = x.rows(n, n).amax();
            assert!(v < 1e-5, "{v:e} rad/s");
        }
    }
}

fn masses() -> Model {
    point_mass(&[Vector3::x(), Vector3::y()])
}

/// A waypoint on the best motion does not change it, and has the time at which it passes: from rest to rest
/// $3 \tau^2 - 2 \tau^3$ of the way.
#[test]
fn a_point_on_the_way_changes_nothing() {
    let model = masses();
    let problem = Problem::new(&model, vec![0.0; 4], vec![2.0, 1.0, 0.0, 0.0], 1.3).expect("valid");
    let free = solved(&problem, &through(Vec::new()));
    let share = |tau: f64| 3.0 * tau * tau - 2.0 * tau * tau * tau;
    let at = [0.3, 0.8];
    let waypoints: Vec<_> = at.iter().map(|tau| Waypoint::new(vec![2.0 * share(*tau), share(*tau)])).collect();
    let solution = solved(&problem, &through(waypoints.clone()));
    assert_passes(&solution, &waypoints);
    assert!((solution.cost / free.cost - 1.0).abs() < 1e-7);
    for (time, tau) in solution.waypoint_times.iter().zip(at) {
        assert!((time - 1.3 * tau).abs() < 1e-5, "{time}");
    }
}

/// A mass that stops halfway makes two motions from rest to rest, each of effort $12 m^2 d^2 / T^3$ in half of the
/// time: with one polynomial almost.
#[test]
fn a_stop_halfway_makes_two_motions() {
    let model = masses();
    let rest = |q: [f64; 2]| vec![q[0], q[1], 0.0, 0.0];
    let problem = |to, horizon| Problem::new(&model, vec![0.0; 4], rest(to), horizon).expect("valid");
    let waypoints = vec![stop(vec![1.0, 0.5])];
    let settings = DirectSettings { degree: 32, ..through(waypoints.clone()) };
    let solution = solved(&problem([2.0, 0.0], 2.0), &settings);
    assert_passes(&solution, &waypoints);
    assert!((solution.waypoint_times[0] - 1.0).abs() < 1e-4);
    let one = solved(&problem([1.0, 0.5], 1.0), &through(Vec::new()));
    let excess = solution.cost / (2.0 * one.cost) - 1.0;
    assert!((0.0..0.1).contains(&excess), "{excess}");
}

/// The unknown time is the best one: the motion through the same point at a given time costs more before and after, and
/// the same at that time.
#[test]
fn the_time_is_the_best_one() {
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.1, 0.0, 0.4, -0.2], vec![1.0, 0.5, 0.0, 0.0], 1.5).expect("valid");
    let waypoint = Waypoint::new(vec![-0.3, 0.9]);
    let free = solved(&problem, &through(vec![waypoint.clone()]));
    assert_passes(&free, std::slice::from_ref(&waypoint));
    let best = free.waypoint_times[0];
    let at = |time: f64| {
        let waypoint = Waypoint { share: Some(time / problem.horizon()), ..waypoint.clone() };
        let solution = solved(&problem, &through(vec![waypoint.clone()]));
        assert_passes(&solution, &[waypoint]);
        assert_eq!(solution.waypoint_times, [time]);
        solution.cost
    };
    assert!((at(best) / free.cost - 1.0).abs() < 1e-6);
    for off in [-0.05, 0.05] {
        assert!(at(best + off) > 1.0001 * free.cost);
    }
}

/// With a free horizon and moving ends the horizon is the best one too: the motion on a horizon beside it costs more.
#[test]
fn the_horizon_is_the_best_one_too() {
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.1, 0.0, 0.4, -0.2], vec![1.0, 0.5, 0.3, 0.0], 1.5).expect("valid");
    let waypoints = vec![Waypoint::new(vec![0.2, 0.9]), Waypoint::new(vec![0.4, -0.3])];
    let weight = 20.0;
    let settings = DirectSettings {
        free_horizon: Some(FreeHorizon { shortest: 0.2, longest: 6.0, weight }),
        ..through(waypoints.clone())
    };
    let free = solved(&problem, &settings);
    assert_passes(&free, &waypoints);
    let (horizon, total) = (free.curve.horizon(), free.cost + weight * free.curve.horizon());
    for (factor, least) in [(1.0, -1e-6), (0.95, 1e-5), (1.05, 1e-5)] {
        let own = problem.with_horizon(factor * horizon).expect("valid");
        let settings = DirectSettings { start: Some(free.curve.clone()), ..through(waypoints.clone()) };
        let fixed = solved(&own, &settings);
        assert_passes(&fixed, &waypoints);
        let more = (fixed.cost + weight * factor * horizon) / total - 1.0;
        assert!(more > least, "{factor}: {more:e}");
    }
}

/// A waypoint may be a set: here a half-plane, of which the mass touches the edge at the best point.
#[test]
fn a_set_is_touched_at_its_best_point() {
    let model = masses();
    let problem = Problem::new(&model, vec![0.0; 4], vec![2.0, 0.0, 0.0, 0.0], 2.0).expect("valid");
    let bound = Bound { entry: 1, side: Side::Lower, value: 0.5 };
    let waypoint =
        Waypoint { constraints: vec![AnyConstraint::Bounds(Bounds(vec![bound]))], ..Waypoint::new(vec![0.3, 0.7]) };
    let solution = solved(&problem, &through(vec![waypoint]));
    assert!(solution.converged);
    let (x, _) = solution.curve.at(solution.waypoint_times[0]);
    assert!((solution.waypoint_times[0] - 1.0).abs() < 1e-3 && (x[1] - 0.5).abs() < 1e-6, "{x}");
}

/// A foot that lands has no speed at its share of the horizon, though the joints have: here the tip of an arm, which
/// is held in one place across a line.
#[test]
fn a_frame_lands_without_speed() {
    let model = robot("pendulum_3");
    let tip = model.frames().last().expect("it has links");
    let (start, goal) = ([0.2, 0.3, 0.4], [1.0, 0.2, 0.1]);
    let problem = Problem::new(&model, [start, [0.0; 3]].concat(), [goal, [0.0; 3]].concat(), 1.5).expect("valid");
    let between = [0.6, 0.4, 0.2];
    let place = |q: &[f64]| {
        let mut bodies = vec![Placement::identity(); 3];
        forward_kinematics(&model, q, &mut bodies).expect("its joints");
        frame_placement(tip, &bodies).expect("its body").translation
    };
    let at = Placement::new(Matrix3::identity(), place(&between));
    let rows = FrameRows::new(tip, Frame::new("place", None, at)).at_origin();
    let through = |lands| Waypoint {
        constraints: vec![AnyConstraint::Frame(rows.clone())],
        share: Some(0.5),
        lands,
        ..Waypoint::new(between.to_vec())
    };
    let speeds = [false, true].map(|lands| {
        let settings = DirectSettings { waypoints: vec![through(lands)], ..DirectSettings::constrained() };
        let solution = solved(&problem, &settings);
        assert!(solution.converged, "{:e}", solution.gradient_norm);
        assert_eq!(solution.waypoint_times, [0.75]);
        let (x, _) = solution.curve.at(0.75);
        let (q, v) = x.as_slice().split_at(3);
        assert!((place(q) - at.translation).norm() < 1e-6);
        let later = |by: f64| place(&[0, 1, 2].map(|i| q[i] + by * v[i]));
        assert!(v.iter().any(|v| v.abs() > 0.1), "{v:?}");
        (later(1e-5) - later(-1e-5)).norm() / 2e-5
    });
    assert!(speeds[0] > 0.1 && speeds[1] < 1e-5, "{speeds:?}");
}

/// The order is kept: through one point, another, and the first one again, within limits of the joints.
#[test]
fn the_order_is_kept() {
    let model = robot("pendulum_3");
    let rest = vec![0.0; 6];
    let problem = Problem::new(&model, rest.clone(), rest, 3.0).expect("valid");
    let [a, b] = [vec![0.5, -0.4, 0.2], vec![-0.5, 0.3, 0.6]];
    let waypoints: Vec<_> = [&a, &b, &a].map(|q| Waypoint::new(q.clone())).to_vec();
    let bounds = (0..3).map(|i| Bound { entry: 3 + i, side: Side::Upper, value: 2.5 });
    let constraints = Constraints {
        state: Bounds(bounds.collect()),
        torque: TorqueLimits(Vec::new()),
        stage: StageConstraints::NONE,
    };
    let settings = DirectSettings { segments: 4, ..through(waypoints.clone()) };
    let solution = solved_within(&problem, &settings, &constraints);
    assert_passes(&solution, &waypoints);
}

/// Waypoints that cannot be meant are refused with their number.
#[test]
fn refuses_what_cannot_be() {
    let model = masses();
    let problem = Problem::new(&model, vec![0.0; 4], vec![2.0, 0.0, 0.0, 0.0], 2.0).expect("valid");
    let with = |waypoints| Direct::new(&problem).settings(through(waypoints)).solve();
    let point = Waypoint::new(vec![1.0, 0.0]);
    let timed = |share| Waypoint { share: Some(share), ..point.clone() };
    let several = Waypoint { guesses: vec![vec![0.0; 2]; 2], ..point.clone() };
    assert_refused(with(vec![Waypoint::new(vec![1.0])]), "waypoint");
    assert_refused(
        with(vec![point.clone(), Waypoint::new(vec![f64::NAN, 0.0])]),
        "waypoints[1]: a number is not finite",
    );
    assert_refused(with(vec![several]), "waypoints[0]: it has several");
    assert_refused(with(vec![timed(0.5), timed(0.25)]), "waypoints[1]: it has the share 0.25 of the horizon");
    assert_refused(with(vec![timed(1.0)]), "less than 1 is needed");
    assert_refused(with(vec![point.clone(); 40]), "they fix 40 positions");
}
