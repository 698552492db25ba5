//! The direct method within constraints: optima that are known, and what it says where there is none.

use crate::common::direct::solved_within;
use crate::common::{assert_refused, direct, point_mass, slider};
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, CollisionSphere, Constraints, Side, Sphere, SphereClearance, TorqueLimits,
};
use aghf::cost::{CostThroughDynamics, HyperDual64};
use aghf::direct::{Direct, DirectSettings, DirectSolution, Multipliers};
use aghf::motion::{Problem, sample};
use nalgebra::Vector3;

type Kept = Constraints<Vec<AnyConstraint>>;

fn state(constraint: AnyConstraint) -> Kept {
    Constraints { state: vec![constraint], torque: TorqueLimits(Vec::new()), stage: Default::default() }
}

fn solved(problem: &Problem<'_>, kept: &Kept) -> DirectSolution {
    solved_within(problem, &DirectSettings::constrained(), kept)
}

/// A point that has to go around a ball of this radius.
fn around_a_ball(radius: f64, degree: usize) -> DirectSolution {
    let settings = DirectSettings { degree, ..DirectSettings::constrained() };
    around_a_ball_to(1.0, radius, &settings)
}

/// The same to another goal on the line, with these settings.
fn around_a_ball_to(goal: f64, radius: f64, settings: &DirectSettings) -> DirectSolution {
    let model = point_mass(&[Vector3::x(), Vector3::y()]);
    let start = vec![0.0, 0.0, 0.0, 0.0];
    let problem = Problem::new(&model, start, vec![goal, 0.0, 0.0, 0.0], 1.0).expect("valid");
    let ball = CollisionSphere { body: Some(1), centre: Vector3::zeros(), radius: 0.0 };
    let centre = Vector3::new(0.5, 0.05, 0.0);
    let kept =
        state(AnyConstraint::Spheres(SphereClearance { balls: vec![ball], spheres: vec![Sphere { centre, radius }] }));
    solved_within(&problem, settings, &kept)
}

/// To a goal that has moved a search takes a few iterations with the multipliers of the last one, and ends as it does
/// without.
#[test]
fn a_search_begins_with_known_multipliers() {
    let settings = DirectSettings { degree: 12, ..DirectSettings::constrained() };
    let first = around_a_ball_to(1.0, 0.2, &settings);
    let cold = around_a_ball_to(1.02, 0.2, &settings);
    let known = &first.multipliers;
    let (times, rows) = (known.times().to_vec(), known.rows());
    let same = Multipliers::of_entries(times, rows, &known.entries(0.0), known.of_points().to_vec());
    let same = same.expect("they fit");
    assert_eq!(same, *known);
    let halved = known.scaled(0.5).scaled(2.0);
    assert_eq!(halved, *known);
    assert_eq!(known.scaled(2.0).entries(0.0)[0].2, 2.0 * known.entries(0.0)[0].2);
    let warm = DirectSettings { start: Some(first.curve.clone()), multipliers: Some(same), ..settings.clone() };
    let warm = around_a_ball_to(1.02, 0.2, &warm);
    assert!(cold.converged && warm.converged);
    assert!(
        // The margins between the points are not those of the other search.
        (warm.cost - cold.cost).abs() < 2e-3 * cold.cost,
        "{} {}",
        warm.cost,
        cold.cost
    );
    let [few, many] = [&warm, &cold].map(|of| of.iterations.len());
    assert!(3 * few < 2 * many, "{few} {many}");
}

#[test]
fn multipliers_that_do_not_fit_are_refused() {
    let bad = |times: &[f64], entry| {
        let all = Multipliers::of_entries(times.to_vec(), 3, &[entry], Vec::new());
        assert_refused(all, "multipliers");
    };
    bad(&[0.0, 1.0], (2, 0, 1.0));
    bad(&[0.0, 1.0], (0, 3, 1.0));
    bad(&[0.0, 1.0], (0, 0, f64::NAN));
    bad(&[1.0, 0.0], (0, 0, 1.0));
    let model = point_mass(&[Vector3::x(), Vector3::y()]);
    let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.0, 0.0, 0.0], 1.0).expect("valid");
    let known = Multipliers::of_entries(vec![0.0, 1.0], 3, &[(0, 0, 1.0)], Vec::new());
    let settings = DirectSettings { multipliers: known.ok(), ..DirectSettings::default() };
    let solve = |settings| Direct::new(&problem).settings(settings).solve();
    assert_refused(solve(settings.clone()), "without a start");
    let free = solve(DirectSettings::default()).expect("it is free");
    let start = Some(free.curve);
    assert_refused(solve(DirectSettings { start, ..settings }), "3 rows, there are 0");
}

/// A cost that is more than there are numbers for ends as a search that failed.
#[test]
fn rows_that_overflow_are_a_failure() {
    let model = point_mass(&[Vector3::x(), Vector3::y()]);
    let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.0, 0.0, 0.0], 1.0).expect("valid");
    let ball = CollisionSphere { body: Some(1), centre: Vector3::zeros(), radius: 0.0 };
    for (centre, radius) in [(1e300, 1e300), (0.0, 1e300)] {
        let centre = Vector3::new(centre, 0.0, 0.0);
        let kept = state(AnyConstraint::Spheres(SphereClearance {
            balls: vec![ball],
            spheres: vec![Sphere { centre, radius }],
        }));
        let direct = Direct::new(&problem).constraints(&kept);
        let solution = direct.settings(DirectSettings::constrained()).solve();
        assert!(!solution.is_ok_and(|s| s.converged), "{centre} {radius}");
    }
}

/// A touch in a point takes a multiplier that is all at one time, far above the first penalty of a violation, and more
/// so the more points there are. A polynomial of a lower degree is one of a higher.
#[test]
fn a_touch_in_a_point_is_worth_its_price_at_every_degree() {
    let found = [12, 16, 20, 24].map(|degree| around_a_ball(0.2, degree));
    for solution in &found {
        assert!(solution.converged && solution.largest_violation <= 1e-6);
    }
    let costs = found.map(|solution| solution.cost);
    // What the margins of the lower degree cost is more than what those of the higher do.
    assert!(costs.is_sorted_by(|a, b| a > b), "{costs:?}");
    assert!(costs[3] > 0.999 * costs[0], "{costs:?}");
}

/// A point that has to go around a ball: it touches it, pays for that, and a multiplier pulls nowhere else.
#[test]
fn a_point_goes_around_a_ball() {
    let model = point_mass(&[Vector3::x(), Vector3::y()]);
    let start = vec![0.0, 0.0, 0.0, 0.0];
    let problem = Problem::new(&model, start, vec![1.0, 0.0, 0.0, 0.0], 1.0).expect("valid");
    let (centre, radius) = (Vector3::new(0.5, 0.05, 0.0), 0.2);
    let ball = CollisionSphere { body: Some(1), centre: Vector3::zeros(), radius: 0.0 };
    let kept =
        state(AnyConstraint::Spheres(SphereClearance { balls: vec![ball], spheres: vec![Sphere { centre, radius }] }));
    let solution = solved(&problem, &kept);
    assert!(solution.converged && solution.smallest_curvature > 0.0);
    assert!(solution.gradient_norm <= 1e-6 && solution.largest_violation <= 1e-6);
    let samples = sample(&model, &solution.curve, 5000).expect("sizes agree");
    let distance = |q: &[f64]| (Vector3::new(q[0], q[1], 0.0) - centre).norm() - radius;
    let least = samples.iter().map(|s| distance(&s.q)).fold(f64::INFINITY, f64::min);
    assert!((-1e-6..1e-5).contains(&least), "{least}");
    // Below, where the way is shorter, and nearly symmetric: the rows pull at the points of the quadrature beside the
    // touch, here 5 mm to one side, and not where it is.
    let (middle, _) = solution.curve.at(0.5);
    assert!((middle[0] - 0.5).abs() < 1e-2 && (middle[1] + 0.15).abs() < 1e-3, "{middle} {least} {}", solution.cost);
    let free = direct::solved(&problem, &DirectSettings::default());
    assert!(solution.cost > free.cost + 0.1, "{}", solution.cost);
    let again = solved(&problem, &kept);
    assert_eq!(again.curve.x(), solution.curve.x());
}

/// The double integrator with a limit on its velocity: the velocity rises as a parabola to the limit, stays there and
/// falls. Without a limit it would reach 1.5 in the middle, and the cost would be 12.
#[test]
fn a_velocity_limit_is_kept_at_the_known_cost() {
    let model = point_mass(&[Vector3::x()]);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let limited = |value: f64| {
        let bound = Bound { entry: 1, side: Side::Upper, value };
        solved(&problem, &state(AnyConstraint::Bounds(Bounds(vec![bound]))))
    };
    let solution = limited(1.2);
    assert!(solution.converged && solution.largest_violation <= 1e-6, "{solution:?}");
    // It rises for 3 (v T - d) / 2 v, which is a quarter, and costs 8 v^2 / 3 times the inverse of that. A polynomial
    // comes near.
    let exact = 8.0 * 1.44 / 3.0 / 0.25;
    let excess = solution.cost / exact - 1.0;
    assert!((0.0..0.02).contains(&excess), "{excess}");
    // The mean has to be one.
    let impossible = limited(0.9);
    assert!(!impossible.converged && impossible.largest_violation > 0.05);
    // No limit that binds: the cubic.
    let loose = limited(1.6);
    assert!(loose.converged && (loose.cost - 12.0).abs() < 1e-9);
}

/// A goal at a limit: the row of its state is constant, so it neither prevents convergence nor raises the penalty.
#[test]
fn a_goal_at_its_limit() {
    let model = point_mass(&[Vector3::x()]);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let upper = |entry, value| Bound { entry, side: Side::Upper, value };
    let free = solved(&problem, &state(AnyConstraint::Bounds(Bounds(vec![upper(1, 1.2)]))));
    // At it, closer to it than the margin against rounding, and beyond it by less than is accepted.
    for limit in [1.0, 1.0 + 1e-7, 1.0 - 3e-7] {
        let limits = Bounds(vec![upper(0, limit), upper(1, 1.2)]);
        let at_goal = solved(&problem, &state(AnyConstraint::Bounds(limits)));
        assert!(at_goal.converged, "{at_goal:?}");
        // The margins of the speed between the points are not the same in two searches.
        let ratio = at_goal.cost / free.cost - 1.0;
        assert!((-1e-4..1e-5).contains(&ratio), "{ratio:e}");
        assert!(at_goal.largest_violation <= DirectSettings::FEASIBLE);
        let counts = [&at_goal, &free].map(|solution| solution.iterations.len());
        assert!(counts[0] <= 2 * counts[1], "{limit} {counts:?}");
    }
}

#[test]
fn a_torque_limit_is_kept() {
    let model = point_mass(&[Vector3::x()]);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let kept = Constraints { state: Vec::new(), torque: TorqueLimits(vec![Some(5.0)]), stage: Default::default() };
    let solution = solved(&problem, &kept);
    assert!(solution.converged && solution.largest_violation <= 1e-6, "{solution:?}");
    let samples = sample(&model, &solution.curve, 5000).expect("sizes agree");
    let most = samples.iter().map(|s| s.u[0].abs()).fold(0.0_f64, f64::max);
    assert!((5.0 - 1e-4..=5.0 + 1e-6).contains(&most), "{most}");
    // Without a limit the force is 6 at the ends and the cost 12.
    assert!(solution.cost > 12.0 && solution.cost < 13.0, "{}", solution.cost);
    // Four would do for the distance if it were forward for one half and backward for the other.
    let kept = Constraints { torque: TorqueLimits(vec![Some(3.9)]), ..kept };
    assert!(!solved(&problem, &kept).converged);
    let kept = Constraints { torque: TorqueLimits(vec![None; 2]), ..kept };
    let limits = Constraints { torque: TorqueLimits(vec![Some(1.0); 2]), ..kept };
    let of_another = Direct::new(&problem).constraints(&limits);
    assert_refused(of_another.solve(), "torque limits: expected 1 entries, found 2");
}

/// A motion to a limit, or from one, that would cost less beyond it keeps the limit beside its end, also where the
/// given state exceeds it by rounding, in fewer iterations than with margins of the points beside the end (73).
#[test]
fn an_end_at_its_bound_is_no_obstacle() {
    let model = slider(2.0);
    let upper = Bound { entry: 0, side: Side::Upper, value: 1.0 };
    let kept = state(AnyConstraint::Bounds(Bounds(vec![upper])));
    let cost = CostThroughDynamics::new(&model, |at| {
        let beyond = HyperDual64::from(3.0) - at.q[0];
        beyond * beyond + at.u[0] * at.u[0] * 1e-8
    });
    for excess in [0.0, 1e-7] {
        let [away, there] = [vec![0.0, 0.0], vec![1.0 + excess, 0.0]];
        for (from, to) in [(away.clone(), there.clone()), (there, away)] {
            let problem = Problem::new(&model, from, to, 2.0).expect("valid");
            let direct = Direct::new(&problem).cost(cost.clone()).constraints(&kept);
            let found = direct.settings(DirectSettings::constrained()).solve();
            let found = found.unwrap_or_else(|e| panic!("{e}"));
            let highest = (0..=20_000).map(|k| found.curve.at(1e-4 * f64::from(k)).0[0]);
            let highest = highest.fold(0.0, f64::max) - 1.0;
            assert!(highest <= DirectSettings::FEASIBLE, "{highest:e}");
            // Rows beside an end that is outside are tightened in as many rounds as there are.
            let iterations = found.iterations.len();
            assert!(found.converged && iterations < 100, "{iterations}");
        }
    }
}
