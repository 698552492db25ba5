//! Several starts, and minima within constraints: what does not change them, and what can only be one way.

use crate::common::config;
use crate::common::direct::{degree, solved, solved_within};
use crate::common::scenario::Scenario;
use crate::common::{point_mass, slider};
use aghf::constraint::{AnyConstraint, Bound, Bounds, Constraints, Side, TorqueLimits};
use aghf::curve::gauss_legendre;
use aghf::direct::{Direct, DirectSettings, DirectSolution};
use aghf::dynamics::Data;
use aghf::model::Model;
use aghf::motion::{Problem, control_at, sample};
use nalgebra::Vector3;
use proptest::prelude::*;

type Kept = Constraints<Vec<AnyConstraint>>;

fn torque(limits: Vec<Option<f64>>) -> Kept {
    Constraints { state: Vec::new(), torque: TorqueLimits(limits), stage: Default::default() }
}

/// Degree 9 with a quadrature that is good to eight digits.
fn fine(settings: DirectSettings) -> DirectSettings {
    DirectSettings { degree: 9, quadrature_tolerance: 1e-8, ..settings }
}

/// The most that each joint needs of its torque.
fn largest_torques(model: &Model, solution: &DirectSolution) -> Vec<f64> {
    let samples = sample(model, &solution.curve, 500).expect("same robot");
    let of = |i: usize| samples.iter().map(|s| s.u[i].abs()).fold(0.0, f64::max);
    (0..model.dof()).map(of).collect()
}

/// The minima of `n` starts are among those of more starts.
#[test]
fn more_starts_never_cost_more() {
    for name in ["pendulum_3_swingup", "kinova_free_01"] {
        let scenario = Scenario::load(name);
        let problem = scenario.problem();
        let of = |starts| {
            let settings = DirectSettings { starts, ..degree(9) };
            solved(&problem, &settings)
        };
        let found = [1, 2, 3, 5, 8, 13, 21].map(of);
        for (few, more) in found.iter().zip(&found[1..]) {
            assert!(more.cost <= few.cost, "{name}: {} {}", more.cost, few.cost);
            assert!(more.start_costs.len() > few.start_costs.len());
            let known = |cost: &f64| more.start_costs.contains(cost);
            assert!(few.start_costs.iter().all(known), "{name}");
        }
        for solution in &found {
            assert!(solution.converged);
            assert_eq!(solution.minima[0].cost, solution.cost);
            assert!(solution.minima.is_sorted_by(|a, b| a.cost < b.cost));
            let ended = solution.minima.iter().map(|m| m.starts).sum::<usize>();
            assert!((1..=solution.start_costs.len()).contains(&ended));
        }
        // There is more than one minimum, so that starts matter.
        assert!(found[6].minima.len() > 1, "{name}: {:?}", found[6].minima);
        assert!(found[6].cost < found[0].cost, "{name}");
    }
}

#[test]
fn any_number_of_threads_finds_the_same_bits() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let problem = scenario.problem();
    let limits = torque(vec![Some(40.0), Some(20.0)]);
    for constrained in [false, true] {
        let of = |threads| {
            let settings = DirectSettings { threads, starts: 11, ..degree(9) };
            let settings = if constrained { DirectSettings { tolerance: 1e-6, ..settings } } else { settings };
            let mut seen = Vec::new();
            let direct = Direct::new(&problem).settings(settings);
            let direct = direct.observe(|iteration| seen.push(*iteration));
            let found = if constrained { direct.constraints(&limits).solve() } else { direct.solve() };
            let found = found.unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(seen, found.iterations);
            found
        };
        let [one, two, four] = [1, 2, 4].map(of);
        for other in [two, four] {
            assert_eq!(other.curve.x(), one.curve.x());
            assert_eq!(other.cost, one.cost);
            assert_eq!(other.start_costs, one.start_costs);
            assert_eq!(other.minima, one.minima);
            assert_eq!(other.iterations, one.iterations);
        }
    }
}

proptest! {
    #![proptest_config(config(6))]

    /// On sliders effort and limits are convex: there is one minimum, and limits that bind only make it dearer.
    #[test]
    fn limits_make_the_least_effort_no_less(
        ends in prop::collection::vec(-1.0..1.0_f64, 4),
        speed in 0.8..1.2_f64,
        force in 0.9..1.2_f64,
    ) {
        let model = point_mass(&[Vector3::x(), Vector3::y()]);
        let start = vec![ends[0], ends[1], 0.0, 0.0];
        let goal = vec![ends[2], ends[3], 0.0, 0.0];
        let problem = Problem::new(&model, start, goal, 1.0).expect("valid");
        let free = solved(&problem, &fine(degree(9)));
        // From rest to rest over d the velocity reaches 1.5 d and the force 6 d.
        let [x, y] = [0, 1].map(|i| (ends[i + 2] - ends[i]).abs() + 0.01);
        let bound = |side, value| Bound { entry: 2, side, value };
        let most = 1.5 * speed * x;
        let bounds = vec![bound(Side::Upper, most), bound(Side::Lower, -most)];
        let kept = Constraints {
            state: vec![AnyConstraint::Bounds(Bounds(bounds))],
            torque: TorqueLimits(vec![None, Some(6.0 * force * y)]),
            stage: Default::default(),
        };
        let within = solved_within(&problem, &fine(DirectSettings::constrained()), &kept);
        prop_assert!(within.converged, "{} {}", within.gradient_norm, within.largest_violation);
        prop_assert!(within.largest_violation <= DirectSettings::FEASIBLE);
        let excess = within.cost / free.cost - 1.0;
        prop_assert!(excess >= -1e-12, "{excess:e}");
        // Where nothing binds barriers cost their last weight squared and less.
        if speed > 1.05 && force > 1.05 {
            prop_assert!(excess < 1e-9, "{excess:e}");
        }
    }
}

fn from(start: &DirectSolution, settings: DirectSettings) -> DirectSettings {
    DirectSettings { start: Some(start.curve.clone()), ..fine(settings) }
}

/// From a minimum within limits it can only go down without them.
#[test]
fn without_its_limits_a_motion_costs_less() {
    for name in ["pendulum_2_swingup", "pendulum_3_swingup"] {
        let scenario = Scenario::load(name);
        let (model, problem) = (&scenario.model, scenario.problem());
        let free = solved(&problem, &fine(degree(9)));
        let most = largest_torques(model, &free);
        let limits = torque(most.iter().map(|u| Some(0.95 * u)).collect());
        let near = from(&free, DirectSettings::constrained());
        let within = solved_within(&problem, &near, &limits);
        assert!(within.converged, "{name}: {}", within.largest_violation);
        let kept = largest_torques(model, &within);
        assert!(kept.iter().zip(&most).all(|(u, most)| *u <= 0.95 * most + 1e-6));
        let off = solved(&problem, &from(&within, degree(9)));
        assert!(off.converged && off.cost < within.cost * (1.0 - 1e-4), "{name}: {} {}", off.cost, within.cost);
    }
}

/// On limits that are a million times as far away the search ends where it ends without, from the same start.
#[test]
fn limits_that_are_moved_away_are_none() {
    for name in ["pendulum_2_swingup", "pendulum_3_swingup", "kinova_free_01"] {
        let scenario = Scenario::load(name);
        let (model, problem) = (&scenario.model, scenario.problem());
        // Near enough that there is one minimum about: that of a slightly longer motion.
        let horizon = 1.02 * problem.horizon();
        let (start, goal) = (problem.start().to_vec(), problem.goal().to_vec());
        let longer = Problem::new(model, start, goal, horizon).expect("valid");
        let start = solved(&longer, &degree(9));
        let free = solved(&problem, &from(&start, degree(9)));
        assert!(free.converged && free.iterations.len() > 2, "{name}");
        let most = largest_torques(model, &free);
        let far = torque(most.iter().map(|u| Some(0.9e6 * u)).collect());
        let settings = from(&start, DirectSettings::constrained());
        let found = solved_within(&problem, &settings, &far);
        assert!(found.converged && found.largest_violation == 0.0, "{name}");
        let apart = found.cost / free.cost - 1.0;
        assert!(apart.abs() < 1e-6, "{name}: {apart:e}");
    }
}

/// The order of rows is that of sums.
#[test]
fn the_order_of_constraints_does_not_matter() {
    let scenario = Scenario::load("kinova_obstacles_01");
    let problem = scenario.problem();
    let mut state = scenario.clearance();
    state.push(AnyConstraint::Bounds(Bounds::positions(&scenario.model)));
    let torque = TorqueLimits::of(&scenario.model);
    let settings = DirectSettings { degree: 9, ..DirectSettings::constrained() };
    let reversed = |constraint: AnyConstraint| match constraint {
        AnyConstraint::Bounds(Bounds(mut bounds)) => {
            bounds.reverse();
            AnyConstraint::Bounds(Bounds(bounds))
        }
        AnyConstraint::Spheres(mut clearance) => {
            clearance.spheres.reverse();
            clearance.balls.reverse();
            AnyConstraint::Spheres(clearance)
        }
        other => other,
    };
    let backwards: Vec<_> = state.iter().rev().cloned().map(reversed).collect();
    assert_ne!(format!("{state:?}"), format!("{backwards:?}"));
    let [one, other] = [state, backwards].map(|state| {
        let kept = Constraints { state, torque: torque.clone(), stage: Default::default() };
        solved_within(&problem, &settings, &kept)
    });
    assert!(one.converged && other.converged);
    let apart = one.cost / other.cost - 1.0;
    assert!(apart.abs() < 1e-9, "{apart:e}");
}

/// A polynomial cannot keep its torque at zero at all times: it does at the Gauss points of one degree less, on as many
/// segments as leave next to none between them.
#[test]
fn a_passive_joint_is_without_torque_where_it_can_be() {
    let scenario = Scenario::load("pendulum_2_swingup");
    let model = &scenario.model;
    // From hanging down to the side, at rest under its first motor.
    let mut goal = scenario.problem().start().to_vec();
    let start = goal.clone();
    goal[0] += 0.3;
    goal[1] -= 0.3;
    let problem = Problem::new(model, start, goal, 2.0).expect("valid");
    for (p, segments) in [(9, 1), (8, 4)] {
        let settings = DirectSettings { degree: p, segments, ..DirectSettings::constrained() };
        let driven = solved(&problem, &settings);
        assert!(largest_torques(model, &driven)[1] > 0.1, "{p}");
        let found = solved_within(&problem, &settings, &torque(vec![None, Some(0.0)]));
        assert!(found.converged, "{p}: {}", found.passive_share);
        let torques = largest_torques(model, &found);
        let share = torques[1] / torques[0].max(torques[1]);
        assert!(
            share <= 5e-4 && (found.passive_share / share - 1.0).abs() < 0.05,
            "{p} {share} {}",
            found.passive_share
        );
        let pieces = found.curve.segments();
        assert!(pieces >= segments && pieces.is_multiple_of(segments));
        let held = found.curve.x().ncols() / pieces - 2;
        let (nodes, _) = gauss_legendre(held);
        let mut data = Data::new(model);
        for e in 0..pieces {
            for node in &nodes {
                let time = (e as f64 + 0.5 + 0.5 * node) * 2.0 / pieces as f64;
                let ((x, xdot), mut u) = (found.curve.at(time), [0.0; 2]);
                control_at(model, &mut data, &x, &xdot, &mut u).expect("same robot");
                let most = DirectSettings::FEASIBLE;
                assert!(u[1].abs() <= most, "{p} {time}: {}", u[1]);
            }
        }
    }
}

/// Where there is no motion it says so, whatever it tries.
#[test]
fn what_is_impossible_is_told() {
    let limited = |entry, value| Constraints {
        state: vec![AnyConstraint::Bounds(Bounds(vec![Bound { entry, side: Side::Upper, value }]))],
        torque: TorqueLimits(Vec::new()),
        stage: Default::default(),
    };
    let check = |problem: &Problem<'_>, kept: &Kept, excess: f64| {
        let settings = DirectSettings { degree: 9, ..DirectSettings::constrained() };
        let found = solved_within(problem, &settings, kept);
        assert!(!found.converged && found.minima.is_empty());
        assert!(found.largest_violation >= excess, "{}", found.largest_violation);
        assert!(found.cost.is_finite() && found.curve.x().iter().all(|x| x.is_finite()));
        // All starts that there may be.
        assert_eq!(found.start_costs.len(), 64);
    };
    // The mean velocity is one.
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    check(&problem, &limited(1, 0.9), 0.1);
    let scenario = Scenario::load("pendulum_2_swingup");
    let problem = scenario.problem();
    let mean = (problem.goal()[0] - problem.start()[0]) / problem.horizon();
    let kept = Constraints { torque: TorqueLimits(vec![Some(200.0); 2]), ..limited(2, mean - 0.5) };
    check(&problem, &kept, 0.5);
}
