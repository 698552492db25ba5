//! Periodic motions.

use crate::common::direct::solved;
use crate::common::{assert_refused, point_mass, robot};
use aghf::direct::{Direct, DirectSettings, DirectSolution, FreeHorizon, Period, Waypoint};
use aghf::model::Model;
use aghf::motion::Problem;
use nalgebra::Vector3;

fn masses() -> Model {
    point_mass(&[Vector3::x(), Vector3::y()])
}

/// A waypoint halfway.
fn halfway(q: &[f64]) -> Waypoint {
    Waypoint { share: Some(0.5), ..Waypoint::new(q.to_vec()) }
}

/// Two segments that meet at the waypoint, and the relation between the ends.
fn periodic(joints: &[usize], signs: &[f64], q: &[f64]) -> DirectSettings {
    DirectSettings {
        waypoints: vec![halfway(q)],
        period: Some(Period { joints: joints.to_vec(), signs: signs.to_vec() }),
        degree: 6,
        segments: 2,
        starts: 1,
        ..DirectSettings::constrained()
    }
}

/// The states at both ends.
fn ends(solution: &DirectSolution) -> [Vec<f64>; 2] {
    let curve = &solution.curve;
    [0.0, curve.horizon()].map(|time| curve.at(time).0.as_slice().to_vec())
}

fn assert_close(a: &[f64], b: &[f64], within: f64) {
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= within, "{a} and {b}");
    }
}

/// A mass that swings from side to side is at rest at `q` halfway and passes zero at both ends: with $s = t - T$ the
/// cubic $c (s^3 / 3 - T^2 s / 4)$ with $c = 12 q / T^3$, whose effort is $48 m^2 q^2 / T^3$.
#[test]
fn a_swing_of_a_mass_is_a_cubic() {
    let model = masses();
    let horizon = 1.5;
    let problem = Problem::new(&model, vec![0.1, 0.2, 0.3, 0.4], vec![0.0; 4], horizon).expect("valid");
    let q = [1.0, -0.5];
    let solution = solved(&problem, &periodic(&[0, 1], &[-1.0; 2], &q));
    assert!(solution.converged);
    let effort = |mass: f64| 48.0 * mass * mass * 1.25 / horizon.powi(3);
    let mass = (solution.cost / effort(1.0)).sqrt();
    let [start, end] = ends(&solution);
    assert_close(&start, &[0.0, 0.0, 3.0 / horizon, -1.5 / horizon], 1e-6);
    assert_close(&end, &start.iter().map(|x| -x).collect::<Vec<_>>(), 1e-12);
    // The mass of the model by a motion between rests, of effort 12 m^2 d^2 / T^3.
    let rest = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.0, 0.0, 0.0], 1.0).expect("valid");
    let expected = (solved(&rest, &DirectSettings::constrained()).cost / 12.0).sqrt();
    assert!((mass / expected - 1.0).abs() < 1e-7, "{mass} and {expected}");
}

/// The weight `w` of time is that of the horizon at which $w T = 3 \cdot 48 m^2 q^2 / T^3$.
#[test]
fn the_horizon_of_a_swing_may_be_free() {
    let model = masses();
    let problem = Problem::new(&model, vec![0.0; 4], vec![0.0; 4], 1.0).expect("valid");
    let settings = periodic(&[0, 1], &[-1.0; 2], &[1.0, 0.0]);
    let density = solved(&problem, &settings).cost;
    let free = DirectSettings {
        free_horizon: Some(FreeHorizon { shortest: 0.2, longest: 10.0, weight: 3.0 * density / 16.0 }),
        ..settings
    };
    let solution = solved(&problem, &free);
    assert!(solution.converged);
    assert!((solution.curve.horizon() - 2.0).abs() < 1e-5);
}

/// Two masses that change places are half of a motion of twice the time in which each comes back.
#[test]
fn half_of_a_motion_with_exchanged_joints_is_half_of_the_whole() {
    let model = masses();
    let problem = |horizon| Problem::new(&model, vec![0.0; 4], vec![0.0; 4], horizon).expect("valid");
    let half = solved(&problem(1.0), &periodic(&[1, 0], &[1.0; 2], &[1.0, 0.2]));
    let whole = DirectSettings {
        waypoints: vec![
            Waypoint { share: Some(0.25), ..Waypoint::new(vec![1.0, 0.2]) },
            Waypoint { share: Some(0.75), ..Waypoint::new(vec![0.2, 1.0]) },
        ],
        segments: 4,
        ..periodic(&[0, 1], &[1.0; 2], &[0.0; 2])
    };
    let whole = solved(&problem(2.0), &whole);
    assert!(half.converged && whole.converged);
    // Waypoints are kept to 1e-6.
    assert!((whole.cost / half.cost - 2.0).abs() < 1e-5);
    let [start, end] = ends(&half);
    let exchanged = [start[1], start[0], start[3], start[2]];
    assert_close(&end, &exchanged, 1e-12);
    assert_close(&ends(&whole)[0], &start, 1e-5);
}

/// The ends of a swing of two pendulums are the best ones: with the ends given the motion costs the same, and with
/// others that are as near on either side it costs more.
#[test]
fn no_other_ends_of_a_swing_cost_less() {
    let model = robot("pendulum_2");
    let settings = periodic(&[0, 1], &[-1.0; 2], &[0.8, 0.3]);
    let guess = Problem::new(&model, vec![0.0; 4], vec![0.0; 4], 1.0).expect("valid");
    let best = solved(&guess, &settings);
    assert!(best.converged && best.smallest_curvature > 0.0);
    let between = |start: &[f64]| {
        let end = start.iter().map(|x| -x).collect();
        let problem = Problem::new(&model, start.to_vec(), end, 1.0).expect("valid");
        let fixed = DirectSettings { period: None, ..settings.clone() };
        let found = solved(&problem, &fixed);
        assert!(found.converged);
        found.cost / best.cost - 1.0
    };
    let [start, _] = ends(&best);
    // The waypoint is kept to 1e-6.
    assert!(between(&start).abs() < 1e-5);
    for entry in 0..start.len() {
        let [less, more] = [-1e-2, 1e-2].map(|by| {
            let mut other = start.clone();
            other[entry] += by;
            between(&other)
        });
        assert!(less > 0.0 && more > 0.0, "{less:e} {more:e}");
        // A slope would be seen in the difference.
        assert!((more - less).abs() < 0.2 * (more + less), "{less:e} {more:e}");
    }
}

#[test]
fn relations_that_are_none_are_refused() {
    let model = masses();
    let problem = Problem::new(&model, vec![0.0; 4], vec![0.0; 4], 1.0).expect("valid");
    let refused = |settings: DirectSettings, words: &str| {
        let found = Direct::new(&problem).settings(settings).solve();
        assert_refused(found, words);
    };
    let q = [1.0, 0.0];
    refused(periodic(&[0, 0], &[1.0; 2], &q), "not a permutation");
    refused(periodic(&[0], &[1.0; 2], &q), "joints of the period");
    refused(periodic(&[0, 1], &[1.0, 0.5], &q), "neither 1 nor -1");
    let free = DirectSettings { free_final_velocity: true, ..periodic(&[0, 1], &[1.0; 2], &q) };
    refused(free, "the end follows from the start");
    let smooth = DirectSettings { continuous_acceleration: true, ..periodic(&[0, 1], &[1.0; 2], &q) };
    refused(smooth, "accelerations jump");
    let at_the_end = |period| DirectSettings {
        waypoints: vec![Waypoint { share: Some(1.0), ..Waypoint::new(vec![0.0; 2]) }],
        period,
        ..periodic(&[0, 1], &[1.0; 2], &q)
    };
    refused(at_the_end(None), "more than 0 and less than 1");
}
