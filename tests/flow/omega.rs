//! The right-hand side of the flow by four methods, and its Jacobian.

use crate::common::{any_model, config, model_and_node, node, robot, robots, solve_bound, tree};
use aghf::dynamics::{Data, rnea};
use aghf::flow::jacobian::{ForwardDual, NodeBlocks, NodeJacobian};
use aghf::flow::{AlgorithmB1, ControlForm, Node, RightHandSide, lagrangian, lagrangian_of_control};
use aghf::model::Model;
use aghf::motion::control_at;
use aghf::scalar::{AlgebraOver, Tanh};
use aghf::verify::reference::{self, At};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use proptest::strategy::ValueTree;

/// Penalties: one, where no term is negligible, and the paper's.
const PENALTIES: [f64; 3] = [1.0, 1e3, 1e9];

fn omega_of(mut rhs: impl RightHandSide<f64, f64>, parts: &[Vec<f64>; 3], k: f64) -> DVector<f64> {
    let mut omega = DVector::zeros(parts[0].len());
    rhs.omega(node(parts), k, omega.as_mut_slice()).expect("lengths agree");
    omega
}

/// Omega by its definition (7), by nested dual numbers of the Lagrangian.
fn omega_by_definition(model: &Model, parts: &[Vec<f64>; 3], k: f64) -> DVector<f64> {
    let node = node(parts);
    reference::omega_by_definition(&At { model, node, k }).expect("lengths agree")
}

/// Theorem B3 with all of its quantities by dual numbers of the dynamics.
fn omega_by_theorem_b3(model: &Model, parts: &[Vec<f64>; 3], k: f64) -> DVector<f64> {
    let node = node(parts);
    reference::omega_by_theorem_b3(&At { model, node, k }).expect("lengths agree")
}

/// The bound of rounding errors.
fn bound(model: &Model, x: &[f64]) -> f64 {
    solve_bound(model, x, 1e-9)
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn four_routes_to_omega_agree((model, parts) in model_and_node()) {
        let bound = bound(&model, &parts[0]);
        for k in PENALTIES {
            let definition = omega_by_definition(&model, &parts, k);
            assert_close!(&omega_of(ControlForm::new(&model), &parts, k), &definition, bound);
            assert_close!(&omega_of(AlgorithmB1::new(&model), &parts, k), &definition, bound);
            assert_close!(&omega_by_theorem_b3(&model, &parts, k), &definition, bound);
        }
    }

    #[test]
    fn the_two_lagrangians_agree((model, [x, xdot, _]) in model_and_node()) {
        let n = model.dof();
        let mut data = Data::new(&model);
        let mut u = vec![0.0; n];
        rnea(&model, &mut data, &x[..n], &x[n..], &xdot[n..], &mut u).expect("lengths agree");
        for k in PENALTIES {
            let definition = lagrangian(&model, &mut data, &x, &xdot, k).expect("lengths agree");
            let control = lagrangian_of_control(&xdot[..n], &x[n..], &u, k).expect("lengths agree");
            let bound = bound(&model, &x) * definition.max(1.0);
            prop_assert!((definition - control).abs() <= bound, "{definition} {control}");
        }
    }

    /// Central differences, as a sanity check of the dual numbers themselves.
    #[test]
    fn the_dual_jacobian_is_that_of_omega(
        (model, parts, direction) in any_model().prop_flat_map(|m| {
            let n = 6 * m.dof();
            (Just(m), crate::common::numbers(n), crate::common::numbers(n))
        })
    ) {
        let m = 2 * model.dof();
        let k = 10.0;
        let split = |flat: &[f64]| [flat[..m].to_vec(), flat[m..2 * m].to_vec(), flat[2 * m..].to_vec()];
        let mut blocks = NodeBlocks::new(model.dof());
        ForwardDual::new(&model).evaluate(node(&split(&parts)), k, &mut blocks).expect("lengths agree");
        let [x, xdot, xddot] = split(&direction).map(DVector::from_vec);
        let derivative = &blocks.dx * x + &blocks.dxdot * xdot + &blocks.dxddot * xddot;
        let step = 1e-6;
        let shifted = |sign: f64| {
            let flat: Vec<f64> = parts.iter().zip(&direction).map(|(p, d)| p + sign * step * d).collect();
            omega_of(ControlForm::new(&model), &split(&flat), k)
        };
        let difference = (shifted(1.0) - shifted(-1.0)) / (2.0 * step);
        // Truncation and cancellation of the difference, larger where H is nearly singular.
        let sane = 1e-5 + 1e3 * bound(&model, &parts[..m]);
        let size = blocks.dx.amax().max(1.0);
        prop_assert!((derivative - &difference).amax() <= sane * size.max(difference.amax()));
        // (B80)
        assert_close!(&blocks.dxddot, &(DMatrix::identity(m, m) * 2.0), 100.0 * bound(&model, &parts[..m]));
    }

    #[test]
    fn a_used_right_hand_side_gives_the_same_bits((model, parts) in model_and_node()) {
        let other = [parts[2].clone(), parts[0].clone(), parts[1].clone()];
        let twice = |rhs: &mut dyn RightHandSide<f64, f64>| {
            let mut omega = vec![0.0; parts[0].len()];
            rhs.omega(node(&other), 3.0, &mut omega).expect("lengths agree");
            rhs.omega(node(&parts), 7.0, &mut omega).expect("lengths agree");
            omega
        };
        let b1 = omega_of(AlgorithmB1::new(&model), &parts, 7.0);
        prop_assert_eq!(twice(&mut AlgorithmB1::new(&model)), b1.as_slice());
        let control = omega_of(ControlForm::new(&model), &parts, 7.0);
        prop_assert_eq!(twice(&mut ControlForm::new(&model)), control.as_slice());
    }
}

/// Acceptance: 1000 random states of Digit, at `k = 1` and at the paper's.
#[test]
fn omega_on_digit_equals_the_definition_at_a_thousand_states() {
    let model = robot("digit_v3_pinned");
    let mut runner = proptest::test_runner::TestRunner::new(config(1000));
    let mut worst = 0.0_f64;
    for _ in 0..1000 {
        let n = 2 * model.dof();
        let state = (crate::common::numbers(n), crate::common::numbers(n), crate::common::numbers(n));
        let (x, xdot, xddot) = state.new_tree(&mut runner).expect("no filter").current();
        let parts = [x, xdot, xddot];
        for k in [1.0, 1e7] {
            let definition = omega_by_definition(&model, &parts, k);
            for omega in [omega_of(ControlForm::new(&model), &parts, k), omega_of(AlgorithmB1::new(&model), &parts, k)]
            {
                // Each half is compared relative to its own size.
                for half in [0, model.dof()] {
                    let rows = half..half + model.dof();
                    let (a, b) = (&omega.as_slice()[rows.clone()], &definition.as_slice()[rows]);
                    worst = worst.max(crate::common::relative_error(a, b));
                }
            }
        }
    }
    println!("worst relative error of Omega on Digit: {worst:e}");
    assert!(worst <= 1e-9, "{worst:e}");
}

/// The Jacobian by dual numbers of Algorithm B1 is that of the control form.
#[test]
fn the_jacobian_does_not_depend_on_the_form() {
    for model in robots().into_iter().chain([tree(6, 3)]) {
        let n = model.dof();
        let parts = [0.7, 1.3, 2.1].map(|f| crate::common::wave(2 * n, f));
        for k in PENALTIES {
            let (mut one, mut two) = (NodeBlocks::new(n), NodeBlocks::new(n));
            ForwardDual::new(&model).evaluate(node(&parts), k, &mut one).expect("lengths agree");
            let mut b1 = ForwardDual::of(AlgorithmB1::new(&model), n);
            b1.evaluate(node(&parts), k, &mut two).expect("lengths agree");
            let bound = 10.0 * bound(&model, &parts[0]);
            assert_close!(&one.dx, &two.dx, bound);
            assert_close!(&one.dxdot, &two.dxdot, bound);
            assert_close!(&one.dxddot, &two.dxddot, bound);
        }
    }
}

/// A pendulum at rest where a torque must hold it: the flow moves it to where a smaller one suffices.
#[test]
fn omega_of_a_resting_pendulum_by_hand() {
    let model = robot("pendulum_1");
    let parts = [vec![0.0, 0.0], vec![0.0, 0.0], vec![0.0, 0.0]];
    // Level, u = 9.81 / 2 and du/dq = 0: a maximum of |u|^2, so the flow does not move.
    assert_close!(&omega_of(ControlForm::new(&model), &parts, 5.0), &[0.0, 0.0], 1e-15);
    // At q: u = 4.905 cos q, Omega_P1 = -(2 / k) (du/dq) u = (2 / k) 4.905^2 sin q cos q.
    let q = 0.3_f64;
    let parts = [vec![q, 0.0], vec![0.0, 0.0], vec![0.0, 0.0]];
    let expected = 2.0 / 5.0 * 4.905 * 4.905 * q.sin() * q.cos();
    assert_close!(&omega_of(ControlForm::new(&model), &parts, 5.0), &[expected, 0.0], 1e-14);
}

#[test]
fn wrong_lengths_are_errors() {
    fn refused<S: AlgebraOver<f64> + Tanh>(model: &Model, short: &[S], long: &[S]) {
        let node = Node { t: S::zero(), x: long, xdot: short, xddot: long };
        let mut omega = long.to_vec();
        let words = "xdot: expected 4 entries, found 3";
        let by_control = ControlForm::new(model).omega(node, 1.0, &mut omega);
        crate::common::assert_refused(by_control, words);
        let by_b1 = AlgorithmB1::new(model).omega(node, 1.0, &mut omega);
        crate::common::assert_refused(by_b1, words);
    }
    let model = robot("pendulum_2");
    refused(&model, &[0.0; 3], &[0.0; 4]);
    refused(&model, &[0.0_f32; 3], &[0.0_f32; 4]);
    let (x, xdot) = (DVector::zeros(4), DVector::zeros(1));
    let control = control_at(&model, &mut Data::new(&model), &x, &xdot, &mut [0.0; 2]);
    crate::common::assert_refused(control, "xdot: expected 4 entries, found 1");
}
