//! Curves through paths.

use crate::{across, point};
use aghf::curve::Basis;
use aghf::motion::Problem;
use aghf::plan::curve_through;

/// Around two corners.
fn detour() -> Vec<Vec<f64>> {
    [[0.0, 0.0], [0.3, 0.6], [0.7, 0.6], [1.0, 0.0]]
        .map(|q| q.to_vec())
        .to_vec()
}

/// Value and slope at the ends are those of the problem, also where the path goes elsewhere: the slope is that of the curve, not only
/// the velocity that is written beside.
#[test]
fn the_ends_are_those_of_the_problem() {
    let model = point();
    let (start, goal) = (vec![0.0, 0.1, 0.5, -1.0], vec![1.0, 0.2, -2.0, 0.25]);
    let problem = Problem::new(&model, start.clone(), goal.clone(), 2.0).expect("valid");
    for (segments, degree) in [(1, 5), (1, 9), (1, 16), (4, 5), (3, 8)] {
        let basis = Basis::new(segments, degree, false);
        let curve = curve_through(&problem, &detour(), basis).expect("valid");
        for (time, state) in [(0.0, &start), (2.0, &goal)] {
            let (x, xdot) = curve.at(time);
            assert_close!(x.as_slice(), &state[..], 1e-12);
            assert_close!(xdot.rows(0, 2).as_slice(), &state[2..], 1e-9);
        }
    }
    // A free velocity at the end is not that of the goal.
    let free = curve_through(&problem, &detour(), Basis::new(1, 9, true)).expect("valid");
    let (x, xdot) = free.at(2.0);
    assert_close!(x.rows(0, 2).as_slice(), &goal[..2], 1e-12);
    assert!((xdot[0] - goal[2]).abs() > 0.1);
}

/// The more functions the nearer, and a line is the cubic from rest to rest.
#[test]
fn it_is_near_the_path() {
    let model = point();
    let problem = across(&model);
    let line = [vec![0.0, 0.0], vec![1.0, 0.0]];
    let curve = curve_through(&problem, &line, Basis::new(1, 9, false)).expect("valid");
    for k in 0..=20 {
        let t = f64::from(k) / 20.0;
        let (x, _) = curve.at(t);
        assert!((x[0] - t * t * (3.0 - 2.0 * t)).abs() < 1e-6 && x[1].abs() < 1e-9);
    }
    // At half time it is in the middle of the path; at a corner it is rounder the fewer functions there are.
    let farthest = |basis| {
        let curve = curve_through(&problem, &detour(), basis).expect("valid");
        let heights = (0..=200).map(|k| {
            let (x, _) = curve.at(f64::from(k) / 200.0);
            let (from_end, y) = (x[0].min(1.0 - x[0]), x[1]);
            (y - (2.0 * from_end).min(0.6)).abs()
        });
        heights.fold(0.0, f64::max)
    };
    let apart = [9, 16, 32].map(|degree| farthest(Basis::new(1, degree, false)));
    assert!(apart.is_sorted_by(|a, b| a > b), "{apart:?}");
    assert!(apart[0] < 0.1 && apart[2] < 0.03, "{apart:?}");
}

#[test]
fn a_path_of_another_robot_is_refused() {
    let model = point();
    let problem = across(&model);
    let basis = || Basis::new(1, 9, false);
    assert!(curve_through(&problem, &[], basis()).is_err());
    assert!(curve_through(&problem, &[vec![0.0; 3]], basis()).is_err());
    assert!(curve_through(&problem, &[vec![0.0; 2]], basis()).is_ok());
}
