//! Parts of a motion with lengths of their own.

use crate::common::direct::{solved, solved_within};
use crate::common::{assert_refused, point_mass, tree};
use aghf::constraint::{Bound, Bounds, Constraints, Side, StageConstraints, TorqueLimits};
use aghf::direct::{Direct, DirectSettings, DirectSolution, FreeHorizon, Waypoint};
use aghf::flow::effort_of;
use aghf::model::Model;
use aghf::motion::{Problem, largest_torques, sample};
use nalgebra::Vector3;

fn mass() -> Model {
    point_mass(&[Vector3::x()])
}

/// A motion from rest to rest in two parts, which meet at `q`.
fn through(q: &[f64], bounds: [[f64; 2]; 2], weight: f64) -> DirectSettings {
    DirectSettings {
        waypoints: vec![Waypoint { share: Some(0.5), ..Waypoint::new(q.to_vec()) }],
        degree: 6,
        segments: 2,
        starts: 1,
        parts: bounds.to_vec(),
        free_horizon: Some(FreeHorizon { shortest: 0.1, longest: 20.0, weight }),
        ..DirectSettings::constrained()
    }
}

/// The same with lengths that are as near as they may be to those of equal parts.
fn fixed(settings: DirectSettings) -> DirectSettings {
    DirectSettings { free_horizon: None, ..settings }
}

fn problem(model: &Model) -> Problem<'_> {
    Problem::new(model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid")
}

fn lengths(solution: &DirectSolution) -> [f64; 2] {
    let [begin, middle, end] = solution.curve.breakpoints() else {
        panic!("two segments");
    };
    [middle - begin, end - middle]
}

/// The effort of a mass in least time over a point between rests: two cubics with a free velocity `v` where they meet,
/// of effort $4 (3 d^2 / T^3 - 3 d v / T^2 + v^2 / T)$ each.
fn effort(lengths: [f64; 2], [first, second]: [f64; 2]) -> f64 {
    let [t, s] = lengths;
    let best = 1.5 * (first / (t * t) + second / (s * s)) / (1.0 / t + 1.0 / s);
    let cubic = |d: f64, t: f64| 4.0 * (3.0 * d * d / t - 3.0 * d * best + best * best * t) / (t * t);
    cubic(first, t) + cubic(second, s)
}

/// Lengths that cannot change give the effort of two cubics.
#[test]
fn given_lengths_are_kept() {
    let (model, far) = (mass(), 0.3);
    let expected = effort([0.4, 0.9], [far, 1.0 - far]);
    for settings in [through(&[far], [[0.4; 2], [0.9; 2]], 0.0), fixed(through(&[far], [[0.1, 0.4], [0.9, 7.0]], 0.0))]
    {
        let solution = solved(&problem(&model), &settings);
        assert!(solution.converged);
        let [first, second] = lengths(&solution);
        assert!((first - 0.4).abs() + (second - 0.9).abs() < 1e-12);
        assert!((solution.cost / expected - 1.0).abs() < 1e-6, "{} {expected}", solution.cost);
        let again = effort_of(&model, &solution.curve, 1.0).expect("its joints");
        assert!((again.control_effort / solution.cost - 1.0).abs() < 1e-9);
    }
}

/// With free lengths cost and weight of time are at a minimum: that of the cubics over both lengths.
#[test]
fn free_lengths_are_the_best_ones() {
    let (model, far, weight) = (mass(), 0.2, 30.0);
    let settings = through(&[far], [[0.1, 5.0]; 2], weight);
    let solution = solved(&problem(&model), &settings);
    assert!(solution.converged);
    let all = |lengths: [f64; 2]| effort(lengths, [far, 1.0 - far]) + weight * (lengths[0] + lengths[1]);
    let own = lengths(&solution);
    let found = solution.cost + weight * solution.curve.horizon();
    assert!((found / all(own) - 1.0).abs() < 1e-6);
    for change in [[1e-3, 0.0], [-1e-3, 0.0], [0.0, 1e-3], [0.0, -1e-3], [1e-3, -1e-3]] {
        let moved = [own[0] + change[0], own[1] + change[1]];
        assert!(all(moved) > all(own), "{own:?} {change:?}");
    }
    assert!((own[0] - own[1]).abs() > 0.1, "{own:?}");
    // Newton's method: the last steps are quadratic.
    assert!(solution.iterations.len() < 60, "{}", solution.iterations.len());
}

/// A length is at its bound where it would rather be shorter, and the other one as good as can be.
#[test]
fn bounds_of_lengths_are_kept() {
    let (model, far, weight) = (mass(), 0.2, 30.0);
    let settings = through(&[far], [[0.7, 2.0], [0.1, 5.0]], weight);
    let solution = solved(&problem(&model), &settings);
    assert!(solution.converged);
    let own = lengths(&solution);
    assert!((own[0] - 0.7).abs() < 1e-5, "{own:?}");
    let all = |second: f64| effort([0.7, second], [far, 1.0 - far]) + weight * second;
    assert!(all(own[1]) <= all(own[1] + 1e-3) && all(own[1]) <= all(own[1] - 1e-3));
}

/// The whole has bounds of its own: at its bound one part gains where the other loses.
#[test]
fn the_sum_of_lengths_has_bounds() {
    let (model, far) = (mass(), 0.2);
    for (bound, weight) in [([1.6, 20.0], 30.0), ([0.1, 1.1], 1.0)] {
        let mut settings = through(&[far], [[0.1, 5.0]; 2], weight);
        let [shortest, longest] = bound;
        settings.free_horizon = Some(FreeHorizon { shortest, longest, weight });
        let problem = problem(&model).with_horizon(bound[0].max(1.0)).expect("positive");
        let solution = solved(&problem, &settings);
        assert!(solution.converged, "{bound:?}");
        let own = lengths(&solution);
        let whole = own[0] + own[1];
        assert!((whole - shortest).abs().min((whole - longest).abs()) < 1e-5, "{own:?}");
        let all = |first: f64| effort([first, whole - first], [far, 1.0 - far]);
        assert!(all(own[0]) < all(own[0] + 1e-3) && all(own[0]) < all(own[0] - 1e-3));
    }
}

/// A search goes on from a motion in parts: from the best one it ends there at once, also in more segments.
#[test]
fn a_motion_in_parts_is_a_start() {
    let (model, problem) = (mass(), problem(&mass()).goal().to_vec());
    let problem = Problem::new(&model, vec![0.0; 2], problem, 1.0).expect("valid");
    let settings = through(&[0.2], [[0.1, 5.0]; 2], 30.0);
    let first = solved(&problem, &settings);
    for segments in [2, 4] {
        let again = DirectSettings { start: Some(first.curve.clone()), segments, ..settings.clone() };
        let again = solved(&problem, &again);
        assert!(again.converged);
        assert!((again.first_guess.horizon() - first.curve.horizon()).abs() < 1e-12);
        for time in [0.1, 0.4, 0.7] {
            let [a, b] = [&again.first_guess, &first.curve].map(|curve| curve.at(time).0);
            assert!((a - b).amax() < 1e-9, "{segments} {time}");
        }
        assert!((again.cost / first.cost - 1.0).abs() < 1e-6);
        let slower = first.curve.stretched(2.0 * first.curve.horizon()).expect("positive");
        let [a, b] = [slower.at(0.5).0, first.curve.at(0.25).0];
        assert!((a[0] - b[0]).abs() + (2.0 * a[1] - b[1]).abs() < 1e-12);
    }
}

/// A robot whose joints depend on each other, with limits and a velocity at the start, at several degrees.
#[test]
fn robots_have_parts_too() {
    let model = tree(3, 4);
    let (start, goal) = (vec![0.1, -0.2, 0.3, 0.4, 0.0, -0.3], vec![0.8, 0.5, -0.4, 0.0, 0.0, 0.0]);
    let problem = Problem::new(&model, start, goal, 1.0).expect("valid");
    let settings = |bounds: [[f64; 2]; 2]| DirectSettings { segments: 4, ..through(&[0.4, 0.3, 0.2], bounds, 5.0) };
    let free = solved(&problem, &settings([[0.2, 3.0]; 2]));
    assert!(free.converged);
    let breakpoints = free.curve.breakpoints();
    let own = [breakpoints[2], breakpoints[4] - breakpoints[2]];
    let all = |of: &DirectSolution| of.cost + 5.0 * of.curve.horizon();
    for change in [[1.02, 1.0], [1.0, 1.02], [0.98, 1.0], [1.0, 0.98]] {
        let fixed = [0, 1].map(|k| [own[k] * change[k]; 2]);
        let fixed = solved(&problem, &settings(fixed));
        assert!(fixed.converged && all(&fixed) > all(&free), "{change:?}");
    }
    let again = effort_of(&model, &free.curve, 1.0).expect("its joints");
    assert!((again.control_effort / free.cost - 1.0).abs() < 1e-6);
    let largest = largest_torques(&model, &free.curve, 50).expect("its joints");
    let samples = sample(&model, &free.curve, 4000).expect("its joints");
    for (joint, largest) in largest.iter().enumerate() {
        let dense = samples.iter().fold(0.0, |most: f64, at| most.max(at.u[joint].abs()));
        // At a breakpoint samples are those of the later segment.
        let ratio = largest / dense;
        assert!((1.0 - 1e-6..1.001).contains(&ratio), "{joint}: {ratio}");
    }
    let (state, _) = free.curve.at(0.0);
    assert!((state[3] - 0.4).abs() + (state[5] + 0.3).abs() < 1e-12);
}

#[test]
fn parts_that_cannot_be_meant_are_refused() {
    let model = mass();
    let problem = problem(&model);
    let good = || through(&[0.2], [[0.1, 5.0]; 2], 1.0);
    let bounds = |parts: &[[f64; 2]]| DirectSettings { parts: parts.to_vec(), ..good() };
    for (settings, words) in [
        (bounds(&[[0.1, 1.0]; 3]), "parts: there are 3 for 2 segments"),
        (bounds(&[[0.1, 1.0]]), "parts: there are 1 for 2 segments"),
        (bounds(&[[0.1, 1.0], [2.0, 1.0]]), "parts[1]: the shortest length 2 is above the longest one 1"),
        (bounds(&[[0.0, 1.0]; 2]), "parts[0]: it is 0"),
        (DirectSettings { continuous_acceleration: true, ..good() }, "parts: accelerations jump"),
        (
            DirectSettings { waypoints: vec![Waypoint::new(vec![0.2])], ..good() },
            "parts: a waypoint has an unknown time",
        ),
    ] {
        assert_refused(Direct::new(&problem).settings(settings).solve(), words);
    }
}

/// Limits of velocity, which are rows at the points of both parts: the long one is as fast as it may be, and the search
/// converges as where lengths are alike.
#[test]
fn limits_are_kept_in_parts() {
    let model = mass();
    let limits = |side, value| Bound { entry: 1, side, value };
    let constraints = Constraints {
        state: Bounds(vec![limits(Side::Upper, 0.5), limits(Side::Lower, -0.5)]),
        torque: TorqueLimits(Vec::new()),
        stage: StageConstraints::NONE,
    };
    let problem = Problem::new(&model, vec![0.0; 2], vec![3.0, 0.0], 6.0).expect("valid");
    let settings = DirectSettings { segments: 4, ..through(&[0.1], [[0.2, 20.0]; 2], 3.0) };
    let found = solved_within(&problem, &settings, &constraints);
    assert!(found.converged, "{}", found.gradient_norm);
    let breakpoints = found.curve.breakpoints();
    let [first, second] = [breakpoints[2], breakpoints[4] - breakpoints[2]];
    assert!(second > 5.0 * first, "{first} {second}");
    let fastest = sample(&model, &found.curve, 1000).expect("its joint");
    let fastest = fastest.iter().map(|at| at.v[0]).fold(0.0, f64::max);
    assert!((fastest - 0.5).abs() < 1e-5, "{fastest}");
    assert!(found.iterations.len() < 90, "{}", found.iterations.len());
}
