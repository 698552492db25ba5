//! Every Jacobian of the right-hand side against dual numbers, block by block.

use crate::common::{config, model_and_node, node, robot, robots, solve_bound};
use aghf::flow::jacobian::{
    CentralDifference, ControlFormJacobian, ForwardDual, JacobianKind, NodeBlocks, NodeJacobian,
};
use aghf::flow::{AlgorithmB1, Node};
use aghf::model::{Model, random_tree};
use proptest::prelude::*;

/// Penalties: one, where no term hides, and the paper's.
const PENALTIES: [f64; 4] = [1.0, 1e3, 1e7, 1e9];

fn blocks(jacobian: &mut dyn NodeJacobian, parts: &[Vec<f64>; 3], k: f64) -> NodeBlocks {
    let mut out = NodeBlocks::new(parts[0].len() / 2);
    jacobian
        .evaluate(node(parts), k, &mut out)
        .expect("lengths agree");
    out
}

/// What rounding explains.
fn bound(model: &Model, x: &[f64]) -> f64 {
    solve_bound(model, x, 1e-10)
}

/// Asserts that the rows of $\Omega_{P1}$ and those of $\Omega_{P2}$ agree in all blocks, each relative to its own largest
/// entry: those of the first have the size `1 / k`, those of the second `k`, and rounding is relative to these.
fn assert_same(a: &NodeBlocks, b: &NodeBlocks, bound: f64) {
    assert_near(a, b, bound, f64::MIN_POSITIVE);
}

/// The same, where rows smaller than `floor` need only be as good as rows of that size.
fn assert_near(a: &NodeBlocks, b: &NodeBlocks, bound: f64, floor: f64) {
    let n = a.dx.nrows() / 2;
    for (name, a, b) in [
        ("dx", &a.dx, &b.dx),
        ("dxdot", &a.dxdot, &b.dxdot),
        ("dxddot", &a.dxddot, &b.dxddot),
    ] {
        for row in [0, n] {
            let error = (a.rows(row, n) - b.rows(row, n)).amax() / b.rows(row, n).amax().max(floor);
            assert!(
                error <= bound,
                "{name} from row {row} is off by {error:e}, more than {bound:e}"
            );
        }
    }
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn the_control_form_matches_duals((model, parts) in model_and_node()) {
        let bound = bound(&model, &parts[0]);
        for k in PENALTIES {
            let by_duals = blocks(&mut ForwardDual::new(&model), &parts, k);
            assert_same(&blocks(&mut ControlFormJacobian::new(&model), &parts, k), &by_duals, bound);
            // The same through the paper's route to Omega.
            let mut b1 = ForwardDual::of(AlgorithmB1::new(&model), model.dof());
            assert_same(&blocks(&mut ControlFormJacobian::new(&model), &parts, k), &blocks(&mut b1, &parts, k), 10.0 * bound);
        }
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

    /// Differences of order four come close; how close depends on how fast things change near a singular `H`.
    #[test]
    fn differences_come_close((model, parts) in model_and_node()) {
        let by_duals = blocks(&mut ForwardDual::new(&model), &parts, 10.0);
        let differences = blocks(&mut CentralDifference::new(&model), &parts, 10.0);
        assert_near(&differences, &by_duals, 1e-5 + 1e5 * bound(&model, &parts[0]), 1.0);
    }
}

/// States where terms vanish or coincide: a wrong factor of such a term shows elsewhere, a division by zero here.
#[test]
fn special_states() {
    let models = robots()
        .into_iter()
        .chain((0..6).map(|seed| random_tree(7, seed).expect("seven joints")));
    for model in models {
        let m = 2 * model.dof();
        let wave = |f: f64| {
            (0..m)
                .map(|i| (f * (i as f64 + 1.0)).sin())
                .collect::<Vec<_>>()
        };
        let half = |first: bool, x: Vec<f64>| -> Vec<f64> {
            x.iter()
                .enumerate()
                .map(|(i, x)| if (i < m / 2) == first { 0.0 } else { *x })
                .collect()
        };
        let zero = vec![0.0; m];
        let states = [
            [zero.clone(), zero.clone(), zero.clone()],
            [half(true, wave(0.7)), wave(1.3), wave(2.1)],
            [half(false, wave(0.7)), wave(1.3), wave(2.1)],
            [wave(0.7), half(true, wave(1.3)), wave(2.1)],
            [wave(0.7), half(false, wave(1.3)), zero.clone()],
            [zero.clone(), wave(1.3), zero.clone()],
        ];
        for parts in states {
            for k in PENALTIES {
                let by_duals = blocks(&mut ForwardDual::new(&model), &parts, k);
                assert_same(
                    &blocks(&mut ControlFormJacobian::new(&model), &parts, k),
                    &by_duals,
                    bound(&model, &parts[0]),
                );
            }
        }
    }
}

#[test]
fn wrong_sizes_are_errors() {
    let model = robot("pendulum_2");
    let (x, short) = ([0.0; 4], [0.0; 3]);
    for kind in [
        JacobianKind::ControlForm,
        JacobianKind::Dual,
        JacobianKind::Difference,
    ] {
        let mut jacobian = kind.build(&model);
        let node = Node {
            x: &x,
            xdot: &short,
            xddot: &x,
        };
        let error = jacobian
            .evaluate(node, 1.0, &mut NodeBlocks::new(2))
            .expect_err("short");
        assert!(
            error
                .to_string()
                .contains("xdot: expected 4 entries, found 3"),
            "{error}"
        );
        let node = Node {
            x: &x,
            xdot: &x,
            xddot: &x,
        };
        jacobian
            .evaluate(node, 1.0, &mut NodeBlocks::new(3))
            .expect_err("too large");
    }
}
