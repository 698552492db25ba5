//! Curves along paths.

use crate::{across, outside, point};
use aghf::constraint::{AnyConstraint, Evaluator};
use aghf::curve::{Basis, Continuity, Curve};
use aghf::motion::Problem;
use aghf::plan::{PlanSettings, curve_along};

/// A path around two corners.
fn detour() -> Vec<Vec<f64>> {
    [[0.0, 0.0], [0.3, 0.6], [0.7, 0.6], [1.0, 0.0]].map(|q| q.to_vec()).to_vec()
}

fn along(problem: &Problem<'_>, state: &[AnyConstraint], basis: Basis) -> Curve {
    let settings = PlanSettings::default();
    curve_along(problem, state, &detour(), basis, &settings).expect("valid")
}

/// Value and slope at the ends are those of the problem, for the slope of the curve as well as for its stored velocity.
/// The velocity is continuous between segments.
#[test]
fn the_ends_are_those_of_the_problem() {
    let model = point();
    let (start, goal) = (vec![0.0, 0.0, 0.5, -1.0], vec![1.0, 0.0, -2.0, 0.25]);
    let problem = Problem::new(&model, start.clone(), goal.clone(), 2.0).expect("valid");
    for (segments, degree) in [(3, 5), (3, 8), (8, 5)] {
        let curve = along(&problem, &[], Basis::new(segments, degree, Continuity::default()));
        for (time, state) in [(0.0, &start), (2.0, &goal)] {
            let (x, xdot) = curve.at(time);
            assert_close!(x.as_slice(), &state[..], 1e-12);
            assert_close!(xdot.rows(0, 2).as_slice(), &state[2..], 1e-9);
        }
        for e in 1..segments {
            let (before, after) = (curve.segment_rates(e - 1), curve.segment_rates(e));
            let last = before.column(before.ncols() - 1);
            assert_close!(last.rows(0, 2).as_slice(), after.column(0).rows(0, 2).as_slice(), 1e-9);
        }
    }
}

/// The curve passes every waypoint, with the slope between its neighbours, and points that divide the longest lines.
#[test]
fn it_goes_through_the_waypoints() {
    let model = point();
    let problem = across(&model);
    let horizon = problem.horizon();
    let three = along(&problem, &[], Basis::new(3, 6, Continuity::default()));
    for (k, waypoint) in detour().iter().enumerate() {
        let (x, _) = three.at(horizon * k as f64 / 3.0);
        assert_close!(&x.as_slice()[..2], &waypoint[..], 1e-12);
    }
    let (x, _) = three.at(horizon / 3.0);
    assert_close!(&x.as_slice()[2..], &[1.05 / horizon, 0.9 / horizon], 1e-9);
    // The two long lines of 0.67 are divided, the line of 0.4 is not.
    let five = along(&problem, &[], Basis::new(5, 6, Continuity::default()));
    let places = [[0.15, 0.3], [0.3, 0.6], [0.7, 0.6], [0.85, 0.3]];
    for (k, place) in places.iter().enumerate() {
        let (x, _) = five.at(horizon * (k + 1) as f64 / 5.0);
        assert_close!(&x.as_slice()[..2], place, 1e-12);
    }
}

/// The slope beside a corner is reduced if a smooth curve would collide there, to zero if necessary, where the curve is
/// the path.
#[test]
fn slopes_are_as_large_as_is_free() {
    let model = point();
    let problem = across(&model);
    let height = |curve: &Curve| {
        let times = (0..=400).map(|k| curve.horizon() * f64::from(k) / 400.0);
        times.map(|t| curve.at(t).0[1]).fold(0.0, f64::max)
    };
    let basis = || Basis::new(3, 6, Continuity::default());
    let wide = along(&problem, &[], basis());
    assert!(height(&wide) > 0.64, "{}", height(&wide));
    // A ball 12 mm above the line between the corners, then one at nearly the margin of the planner, which is 5 mm.
    for (gap, least) in [(0.012, 0.001), (0.0051, 0.0)] {
        let above = outside([[0.5, 0.6 + 0.1 + gap]], 0.1);
        let curve = along(&problem, &above, basis());
        let height = height(&curve) - 0.6;
        assert!((least..gap).contains(&height.max(0.0)), "{gap}: {height}");
        let mut evaluator = Evaluator::new(&model);
        for k in 0..=400 {
            let (x, _) = curve.at(curve.horizon() * f64::from(k) / 400.0);
            let mut g = [0.0];
            let placed = evaluator.at(x.as_slice()).expect("sizes agree");
            placed.value(&above[..], &mut g).expect("sizes agree");
            assert!(g[0] < 0.0, "{gap}: {g:?} at {k}");
        }
    }
}

#[test]
fn a_path_that_does_not_fit_is_refused() {
    let model = point();
    let problem = across(&model);
    let settings = PlanSettings::default();
    let refused = |path: &[Vec<f64>]| {
        let basis = Basis::new(2, 6, Continuity::default());
        let none: &[AnyConstraint] = &[];
        curve_along(&problem, none, path, basis, &settings).map(|_| ())
    };
    for (path, why) in [
        (vec![], "at least 2"),
        (vec![vec![0.0; 2]], "at least 2"),
        (vec![vec![0.0; 3]; 2], "waypoint"),
        (detour(), "3 lines between them and 2 segments"),
    ] {
        let error = refused(&path).expect_err("does not fit").to_string();
        assert!(error.contains(why), "{error}");
    }
    assert!(refused(&detour()[1..]).is_ok());
}
