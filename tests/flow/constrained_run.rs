//! Flows with constraints from the initial guess to their end.

use crate::common::assert_refused;
use crate::common::scenario::Scenario;
use aghf::constraint::{Bound, Bounds, Constraint, Constraints, PlacedState, RowSet, Side, TorqueLimits};
use aghf::flow::jacobian::JacobianKind;
use aghf::flow::{Flow, FlowSettings, Penalised, Penalty, PenaltyWeights};
use aghf::scalar::AlgebraOver;

/// A velocity limit slows a pendulum down with any Jacobian of the flow; constraints that are far from active have no
/// effect.
#[test]
fn the_flow_heeds_constraints() {
    let scenario = Scenario::load("pendulum_1_swingup");
    let problem = scenario.problem();
    let settings = FlowSettings::new(9, 1e3, 100.0);
    let limited = |limit: f64, settings: &FlowSettings| {
        let speed = |side, value| Bound { entry: 1, side, value };
        let constraints = Penalised {
            constraints: Constraints {
                state: Bounds(vec![speed(Side::Upper, limit), speed(Side::Lower, -limit)]),
                torque: TorqueLimits(vec![]),
                stage: Default::default(),
            },
            weights: PenaltyWeights {
                state: Penalty { k_cons: 1e3, c_cons: 20.0 },
                torque: Penalty { k_cons: 1.0, c_cons: 1.0 },
            },
        };
        let flow = Flow::new(&problem, settings.clone()).constraints(&constraints);
        let solution = flow.run().expect("good input");
        assert_eq!(solution.failure, None);
        solution.curve
    };
    let free = Flow::new(&problem, settings.clone()).run();
    let free = free.expect("good input");
    assert_eq!(free.failure, None);
    let free = free.curve;
    let fastest = |curve: &aghf::curve::Curve| {
        let speeds = (0..=100).map(|i| curve.at(0.02 * f64::from(i)).0[1].abs());
        speeds.fold(0.0, f64::max)
    };
    assert!((limited(100.0, &settings).x() - free.x()).amax() < 1e-6);
    let limit = 0.9 * fastest(&free);
    let slow = limited(limit, &settings);
    assert!(fastest(&slow) < 0.97 * fastest(&free), "{} for {limit}", fastest(&slow));
    for (name, kind) in JacobianKind::by_name() {
        let settings = FlowSettings { jacobian: kind, ..settings.clone() };
        let other = limited(limit, &settings);
        assert!((other.x() - slow.x()).amax() < 1e-3, "{name}");
    }
}

/// A penalty is one-sided, so it would enforce only half of an equality.
#[test]
fn an_equality_in_the_state_is_refused() {
    #[derive(Clone, Debug)]
    struct Level(Bounds);
    impl Constraint for Level {
        fn dim(&self) -> usize {
            self.0.dim()
        }

        fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> aghf::Result<()> {
            self.0.value(at, g)
        }

        fn row_set(&self, row: usize) -> RowSet {
            if row == 1 { RowSet::zero() } else { RowSet::at_most_zero() }
        }
    }
    let scenario = Scenario::load("pendulum_1_swingup");
    let problem = scenario.problem();
    let bound = |value| Bound { entry: 0, side: Side::Upper, value };
    let one = Penalty { k_cons: 1.0, c_cons: 1.0 };
    let level = Penalised {
        constraints: Constraints {
            state: vec![Level(Bounds(vec![bound(9.0), bound(1.0)]))],
            torque: TorqueLimits(vec![]),
            stage: Default::default(),
        },
        weights: PenaltyWeights { state: one, torque: one },
    };
    let settings = FlowSettings::new(9, 1e3, 1.0);
    let flow = Flow::new(&problem, settings).constraints(&level);
    assert_refused(flow.run(), "row 1 of the constraint: it is an equality");
}
