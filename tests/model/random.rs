//! Models made at random.

use crate::common::torques_somewhere;
use aghf::dynamics::{Data, crba};
use aghf::model::{Joint, JointKind, Model, random_tree};
use nalgebra::DMatrix;

#[test]
fn random_trees_repeat_with_their_seed() {
    let shown = |n, seed| format!("{:?}", random_tree(n, seed).expect("n > 0"));
    assert_eq!(shown(9, 5), shown(9, 5));
    // The name tells the seed, so compare what it does.
    let torques = |n, seed| torques_somewhere(&random_tree(n, seed).expect("n > 0"));
    assert_ne!(torques(9, 5), torques(9, 6));
}

#[test]
fn random_trees_are_of_all_kinds() {
    let trees: Vec<_> = (0..20).map(|seed| random_tree(8, seed).expect("n > 0")).collect();
    let some = |what: &dyn Fn(&Model, &Joint<f64>) -> bool| trees.iter().any(|t| t.joints().iter().any(|j| what(t, j)));
    for kind in [JointKind::Revolute, JointKind::Continuous, JointKind::Prismatic] {
        assert!(some(&|_, j| j.kind() == kind), "{kind:?}");
    }
    let axis = |what: &'static dyn Fn(f64) -> bool| some(&|_, j| j.axis().iter().all(|x| what(*x)));
    assert!(axis(&|x| x == 0.0 || x == -1.0), "along a negative coordinate axis");
    assert!(axis(&|x| x.abs() > 0.1 && x.abs() < 0.9), "oblique");
    let children = |t: &Model, parent| t.joints().iter().filter(|j| j.parent() == parent).count();
    assert!(some(&|t, j| j.parent().is_some() && children(t, j.parent()) > 1), "a body with two children");
    assert!(some(&|t, j| j.parent().is_none() && children(t, None) > 1), "a base with two children");
    for tree in &trees {
        assert_eq!(tree.dof(), 8);
        assert!(tree.joints().iter().all(|j| (j.axis().norm() - 1.0).abs() < 1e-14));
    }
}

#[test]
fn mass_matrices_of_random_trees_are_positive_definite() {
    for (n, seed) in (1..9).flat_map(|n| (0..10).map(move |seed| (n, seed))) {
        let tree = random_tree(n, seed).expect("n > 0");
        tree.check_regular("random").expect("all bodies have inertia");
        let q: Vec<f64> = (0..n).map(|i| 3.0 * (i as f64 + seed as f64).sin()).collect();
        let mut h = DMatrix::zeros(n, n);
        crba(&tree, &mut Data::new(&tree), &q, &mut h).expect("lengths agree");
        let smallest = h.symmetric_eigenvalues().min();
        assert!(smallest > 1e-6, "{n} {seed}: {smallest}");
    }
}
