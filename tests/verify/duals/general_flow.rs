//! The public check of a user-defined flow: any Lagrangian, metric, right-hand side and Jacobian.

use crate::common::{robot, robots};
use aghf::flow::jacobian::{ControlFormJacobian, ForwardDual, NodeJacobian};
use aghf::flow::{
    ActuationMetric, ActuationWeights, AghfLagrangian, ControlDual, ControlForm, ControlLagrangian, DualTrajectory,
    LagrangianFlow, Metric, RightHandSide,
};
use aghf::model::Model;
use aghf::verify::duals::{CheckOptions, Finding, FlowUnderTest, check_all, check_flow};
use nalgebra::DMatrix;

fn options(samples: usize) -> CheckOptions {
    CheckOptions { samples, seed: 3, penalties: vec![1.0, 1e7] }
}

type General = ControlLagrangian<f64, ControlDual>;

/// The last joint is passive, with duals of the slip and of its torque.
fn general(n: usize) -> General {
    let trajectory = |last_alone: bool| {
        let coefficients = DMatrix::from_fn(n, 4, |i, j| {
            let here = !last_alone || i + 1 == n;
            f64::from(u8::from(here)) * (1.0 + i as f64 + 0.6 * j as f64).cos()
        });
        DualTrajectory::new(3.0, coefficients).expect("it has columns")
    };
    let mut weights = vec![1.0; n];
    weights[n - 1] = 50.0;
    ControlLagrangian {
        weights: ActuationWeights::diagonal(weights).expect("none is zero"),
        slip_dual: Some(trajectory(false)),
        cost: ControlDual(trajectory(true)),
    }
}

fn checked<M: Metric>(
    model: &Model,
    lagrangian: &General,
    metric: &M,
    right_hand_side: &mut dyn RightHandSide<f64, f64>,
    jacobian: &mut dyn NodeJacobian,
) -> Vec<Finding> {
    let flow = FlowUnderTest { name: "mine", lagrangian, metric, right_hand_side, jacobian };
    check_flow(model, flow, &options(1)).expect("it fits")
}

#[test]
fn a_flow_passes_on_every_robot() {
    for model in robots() {
        let lagrangian = general(model.dof());
        let findings = checked(
            &model,
            &lagrangian,
            &lagrangian.metric(),
            &mut ControlForm::of(&model, lagrangian.clone()),
            &mut ControlFormJacobian::of(&model, lagrangian.clone()),
        );
        // Two halves of Omega and six blocks, at two penalties.
        assert_eq!(findings.len(), 16);
        let off: Vec<&Finding> = findings.iter().filter(|f| !f.passes()).collect();
        assert!(off.is_empty(), "{}: {off:?}", model.name());
    }
}

/// Each part that belongs to another flow is found, and no other.
#[test]
fn what_belongs_to_another_flow_is_found() {
    let model = robot("pendulum_3");
    let right = general(3);
    let without_dual = ControlLagrangian { slip_dual: None, ..right.clone() };
    let off = |metric: &ActuationMetric, flow: &General, jacobian: &General| {
        let findings = checked(
            &model,
            &right,
            metric,
            &mut ControlForm::of(&model, flow.clone()),
            &mut ControlFormJacobian::of(&model, jacobian.clone()),
        );
        let at_one = findings.into_iter().filter(|f| f.k == Some(1.0));
        let off = at_one.filter(|f| !f.passes()).map(|f| f.quantity);
        off.collect::<Vec<_>>()
    };
    let metric = right.metric();
    assert!(off(&metric, &right, &right).is_empty());
    assert_eq!(off(&metric, &without_dual, &right), ["mine: Omega_P1", "mine: Omega_P2"]);
    assert_eq!(off(&metric, &right, &without_dual), ["mine: dOmega_P2/dx"]);
    // In another metric the second half of all quantities differs.
    let of_another = off(&ActuationMetric::default(), &right, &right);
    assert_eq!(of_another, ["mine: Omega_P2", "mine: dOmega_P2/dx", "mine: dOmega_P2/dxdot", "mine: dOmega_P2/dxddot"]);
}

#[test]
fn everything_that_is_checked_has_the_general_flow() {
    let findings = check_all(&robot("pendulum_2"), &options(1)).expect("a loaded model");
    for what in [
        "general flow: Omega_P1",
        "general flow: dOmega_P2/dxddot",
        "affine Lagrangian: value",
        "metric: Hessian of the affine Lagrangian",
    ] {
        assert!(findings.iter().any(|f| f.quantity == what), "{what}");
    }
}

/// A flow by its definition can be checked as well.
#[test]
fn a_definition_is_its_own_flow() {
    let model = robot("pendulum_2");
    let metric = &ActuationMetric::default();
    let definition = || LagrangianFlow::new(&model, AghfLagrangian);
    let flow = FlowUnderTest {
        name: "paper",
        lagrangian: &AghfLagrangian,
        metric,
        right_hand_side: &mut definition(),
        jacobian: &mut ForwardDual::of(definition(), 2),
    };
    let findings = check_flow(&model, flow, &options(2)).expect("it fits");
    assert!(findings.iter().all(Finding::passes));
}
