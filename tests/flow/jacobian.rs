//! Every Jacobian of the right-hand side against dual numbers, block by block.

mod registry;
mod theorem_b4;

use crate::common::{
    any_model, assert_refused, assert_right, config, model_and_node, node, robot, robots, state, wave,
};
use aghf::flow::Node;
use aghf::flow::jacobian::{
    CentralDifference, ControlFormJacobian, ForwardDual, JacobianKind, NodeBlocks, NodeJacobian,
};
use aghf::model::random_tree;
use aghf::verify::duals::{CheckOptions, State, check_jacobian, check_jacobian_at};
use proptest::prelude::*;

/// Penalties: one, where no term is negligible, and the paper's.
const PENALTIES: [f64; 4] = [1.0, 1e3, 1e7, 1e9];

fn blocks(jacobian: &mut dyn NodeJacobian, parts: &[Vec<f64>; 3], k: f64) -> NodeBlocks {
    let mut out = NodeBlocks::new(parts[0].len() / 2);
    jacobian.evaluate(node(parts), k, &mut out).expect("lengths agree");
    out
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn the_control_form_matches_duals(model in any_model(), seed in any::<u64>()) {
        let options = CheckOptions { samples: 2, seed, penalties: PENALTIES.to_vec() };
        let jacobian = &mut ControlFormJacobian::new(&model);
        assert_right(&model, check_jacobian(&model, "control form", jacobian, &options));
    }

    /// States with some zero entries.
    #[test]
    fn the_control_form_matches_duals_where_numbers_vanish((model, parts) in model_and_node()) {
        let (jacobian, states) = (&mut ControlFormJacobian::new(&model), [state(parts)]);
        let findings = check_jacobian_at(&model, "control form", jacobian, &states, &PENALTIES);
        assert_right(&model, findings);
    }

    #[test]
    fn a_used_jacobian_gives_the_same_bits((model, parts) in model_and_node()) {
        let other = [parts[2].clone(), parts[0].clone(), parts[1].clone()];
        for (_, kind) in JacobianKind::by_name() {
            let mut used = kind.build(&model);
            blocks(used.as_mut(), &other, 3.0);
            let fresh = blocks(kind.build(&model).as_mut(), &parts, 7.0);
            prop_assert_eq!(blocks(used.as_mut(), &parts, 7.0), fresh);
        }
    }

    /// Differences of order four, relative to the largest entry of all blocks: they lose entries that are small beside
    /// it. Their error is the fourth power of the step, 3e-13, times a fifth derivative, which on robots of this size
    /// is below 1e5 of the first.
    #[test]
    fn differences_come_close((model, parts) in model_and_node()) {
        let by_duals = blocks(&mut ForwardDual::new(&model), &parts, 10.0);
        let differences = blocks(&mut CentralDifference::new(&model), &parts, 10.0);
        let pairs = [
            (&differences.dx, &by_duals.dx),
            (&differences.dxdot, &by_duals.dxdot),
            (&differences.dxddot, &by_duals.dxddot),
        ];
        let largest = pairs.iter().fold(0.0_f64, |m, (_, b)| m.max(b.amax()));
        for (a, b) in pairs {
            let error = (a - b).amax() / largest;
            prop_assert!(error <= 1e-7, "{error:e}");
        }
    }
}

/// States where terms vanish or coincide: a division by zero would show here, a wrong factor in the other tests.
#[test]
fn special_states() {
    let models = robots().into_iter().chain((0..6).map(|seed| random_tree(7, seed).expect("seven joints")));
    for model in models {
        let m = 2 * model.dof();
        let wave = |f: f64| wave(m, f);
        let half = |first: bool, mut x: Vec<f64>| {
            let halves = x.split_at_mut(m / 2);
            (if first { halves.0 } else { halves.1 }).fill(0.0);
            x
        };
        let zero = vec![0.0; m];
        let states: Vec<State> = [
            [zero.clone(), zero.clone(), zero.clone()],
            [half(true, wave(0.7)), wave(1.3), wave(2.1)],
            [half(false, wave(0.7)), wave(1.3), wave(2.1)],
            [wave(0.7), half(true, wave(1.3)), wave(2.1)],
            [wave(0.7), half(false, wave(1.3)), zero.clone()],
            [zero.clone(), wave(1.3), zero.clone()],
        ]
        .into_iter()
        .map(state)
        .collect();
        let jacobian = &mut ControlFormJacobian::new(&model);
        let findings = check_jacobian_at(&model, "control form", jacobian, &states, &PENALTIES);
        assert_right(&model, findings);
    }
}

#[test]
fn wrong_sizes_are_errors() {
    let model = robot("pendulum_2");
    let (x, short) = ([0.0; 4], [0.0; 3]);
    for (_, kind) in JacobianKind::by_name() {
        let mut jacobian = kind.build(&model);
        let mut refused = |xdot: &[f64], size: usize, words: &str| {
            let (t, x, xddot) = (0.0, &x, &x);
            let node = Node { t, x, xdot, xddot };
            let result = jacobian.evaluate(node, 1.0, &mut NodeBlocks::new(size));
            assert_refused(result, words);
        };
        refused(&short, 2, "xdot: expected 4 entries, found 3");
        refused(&x, 3, "dx: expected 4 entries, found 6");
    }
}
