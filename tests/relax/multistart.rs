//! Several starts, and minima within constraints: what does not change them, and what can only be one way.

use crate::common::config;
use crate::common::relax::{degree, solved, solved_within};
use crate::common::slider;
use crate::constrained::point_mass;
use aghf::constraint::{AnyConstraint, Bound, Bounds, Constraints, Side, TorqueLimits};
use aghf::curve::gauss_legendre;
use aghf::motion::{Problem, sample};
use aghf::relax::{RelaxSettings, RelaxSolution, Relaxation};
use aghf::scenario::Scenario;
use nalgebra::Vector3;
use proptest::prelude::*;

type Kept = Constraints<Vec<AnyConstraint>>;

fn torque(limits: Vec<Option<f64>>) -> Kept {
    Constraints {
        state: Vec::new(),
        torque: TorqueLimits(limits),
    }
}

/// Degree 9 with a quadrature that is good to eight digits.
fn fine(settings: RelaxSettings) -> RelaxSettings {
    RelaxSettings {
        degree: 9,
        quadrature_tolerance: 1e-8,
        ..settings
    }
}

/// The most that each joint needs of its torque.
fn largest_torques(model: &aghf::model::Model, solution: &RelaxSolution) -> Vec<f64> {
    let samples = sample(model, &solution.curve, 500).expect("same robot");
    let of = |i: usize| samples.iter().map(|s| s.u[i].abs()).fold(0.0, f64::max);
    (0..model.dof()).map(of).collect()
}

/// What `n` starts lead to is among what more starts lead to.
#[test]
fn more_starts_never_cost_more() {
    for name in ["pendulum_2_swingup", "kinova_free_01"] {
        let scenario = Scenario::load(name).expect("built in");
        let problem = scenario.problem().expect("valid");
        let of = |num_starts| {
            let settings = RelaxSettings {
                num_starts,
                ..degree(9)
            };
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
        assert!(found[6].minima.len() > 1, "{name}");
        assert!(found[6].cost < found[0].cost, "{name}");
    }
}

#[test]
fn any_number_of_threads_finds_the_same_bits() {
    let scenario = Scenario::load("pendulum_2_swingup").expect("built in");
    let problem = scenario.problem().expect("valid");
    let limits = torque(vec![Some(40.0), Some(20.0)]);
    for constrained in [false, true] {
        let of = |threads| {
            let settings = RelaxSettings {
                threads,
                num_starts: 11,
                ..degree(9)
            };
            let settings = if constrained {
                RelaxSettings {
                    tolerance: 1e-6,
                    ..settings
                }
            } else {
                settings
            };
            let mut seen = Vec::new();
            let relaxation = Relaxation::new(&problem).settings(settings);
            let relaxation = relaxation.observe(|iteration| seen.push(*iteration));
            let found = if constrained {
                relaxation.constraints(&limits).solve()
            } else {
                relaxation.solve()
            };
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
        speed in 0.7..1.3_f64,
        force in 0.8..1.3_f64,
    ) {
        let model = point_mass(&[Vector3::x(), Vector3::y()]);
        let start = vec![ends[0], ends[1], 0.0, 0.0];
        let goal = vec![ends[2], ends[3], 0.0, 0.0];
        let problem = Problem::new(&model, start, goal, 1.0).expect("valid");
        let free = solved(&problem, &fine(degree(9)));
        // From rest to rest over d the velocity reaches 1.5 d and the force 6 d.
        let distance = |i: usize| (ends[i + 2] - ends[i]).abs() + 0.1;
        let bound = |entry: usize, side, sign: f64| Bound {
            entry,
            side,
            value: sign * 1.5 * speed.max(0.8) * distance(entry - 2),
        };
        let bounds = [2, 3].map(|entry| [bound(entry, Side::Upper, 1.0), bound(entry, Side::Lower, -1.0)]);
        let kept = Constraints {
            state: vec![AnyConstraint::Bounds(Bounds(bounds.concat()))],
            torque: TorqueLimits(vec![Some(6.0 * force.max(0.9) * distance(0)), None]),
        };
        let within = solved_within(&problem, &fine(RelaxSettings::constrained()), &kept);
        prop_assert!(within.largest_violation <= RelaxSettings::FEASIBLE || !within.converged);
        if within.converged {
            prop_assert!(within.cost >= free.cost * (1.0 - 1e-12), "{} {}", within.cost, free.cost);
        }
    }
}

/// Off the limits it can only go down, and on limits that are moved far away the search ends where it ends without.
#[test]
fn limits_that_are_moved_away_are_none() {
    for name in ["pendulum_2_swingup", "pendulum_3_swingup", "kinova_free_01"] {
        let scenario = Scenario::load(name).expect("built in");
        let (model, problem) = (&scenario.model, scenario.problem().expect("valid"));
        let free = solved(&problem, &fine(degree(9)));
        let from = |start: &RelaxSolution, settings| RelaxSettings {
            start: Some(start.curve.clone()),
            ..fine(settings)
        };
        let tight: Vec<f64> = largest_torques(model, &free)
            .iter()
            .map(|u| 0.9 * u)
            .collect();
        let scaled = |by: f64| torque(tight.iter().map(|limit| Some(by * limit)).collect());
        let near = from(&free, RelaxSettings::constrained());
        let within = solved_within(&problem, &near, &scaled(1.0));
        assert!(within.converged, "{name}: {}", within.largest_violation);
        let off = solved(&problem, &from(&within, degree(9)));
        assert!(
            off.converged && off.cost <= within.cost * (1.0 - 1e-4),
            "{name}"
        );
        // The same start, off the minimum.
        let far = solved_within(
            &problem,
            &from(&within, RelaxSettings::constrained()),
            &scaled(1e6),
        );
        assert!(far.converged && far.largest_violation == 0.0, "{name}");
        let apart = far.cost / off.cost - 1.0;
        assert!(apart.abs() < 1e-6, "{name}: {apart:e}");
    }
}

/// The order of rows is that of sums.
#[test]
fn the_order_of_constraints_does_not_matter() {
    let scenario = Scenario::load("kinova_obstacles_01").expect("built in");
    let problem = scenario.problem().expect("valid");
    let state = scenario.state_constraints().expect("valid");
    let torque = scenario.torque_limits();
    let settings = RelaxSettings {
        degree: 9,
        ..RelaxSettings::constrained()
    };
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
        let kept = Constraints {
            state,
            torque: torque.clone(),
        };
        solved_within(&problem, &settings, &kept)
    });
    assert!(one.converged && other.converged);
    let apart = one.cost / other.cost - 1.0;
    assert!(apart.abs() < 1e-9, "{apart:e}");
}

/// A polynomial cannot keep its torque at zero at all times: it does at as many points of the quadrature as it has free coefficients.
#[test]
fn a_passive_joint_is_without_torque_where_it_can_be() {
    let scenario = Scenario::load("pendulum_2_swingup").expect("built in");
    let model = &scenario.model;
    let goal = vec![0.6, 0.0, 0.0, 0.0];
    let problem = Problem::new(model, vec![0.0; 4], goal, 2.0).expect("valid");
    let settings = RelaxSettings {
        degree: 12,
        ..RelaxSettings::constrained()
    };
    let free = solved(&problem, &degree(12));
    assert!(largest_torques(model, &free)[1] > 0.1);
    let found = solved_within(&problem, &settings, &torque(vec![None, Some(0.0)]));
    assert!(
        found.converged,
        "{} {}",
        found.gradient_norm, found.largest_violation
    );
    assert!(found.cost > free.cost);
    let (nodes, _) = gauss_legendre(found.points);
    let (points, held) = (found.points, 12 - 3);
    let chosen = (0..held).map(|k| (2 * k + 1) * points / (2 * held));
    let mut data = aghf::dynamics::Data::new(model);
    for g in chosen {
        let (x, xdot) = found.curve.at(1.0 + nodes[g]);
        let mut u = [0.0; 2];
        aghf::motion::control_at(model, &mut data, &x, &xdot, &mut u).expect("same robot");
        assert!(u[1].abs() <= RelaxSettings::FEASIBLE, "{g}: {}", u[1]);
    }
    // Between them what is left is small against what it would take otherwise.
    let most = largest_torques(model, &found)[1];
    assert!(most < 0.1 * largest_torques(model, &free)[1], "{most}");
}

/// Where there is no motion it says so, whatever it tries.
#[test]
fn what_is_impossible_is_told() {
    let limited = |entry, value| Constraints {
        state: vec![AnyConstraint::Bounds(Bounds(vec![Bound {
            entry,
            side: Side::Upper,
            value,
        }]))],
        torque: TorqueLimits(Vec::new()),
    };
    let check = |problem: &Problem<'_>, kept: &Kept, excess: f64| {
        let settings = RelaxSettings {
            degree: 9,
            ..RelaxSettings::constrained()
        };
        let found = solved_within(problem, &settings, kept);
        assert!(!found.converged && found.minima.is_empty());
        assert!(
            found.largest_violation >= excess,
            "{}",
            found.largest_violation
        );
        assert!(found.cost.is_finite() && found.curve.x().iter().all(|x| x.is_finite()));
        // All starts that there may be.
        assert_eq!(found.start_costs.len(), 64);
    };
    // The mean velocity is one.
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    check(&problem, &limited(1, 0.9), 0.1);
    let scenario = Scenario::load("pendulum_2_swingup").expect("built in");
    let problem = scenario.problem().expect("valid");
    let mean = (problem.goal()[0] - problem.start()[0]) / problem.horizon();
    let kept = Constraints {
        torque: TorqueLimits(vec![Some(200.0); 2]),
        ..limited(2, mean - 0.5)
    };
    check(&problem, &kept, 0.5);
}
