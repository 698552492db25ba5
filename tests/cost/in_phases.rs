//! A running cost in phases: that of each phase, in the order of its joints.

use crate::common::assert_refused;
use aghf::cost::{ControlDerivatives, ControlEffort, CostWithControl, InPhases, PointCost, Points, PointsDerivatives};
use aghf::model::{Joint, Model};
use aghf::urdf::{builtin_robot_text, read_robot, reroot};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Digit on its left and on its right foot, with the joint of the first one for each of the second.
fn feet() -> ([Model; 2], Vec<usize>) {
    let text = builtin_robot_text("digit_v3_pinned").expect("it is built in");
    let left = read_robot(text, "digit").expect("it is good");
    let right = reroot(&left, "right_toe_roll", "digit").expect("a link");
    let models = [left, right].map(|robot| Model::try_from(&robot).expect("it is good"));
    let names = models[1].joints().iter().map(Joint::name);
    let place = |name| models[0].joints().iter().position(|of| of.name() == name);
    let order = names.map(|name| place(name).expect("the same joints"));
    let order = order.collect();
    (models, order)
}

/// A term in the control that tells its entries apart.
fn term(index: usize, u: &[f64], out: &mut ControlDerivatives<f64>) -> bool {
    for (i, u) in u.iter().enumerate() {
        let weight = 1.0 + i as f64 + 0.1 * index as f64;
        out.gradient[i] = weight * u;
        out.curvature_weights[i] = weight * u;
        out.hessian[i] = weight;
    }
    true
}

#[test]
fn a_phase_has_the_cost_and_the_derivatives_of_its_robot_in_the_order_of_the_first_one() {
    let (models, order) = feet();
    let (n, points) = (models[0].dof(), 5);
    assert_ne!(order, (0..n).collect::<Vec<_>>());
    let effort = |k: usize| ControlEffort::new(&models[k]);
    let same = (0..n).collect();
    let costs = vec![(effort(0), same), (effort(1), order.clone())];
    let mut cost = InPhases::new(costs).expect("orders of the same joints");
    assert_eq!(cost.phases(), 2);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let states = DMatrix::from_fn(n, 3 * points, |_, _| rng.random_range(-1.0..1.0));
    let here = Points { first: 3, phase: 1, times: &[0.0; 5], states: &states, higher: &[] };
    let mut out = PointsDerivatives::new(n, points);
    cost.all_derivatives_with(here, &mut out, &mut term).expect("the same joints");
    let (mut values, mut controls) = (vec![0.0; points], DMatrix::zeros(n, points));
    cost.values_with_control(here, &mut values, &mut controls).expect("the same joints");
    for g in 0..points {
        let sorted = states.columns(3 * g, 3).select_rows(&order);
        let own = Points { first: 3 + g, times: &[0.0], states: &sorted, ..here };
        let (mut value, mut u) = ([0.0], DMatrix::zeros(n, 1));
        effort(1).values_with_control(own, &mut value, &mut u).expect("its joints");
        assert_eq!(value[0], values[g]);
        let mut found = PointsDerivatives::new(n, 1);
        let mut of_joints = |index: usize, u: &[f64], out: &mut ControlDerivatives<f64>| {
            let mut all = vec![0.0; n];
            for (u, joint) in u.iter().zip(&order) {
                all[*joint] = *u;
            }
            let mut of_walk = ControlDerivatives::new(n);
            let bends = term(index, &all, &mut of_walk);
            for (i, joint) in order.iter().enumerate() {
                out.gradient[i] = of_walk.gradient[*joint];
                out.curvature_weights[i] = of_walk.curvature_weights[*joint];
                out.hessian[i] = of_walk.hessian[*joint];
            }
            bends
        };
        let mut single = effort(1);
        single.all_derivatives_with(own, &mut found, &mut of_joints).expect("its joints");
        assert_eq!(found.costs[0], out.costs[g]);
        let (hessian, metric) = (out.hessians.get(g), out.metrics.get(g));
        let at = |i: usize| i - i % n + order[i % n];
        let (own_hessian, own_metric) = (found.hessians.get(0), found.metrics.get(0));
        let scale = own_hessian.amax();
        for i in 0..3 * n {
            assert_eq!(found.gradients[i], out.gradients[(at(i) % n, 3 * g + i / n)]);
            for j in 0..3 * n {
                for (own, all) in [(&own_hessian, &hessian), (&own_metric, &metric)] {
                    let off = (own[(i, j)] - all[(at(i), at(j))]).abs();
                    assert!(off <= 1e-14 * scale, "{off} of {scale} at {i}, {j}");
                }
            }
        }
        for (u, joint) in u.iter().zip(&order) {
            assert_eq!(*u, controls[(*joint, g)]);
        }
    }
}

#[test]
fn an_order_that_is_no_permutation_and_a_phase_that_is_not_there_are_refused() {
    let (models, mut order) = feet();
    let effort = || ControlEffort::new(&models[1]);
    order[0] = order[1];
    assert_refused(InPhases::new(vec![(effort(), order)]), "phases: cost: an order is no permutation of the joints");
    let n = models[1].dof();
    let mut cost = InPhases::new(vec![(effort(), (0..n).collect())]).expect("one phase");
    let states = DMatrix::zeros(n, 3);
    let here = Points { first: 0, phase: 1, times: &[0.0], states: &states, higher: &[] };
    let refused = cost.values(here, &mut [0.0]);
    assert_refused(refused, "phases: cost: phase 1 of 1 was asked for");
}
