//! Running costs of a user's own: optima that are known, and what is refused.

use crate::common::direct::{degree, solved as of_least_effort, solved_within};
use crate::common::scenario::Scenario;
use crate::common::slider;
use aghf::constraint::{AnyConstraint, Constraints, TorqueLimits};
use aghf::cost::{CostThroughDynamics, CostWithControl, HyperDual64, StageInput, WeightedSquares};
use aghf::direct::{Direct, DirectSettings, DirectSolution};
use aghf::motion::Problem;
use num_dual::DualNum;

fn solved<P: CostWithControl>(problem: &Problem<'_>, settings: &DirectSettings, cost: &P) -> DirectSolution {
    let direct = Direct::new(problem).cost(cost.clone());
    let found = direct.settings(settings.clone()).solve();
    found.unwrap_or_else(|e| panic!("{e}"))
}

/// Without any torque in it: least $\int v^2 dt$ at given ends is constant velocity where the ends allow it.
#[test]
fn squared_velocity_alone_is_a_cost() {
    let model = slider(2.0);
    let cost = CostThroughDynamics::new(&model, |at| at.v[0] * at.v[0]);
    let straight = Problem::new(&model, vec![0.0, 0.5], vec![1.0, 0.5], 2.0).expect("valid");
    let solution = solved(&straight, &degree(9), &cost);
    assert!(solution.converged && (solution.cost - 0.5).abs() < 1e-12);
    assert!((solution.curve.at(0.3).0[0] - 0.15).abs() < 1e-9);
    // From rest to rest the optimum is that of the degree: nearer to one half the higher it is.
    let rest = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 2.0).expect("valid");
    let [low, high] = [5, 16].map(|p| solved(&rest, &degree(p), &cost));
    assert!(low.converged && high.converged);
    assert!(low.cost > high.cost && high.cost > 0.5);
}

/// A joint that costs nothing leaves directions that the metric does not see, and Newton's method ends all the same.
#[test]
fn a_joint_may_cost_nothing() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let weighted = WeightedSquares::new(2, vec![1.0, 0.0], vec![0.0; 2], vec![0.0; 2]).expect("good");
    let cost = CostThroughDynamics::of(&scenario.model, weighted);
    let problem = scenario.problem();
    let solution = solved(&problem, &degree(9), &cost);
    let both = of_least_effort(&problem, &degree(9));
    assert!(solution.cost < both.cost, "{} {}", solution.cost, both.cost);
    assert!(solution.gradient_norm.is_finite(), "{solution:?}");
}

/// A smooth stand-in for energy: each motion is the better one by its own measure.
#[test]
fn least_power_is_not_least_effort() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let (model, problem) = (&scenario.model, scenario.problem());
    let power = CostThroughDynamics::new(model, |at| {
        let both = at.u.iter().zip(at.v);
        both.map(|(u, v)| (*u * *v).powi(2)).sum::<HyperDual64>()
    });
    let settings = degree(12);
    let by_power = solved(&problem, &settings, &power);
    let by_effort = of_least_effort(&problem, &settings);
    assert!(by_power.converged && by_power.smallest_curvature > 0.0, "{by_power:?}");
    let from_there = DirectSettings { start: Some(by_effort.curve.clone()), ..settings.clone() };
    let from_there = solved(&problem, &from_there, &power);
    let before = from_there.iterations[0].cost;
    assert!(by_power.cost < 0.9 * before, "{} {before}", by_power.cost);
    let start = Some(by_power.curve.clone());
    let back = DirectSettings { start, ..settings };
    let back = of_least_effort(&problem, &back);
    assert!(back.iterations[0].cost > 1.1 * by_effort.cost);
}

/// Constraints go with any cost: torque limits charge a cost by hand as they charge the effort.
#[test]
fn another_cost_keeps_constraints() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let (model, problem) = (&scenario.model, scenario.problem());
    let settings = DirectSettings { degree: 9, ..DirectSettings::constrained() };
    let free = of_least_effort(&problem, &settings);
    let settings = DirectSettings { start: Some(free.curve.clone()), ..settings };
    let samples = aghf::motion::sample(model, &free.curve, 200).expect("the same robot");
    let most = samples.iter().flat_map(|s| &s.u).fold(0.0_f64, |m, u| m.max(u.abs()));
    let kept: Constraints<Vec<AnyConstraint>> =
        Constraints { state: Vec::new(), torque: TorqueLimits(vec![Some(0.8 * most); 2]), stage: Default::default() };
    let effort = solved_within(&problem, &settings, &kept);
    let run = |cost: &CostThroughDynamics<'_, WeightedSquares>| {
        let direct = Direct::new(&problem).cost(cost.clone());
        let direct = direct.constraints(&kept).settings(settings.clone());
        direct.solve().unwrap_or_else(|e| panic!("{e}"))
    };
    let weighted = |torque: f64, velocity: f64| {
        let weighted = WeightedSquares::new(2, vec![torque; 2], vec![velocity; 2], vec![0.0; 2]);
        CostThroughDynamics::of(model, weighted.expect("good"))
    };
    let twice = run(&weighted(2.0, 0.0));
    assert!(effort.converged && twice.converged, "{twice:?}");
    assert!((twice.cost - 2.0 * effort.cost).abs() < 1e-5 * twice.cost);
    assert!(effort.cost > free.cost);
    let slow = run(&weighted(1.0, 20.0));
    assert!(slow.converged && slow.largest_violation <= DirectSettings::FEASIBLE, "{slow:?}");
    let fastest = |solution: &DirectSolution| {
        let times = (0..=100).map(|i| 0.01 * f64::from(i) * problem.horizon());
        times.fold(0.0_f64, |m, t| m.max(solution.curve.at(t).0.rows(2, 2).amax()))
    };
    assert!(fastest(&slow) < fastest(&effort));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let below = |at: &StageInput<'_, HyperDual64>| at.u[0] * at.u[0] - 1e3;
    let cost = CostThroughDynamics::new(&model, below);
    let direct = Direct::new(&problem).cost(cost).settings(degree(6));
    let error = direct.solve().expect_err("it is negative").to_string();
    assert!(error.starts_with("running cost: integral: it is -9.88"), "{error}");
    // A constant makes it good, and does not move the optimum.
    let cost = CostThroughDynamics::new(&model, |at| at.u[0] * at.u[0] + 1e3);
    let solution = solved(&problem, &degree(6), &cost);
    assert!(solution.converged && (solution.cost - 1012.0).abs() < 1e-6);
    for (weights, words) in [
        ([vec![1.0, 1.0], vec![0.0], vec![0.0]], "torque: the robot has 1 joints, but 2"),
        ([vec![1.0], vec![-0.5], vec![0.0]], "velocity: it is -0.5, a weight is not"),
        ([vec![1.0], vec![0.0], vec![f64::NAN]], "acceleration: it is NaN"),
    ] {
        let [torque, velocity, acceleration] = weights;
        let error = WeightedSquares::new(1, torque, velocity, acceleration).expect_err(words);
        assert!(error.to_string().contains(words), "{error}; want {words}");
    }
}
