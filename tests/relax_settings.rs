//! What the relaxation can be asked for besides the least effort from state to state.

mod common;

use aghf::aghf::TorqueLimits;
use aghf::aghf::constraint::{Bound, Bounds, Side};
use aghf::pseudospectral::Curve;
use aghf::scenario::Scenario;
use aghf::solve::{
    Feedback, Problem, RelaxSettings, RelaxSolution, Requirements, relax, relax_constrained,
    simulate,
};
use common::slider;

fn solved(problem: &Problem<'_>, settings: &RelaxSettings) -> RelaxSolution {
    relax(problem, settings, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"))
}

/// Any velocity at the end.
fn arriving_anyhow(p: usize) -> RelaxSettings {
    RelaxSettings {
        p,
        free_final_velocity: true,
        ..Default::default()
    }
}

/// From rest over a distance `d` in `T`: the acceleration falls to zero at the end, $q = d (3 \tau^2 - \tau^3) / 2$, and the effort is
/// $3 m^2 d^2 / T^3$, a quarter of that from rest to rest.
#[test]
fn a_free_final_velocity_is_that_of_least_effort() {
    let (mass, horizon) = (3.0, 1.7);
    let model = slider(mass);
    let problem = Problem::new(&model, vec![0.0, 0.0], vec![1.0, -4.0], horizon).expect("valid");
    let exact = 3.0 * mass * mass / horizon.powi(3);
    let is_exact = |curve: &Curve| {
        for s in [0.0, 0.3, 0.8, 1.0_f64] {
            let (x, _) = curve.at(s * horizon);
            assert!(
                (x[0] - s * s * (3.0 - s) / 2.0).abs() < 1e-8,
                "{s}: {}",
                x[0]
            );
        }
        let end = curve.x().column(curve.x().ncols() - 1);
        assert!((end[0] - 1.0).abs() < 1e-15 && (end[1] - 1.5 / horizon).abs() < 1e-8);
    };
    for p in [4, 9] {
        let solution = solved(&problem, &arriving_anyhow(p));
        assert!(
            solution.converged && (solution.cost - exact).abs() < 1e-12 * exact,
            "{solution:?}"
        );
        is_exact(&solution.curve);
        // The test of success asks for the end of the curve, not for the velocity of the goal.
        let simulation = simulate(&model, &solution.curve, Feedback { kp: 10.0, kv: 10.0 });
        let simulation = simulation.expect("the same robot").expect("it ends");
        assert!(simulation.error_inf < 1e-6, "{simulation:?}");
    }
    // The same within a bound that does not touch it, although the velocity of the goal breaks it.
    let bound = Bound {
        entry: 1,
        side: Side::Lower,
        value: -0.5,
    };
    let kept = Requirements {
        state: Bounds(vec![bound]),
        torque: TorqueLimits(Vec::new()),
    };
    let settings = RelaxSettings {
        free_final_velocity: true,
        ..RelaxSettings::constrained()
    };
    let within = |settings: &RelaxSettings| {
        relax_constrained(&problem, settings, &kept, &mut |_| {}).expect("valid")
    };
    let solution = within(&settings);
    assert!(solution.converged, "{solution:?}");
    is_exact(&solution.curve);
    assert!(!within(&RelaxSettings::constrained()).converged);
}

/// A motion to a given velocity is one to any velocity.
#[test]
fn a_free_final_velocity_costs_no_more() {
    let scenario = Scenario::load("kinova_free_04").expect("built in");
    let problem = scenario.problem().expect("valid");
    let fixed = RelaxSettings {
        p: 9,
        starts: 1,
        ..Default::default()
    };
    let fixed = solved(&problem, &fixed);
    let from_there = RelaxSettings {
        start: Some(fixed.curve.clone()),
        ..arriving_anyhow(9)
    };
    let free = solved(&problem, &from_there);
    assert!(fixed.converged && free.converged, "{free:?}");
    assert!(free.smallest_curvature > 0.0);
    assert!(free.cost < fixed.cost, "{} {}", free.cost, fixed.cost);
    // Bent starts have their bubbles and no more: all end where q is that of the goal.
    let bent = solved(
        &problem,
        &RelaxSettings {
            starts: 4,
            ..arriving_anyhow(9)
        },
    );
    let end = bent.curve.x().column(9);
    assert!(bent.converged && end.as_slice()[..7] == problem.goal()[..7]);
    assert_eq!(bent.curve.x().column(0).as_slice(), problem.start());
}
