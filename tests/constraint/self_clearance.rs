//! The clearance of a robot from itself.

use crate::common::{any_model, assert_refused, config, numbers, robot, wave};
use crate::derivatives::{ValueAlone, contracted};
use aghf::constraint::{CollisionSphere, Constraint, Evaluator, Quantity, SelfClearance, Weights};
use aghf::model::{Model, random_tree};
use nalgebra::Vector3;
use proptest::prelude::*;
use std::collections::BTreeSet;

fn ball(body: Option<usize>, at: [f64; 3]) -> CollisionSphere {
    CollisionSphere { body, centre: Vector3::from(at), radius: 0.1 }
}

/// The joints that carry a body.
fn carriers(model: &Model, body: Option<usize>) -> BTreeSet<usize> {
    std::iter::successors(body, |i| model.joints()[*i].parent()).collect()
}

proptest! {
    #![proptest_config(config(64))]

    /// Two balls on any bodies: joints that carry both have zero derivatives, to the last bit, and the others those of
    /// dual numbers.
    #[test]
    fn common_joints_drop_out((model, x, bodies) in any_model().prop_flat_map(|model| {
        let n = model.dof();
        let body = || prop::option::of(0..n);
        (Just(model), numbers(2 * n), (body(), body()))
    })) {
        let n = model.dof();
        let balls = vec![ball(bodies.0, [0.2, -0.3, 0.5]), ball(bodies.1, [-0.4, 0.1, 0.3])];
        let constraint = SelfClearance { balls, pairs: vec![[0, 1], [1, 0]] };
        let weights = Weights { first_order: &[0.7, 0.4], gauss_newton: Some(&[1.9, 0.3]) };
        let (gradient, hessian) = contracted(&model, &constraint, &x, weights);
        let (by_jets, by_jets2) = contracted(&model, &ValueAlone(constraint), &x, weights);
        assert_close!(&gradient, &by_jets, 1e-12);
        assert_close!(&hessian, &by_jets2, 1e-12);
        let (first, second) = (carriers(&model, bodies.0), carriers(&model, bodies.1));
        let moving: BTreeSet<usize> = first.symmetric_difference(&second).copied().collect();
        for j in (0..2 * n).filter(|j| !moving.contains(j)) {
            prop_assert_eq!(gradient[j], 0.0);
            prop_assert_eq!(hessian.row(j).amax(), 0.0);
            prop_assert_eq!(hessian.column(j).amax(), 0.0);
        }
    }
}

/// Balls on all pairs of bodies of a tree at once, including pairs on different branches, and each pair alone.
#[test]
fn branches_beside_each_other() {
    let model = random_tree(8, 3).expect("eight joints");
    let balls: Vec<_> = (0..8).map(|i| ball(Some(i), [0.2, 0.1 * i as f64, -0.3])).collect();
    let pairs: Vec<_> = (0..8).flat_map(|i| (0..8).map(move |j| [i, j])).collect();
    let x = wave(16, 0.9);
    let (w, c) = (wave(64, 0.7), wave(64, 1.9));
    let compare = |pairs: &[[usize; 2]]| {
        let constraint = SelfClearance { balls: balls.clone(), pairs: pairs.to_vec() };
        let weights = Weights { first_order: &w[..pairs.len()], gauss_newton: Some(&c[..pairs.len()]) };
        let (gradient, hessian) = contracted(&model, &constraint, &x, weights);
        let (by_jets, by_jets2) = contracted(&model, &ValueAlone(constraint), &x, weights);
        assert_close!(&gradient, &by_jets, 1e-12);
        assert_close!(&hessian, &by_jets2, 1e-12);
    };
    compare(&pairs);
    let mut beside = 0;
    for pair in pairs {
        compare(&[pair]);
        let [first, second] = pair.map(|i| carriers(&model, Some(i)));
        beside += usize::from(!first.is_subset(&second) && !second.is_subset(&first));
    }
    assert!(beside > 4, "only {beside} pairs are beside each other");
}

/// A pendulum of one link and a ball on the base: $|p|^2$ by hand.
#[test]
fn a_pendulum_by_hand() {
    let model = robot("pendulum_1");
    let balls = vec![ball(Some(0), [-1.0, 0.0, 0.0]), ball(None, [0.0, 0.0, 2.0])];
    let constraint = SelfClearance { balls, pairs: vec![[0, 1]] };
    // As for a sphere: |p - c|^2 = 5 - 4 sin q.
    let q = 0.3_f64;
    let mut g = [0.0];
    let mut evaluator = Evaluator::<f64>::new(&model);
    let x = [q, 0.0];
    let here = evaluator.at(&x).expect("one joint");
    here.value(&constraint, &mut g).expect("one row");
    assert_close!(&g, &[0.04 - 5.0 + 4.0 * q.sin()], 1e-14);
    let weights = Weights { first_order: &[2.0], gauss_newton: Some(&[3.0]) };
    let (gradient, hessian) = contracted(&model, &constraint, &x, weights);
    assert_close!(&gradient, &[8.0 * q.cos(), 0.0], 1e-14);
    let expected = -8.0 * q.sin() + 3.0 * 16.0 * q.cos().powi(2);
    assert_close!(&hessian, &[expected, 0.0, 0.0, 0.0], 1e-14);
    assert_eq!(constraint.row_scales(), [0.4]);
}

#[test]
fn labels_and_errors() {
    let model = robot("kinova_gen3");
    let tool = CollisionSphere::at_link(&model, "end_effector_link", 0.1).expect("it is there");
    let balls = vec![tool, ball(None, [0.0; 3]), ball(Some(9), [0.0; 3])];
    let clearance = |pairs: &[[usize; 2]]| SelfClearance { balls: balls.clone(), pairs: pairs.to_vec() };
    let label = clearance(&[[0, 1]]).label(0, &model);
    assert!(label.name.starts_with("distance of link '") && label.name.contains("' from link '"), "{}", label.name);
    assert_eq!((label.unit, label.quantity), ("m", Quantity::SelfCollision));
    assert_eq!(clearance(&[[0, 3]]).label(0, &model).name, "row 0 of the constraint");

    let x = wave(14, 0.4);
    let mut evaluator = Evaluator::<f64>::new(&model);
    let mut here = evaluator.at(&x).expect("7 joints");
    let weights = Weights { first_order: &[1.0], gauss_newton: Some(&[1.0]) };
    let no_body = "bodies of the robot of a constraint: expected 10 entries, found 7";
    assert_refused(here.value(&clearance(&[[0, 1]]), &mut [0.0]), no_body);
    assert_refused(here.weighted_derivatives(&clearance(&[[2, 0]]), weights), no_body);
    let two = SelfClearance { balls: balls[..2].to_vec(), pairs: vec![[0, 2]] };
    let no_ball = "balls of the pairs of a constraint: expected 3 entries, found 2";
    assert_refused(here.value(&two, &mut [0.0]), no_ball);
    assert_refused(here.weighted_derivatives(&two, weights), no_ball);
    assert!(here.weighted_derivatives(&two, Weights { first_order: &[0.0], gauss_newton: None }).is_ok());
}
