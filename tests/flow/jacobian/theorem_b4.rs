//! Theorem B4 over other scalars and for wrong lengths. Its blocks are proved over the prime field (`verify::field`),
//! and its Jacobian is compared with dual numbers like every other (`verify::duals`).

use crate::common::{config, model_and_node, node, robot, wave};
use aghf::flow::Node;
use aghf::flow::jacobian::{NodeBlocks, NodeJacobian, TheoremB4};
use aghf::model::Model;
use aghf::scalar::AlgebraOver;
use num_dual::Dual64;
use proptest::prelude::*;

fn blocks_of(jacobian: &mut impl NodeJacobian, parts: &[Vec<f64>; 3], k: f64) -> NodeBlocks {
    let mut blocks = NodeBlocks::new(parts[0].len() / 2);
    jacobian.evaluate(node(parts), k, &mut blocks).expect("lengths agree");
    blocks
}

proptest! {
    #![proptest_config(config(64))]

    /// A workspace that was used elsewhere gives the same bits as a fresh one.
    #[test]
    fn a_used_jacobian_gives_the_same_bits((model, parts) in model_and_node()) {
        let [x, xdot, xddot] = parts.clone();
        let mut jacobian = TheoremB4::new(&model);
        blocks_of(&mut jacobian, &[xddot, x, xdot], 3.0);
        let fresh = blocks_of(&mut TheoremB4::new(&model), &parts, 7.0);
        prop_assert_eq!(blocks_of(&mut jacobian, &parts, 7.0), fresh);
    }
}

/// Duals carry the value along to rounding, single precision to its precision.
#[test]
fn it_runs_over_other_scalars() {
    fn of<S: AlgebraOver<f64>>(model: &Model, parts: &[Vec<f64>; 3]) -> Vec<S> {
        let lift = |part: &Vec<f64>| Vec::from_iter(part.iter().map(|x| S::lift(*x)));
        let [x, xdot, xddot] = parts.each_ref().map(lift);
        let t = S::zero();
        let node: Node<'_, S> = Node { t, x: &x, xdot: &xdot, xddot: &xddot };
        let mut blocks = NodeBlocks::new(model.dof());
        TheoremB4::new(model).blocks(node, 5.0, &mut blocks).expect("lengths agree");
        blocks.dx.as_slice().to_vec()
    }
    let model = robot("kinova_gen3");
    let parts = [0.7, 1.3, 2.1].map(|f| wave(2 * model.dof(), f));
    let double = of::<f64>(&model, &parts);
    let of_duals: Vec<f64> = of::<Dual64>(&model, &parts).iter().map(|x| x.re).collect();
    assert_close!(&double, &of_duals, 1e-10);
    let single: Vec<f64> = of::<f32>(&model, &parts).into_iter().map(f64::from).collect();
    assert_close!(&single, &double, 1e-2);
}

#[test]
fn wrong_lengths_are_errors() {
    let model = robot("pendulum_2");
    let (long, short) = (vec![0.0; 4], vec![0.0; 3]);
    let mut jacobian = TheoremB4::new(&model);
    for wrong in 0..3 {
        let mut parts = [long.clone(), long.clone(), long.clone()];
        parts[wrong] = short.clone();
        let refused = jacobian.evaluate(node(&parts), 1.0, &mut NodeBlocks::new(2));
        crate::common::assert_refused(refused, "expected 4 entries, found 3");
    }
    let good = [long.clone(), long.clone(), long];
    let too_large = jacobian.evaluate(node(&good), 1.0, &mut NodeBlocks::new(3));
    crate::common::assert_refused(too_large, "dx: expected 4 entries, found 6");
}
