//! Objectives of the direct method besides the least effort from state to state.

use crate::common::direct::{solved, solved_within};
use crate::common::scenario::Scenario;
use crate::common::{assert_refused, slider};
use aghf::constraint::{Bound, Bounds, Constraints, Side, TorqueLimits};
use aghf::cost::{CostThroughDynamics, HyperDual64, StageInput};
use aghf::curve::Curve;
use aghf::direct::{Direct, DirectSettings, FreeHorizon};
use aghf::motion::{Feedback, Problem, simulate};

/// Any velocity at the end.
fn arriving_anyhow(p: usize) -> DirectSettings {
    DirectSettings { degree: p, free_final_velocity: true, ..Default::default() }
}

/// From rest over a distance `d` in `T`: the acceleration falls to zero at the end, $q = d (3 \tau^2 - \tau^3) / 2$,
/// and the effort is $3 m^2 d^2 / T^3$, a quarter of that from rest to rest.
#[test]
fn a_free_final_velocity_is_that_of_least_effort() {
    let (mass, horizon) = (3.0, 1.7);
    let model = slider(mass);
    let problem = Problem::new(&model, vec![0.0, 0.0], vec![1.0, -4.0], horizon).expect("valid");
    let exact = 3.0 * mass * mass / horizon.powi(3);
    let is_exact = |curve: &Curve| {
        for s in [0.0, 0.3, 0.8, 1.0_f64] {
            let (x, _) = curve.at(s * horizon);
            assert!((x[0] - s * s * (3.0 - s) / 2.0).abs() < 1e-8, "{s}: {}", x[0]);
        }
        let end = curve.x().column(curve.x().ncols() - 1);
        assert!((end[0] - 1.0).abs() < 1e-15 && (end[1] - 1.5 / horizon).abs() < 1e-8);
    };
    for p in [4, 9] {
        let solution = solved(&problem, &arriving_anyhow(p));
        assert!(solution.converged && (solution.cost - exact).abs() < 1e-12 * exact, "{solution:?}");
        is_exact(&solution.curve);
        // The test of success asks for the end of the curve, not for the velocity of the goal.
        let simulation = simulate(&model, &solution.curve, Feedback { kp: 10.0, kv: 10.0 }, &[]);
        let simulation = simulation.expect("the same robot");
        assert_eq!(simulation.failure, None);
        assert!(simulation.error_inf < 1e-6, "{simulation:?}");
    }
    // The same within a bound that does not touch it, although the velocity of the goal breaks it.
    let bound = Bound { entry: 1, side: Side::Lower, value: -0.5 };
    let kept = Constraints { state: Bounds(vec![bound]), torque: TorqueLimits(Vec::new()), stage: Default::default() };
    let settings = DirectSettings { free_final_velocity: true, ..DirectSettings::constrained() };
    let solution = solved_within(&problem, &settings, &kept);
    assert!(solution.converged, "{solution:?}");
    is_exact(&solution.curve);
    let arriving = Direct::new(&problem).constraints(&kept);
    let arriving = arriving.settings(DirectSettings::constrained()).solve();
    assert_refused(arriving, "problem: goal: it violates lower velocity limit");
}

/// A motion to a given velocity is one to any velocity.
#[test]
fn a_free_final_velocity_costs_no_more() {
    let scenario = Scenario::load("kinova_free_04");
    let problem = scenario.problem();
    let fixed = DirectSettings { degree: 9, starts: 1, ..Default::default() };
    let fixed = solved(&problem, &fixed);
    let from_there = DirectSettings { start: Some(fixed.curve.clone()), ..arriving_anyhow(9) };
    let free = solved(&problem, &from_there);
    assert!(fixed.converged && free.converged, "{free:?}");
    assert!(free.smallest_curvature > 0.0);
    assert!(free.cost < fixed.cost, "{} {}", free.cost, fixed.cost);
    // Bent starts have their bubbles and no more: all end where q is that of the goal.
    let bent = solved(&problem, &DirectSettings { starts: 4, ..arriving_anyhow(9) });
    let end = bent.curve.x().column(9);
    assert!(bent.converged && end.as_slice()[..7] == problem.goal()[..7]);
    assert_eq!(bent.curve.x().column(0).as_slice(), problem.start());
}

fn horizon(shortest: f64, longest: f64, weight: f64) -> DirectSettings {
    DirectSettings { degree: 7, free_horizon: Some(FreeHorizon { shortest, longest, weight }), ..Default::default() }
}

/// Rest to rest over `d` costs $12 m^2 d^2 / T^3 + w T$, least at $T^4 = 36 m^2 d^2 / w$; with a free final velocity a
/// quarter of the effort, $T^4 = 9 m^2 d^2 / w$.
#[test]
fn a_free_horizon_is_the_best_one() {
    let (mass, d, weight) = (2.0, 0.5, 3.0);
    let model = slider(mass);
    let problem = |t| Problem::new(&model, vec![0.0; 2], vec![d, 0.0], t).expect("valid");
    let md2 = (mass * d) * (mass * d);
    let exact = (36.0 * md2 / weight).powf(0.25);
    for begin in [0.3, exact, 1.0, 9.0] {
        let solution = solved(&problem(begin), &horizon(0.1, 10.0, weight));
        let found = solution.curve.chebyshev(0).horizon();
        // The barrier functions of the two bounds shift it by about their last parameter.
        assert!(solution.converged && (found - exact).abs() < 1e-7, "{begin}: {found} {exact}");
        assert!((solution.cost - 12.0 * md2 / found.powi(3)).abs() < 1e-10);
        let end = solution.curve.x().column(solution.curve.x().ncols() - 1);
        assert_eq!(end.as_slice(), [d, 0.0]);
    }
    let anyhow = DirectSettings { free_final_velocity: true, ..horizon(0.1, 10.0, weight) };
    let found = solved(&problem(1.0), &anyhow).curve.chebyshev(0).horizon();
    assert!((found - (9.0 * md2 / weight).powf(0.25)).abs() < 1e-7);
    // A bound holds it, less the reserve of rows, and without a weight the horizon is the longest one.
    for (shortest, longest, weight, expected) in
        [(0.1, 1.5, weight, 1.5), (3.0, 9.0, weight, 3.0), (0.1, 7.0, 0.0, 7.0)]
    {
        let begin = 0.5 * (shortest + longest);
        let solution = solved(&problem(begin), &horizon(shortest, longest, weight));
        let found = solution.curve.chebyshev(0).horizon();
        assert!(solution.converged && (found / expected - 1.0).abs() < 5e-7, "{found} {expected}");
        assert!((shortest..=longest).contains(&found), "{found}");
    }
}

/// Boundary velocities, gravity, and a cost that depends on time itself: neighbouring horizons cost more.
#[test]
fn the_neighbours_of_a_free_horizon_cost_more() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let model = &scenario.model;
    let (start, goal) = (vec![0.1, 0.2, 0.5, -1.0], vec![0.9, -0.3, 1.0, 0.5]);
    let problem = |t| Problem::new(model, start.clone(), goal.clone(), t).expect("valid");
    let effort = |at: &StageInput<'_, HyperDual64>| at.u.iter().map(|u| *u * *u).sum::<HyperDual64>();
    let cost = CostThroughDynamics::new(model, |at| effort(at) * (at.t * 2.0 + 1.0) + at.t * at.t * 9.0);
    let weight = 40.0;
    let settings = DirectSettings { starts: 1, quadrature_tolerance: 1e-8, ..horizon(0.2, 5.0, weight) };
    let run = |problem: &Problem<'_>, settings: &DirectSettings| {
        let direct = Direct::new(problem).cost(cost.clone());
        let found = direct.settings(settings.clone()).solve();
        found.unwrap_or_else(|e| panic!("{e}"))
    };
    let found = run(&problem(1.0), &settings);
    let best = found.curve.chebyshev(0).horizon();
    assert!(found.converged && best > 0.21 && best < 4.9, "{best}");
    let at = |t: f64| {
        let fixed = DirectSettings { start: Some(found.curve.clone()), free_horizon: None, ..settings.clone() };
        let solution = run(&problem(t), &fixed);
        assert!(solution.converged);
        solution.cost + weight * t
    };
    let [less, here, more] = [0.99, 1.0, 1.01].map(|factor| at(factor * best));
    assert!(here < less && here < more, "{less} {here} {more}");
    // The parabola through the three has its vertex there, but for what the third derivative moves it.
    let vertex = 0.5 * 0.01 * (less - more) / (less - 2.0 * here + more);
    assert!(vertex.abs() < 1e-3, "{vertex}");
}

/// A limit on the torque makes short horizons dear, and below a bound impossible.
#[test]
fn a_free_horizon_within_constraints() {
    let model = slider(1.0);
    let problem = |t| Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], t).expect("valid");
    // From rest to rest in T it takes 4 / T^2 at least, and 6 / T^2 for the least effort.
    let limit = 6.0;
    let kept =
        Constraints { state: Bounds(Vec::new()), torque: TorqueLimits(vec![Some(limit)]), stage: Default::default() };
    let weight = 100.0;
    let settings = DirectSettings { starts: 1, ..DirectSettings::constrained() };
    let run = |t: f64, settings: &DirectSettings| solved_within(&problem(t), settings, &kept);
    let free = DirectSettings { free_horizon: horizon(0.2, 4.0, weight).free_horizon, ..settings.clone() };
    // Without a longer horizon the second start would have no motion within the limit.
    for begin in [2.0, 0.75] {
        let found = run(begin, &free);
        let best = found.curve.chebyshev(0).horizon();
        assert!(found.converged && found.largest_violation <= DirectSettings::FEASIBLE);
        // Without the limit it would be (36 / w)^(1/4) = 0.77, which is too short by far.
        assert!(best > 0.82 && best < 1.0, "{best}");
        let at = |t: f64| {
            let solution = run(t, &settings);
            assert!(solution.converged, "{t}: {solution:?}");
            solution.cost + weight * t
        };
        let [less, here, more] = [0.98, 1.0, 1.02].map(|factor| at(factor * best));
        assert!(here < less && here < more, "{less} {here} {more}");
    }
}

/// Where the weight of time is large the horizon is nearly the shortest possible one.
#[test]
fn a_large_weight_finds_a_short_horizon() {
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 2.0).expect("valid");
    let kept =
        Constraints { state: Bounds(Vec::new()), torque: TorqueLimits(vec![Some(6.0)]), stage: Default::default() };
    let found = [1e2, 1e4].map(|weight| {
        let settings = DirectSettings {
            starts: 1,
            free_horizon: horizon(0.2, 4.0, weight).free_horizon,
            ..DirectSettings::constrained()
        };
        let found = solved_within(&problem, &settings, &kept);
        assert!(found.converged, "{weight}: {found:?}");
        found.curve.horizon()
    });
    // From rest to rest it takes at least 2 / sqrt(6) s, with a control that jumps, which no polynomial has.
    let shortest = 2.0 / 6.0_f64.sqrt();
    assert!(found[1] < found[0], "{found:?}");
    assert!((shortest..1.05 * shortest).contains(&found[1]), "{found:?}");
}

#[test]
fn bad_horizons_are_errors() {
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    for (shortest, longest, weight, words) in [
        (0.0, 2.0, 1.0, "free_horizon.shortest: it is 0 and must be a positive time"),
        (0.5, f64::INFINITY, 1.0, "free_horizon.longest: it is inf"),
        (0.5, 2.0, -1.0, "free_horizon.weight: it is -1, a weight is not"),
        (1.5, 2.0, 1.0, "free_horizon.shortest: it is 1.5, above the horizon 1"),
        (0.2, 0.5, 1.0, "free_horizon.longest: it is 0.5, below the horizon 1"),
    ] {
        let settings = horizon(shortest, longest, weight);
        let direct = Direct::new(&problem).settings(settings);
        let error = direct.solve().expect_err(words);
        assert!(error.to_string().contains(words), "{error}; want {words}");
    }
}
