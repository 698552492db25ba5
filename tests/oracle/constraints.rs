//! Constraints on positions of the robot, their gradients and Hessians.

use crate::common::config;
use crate::compare::{BOUND, Comparison, FLOOR, state};
use crate::python::Quantities;
use crate::random::any_robot;
use aghf::constraint::{CollisionSphere, Constraint, Evaluator, SolidClearance, Sphere, SphereClearance, Weights};
use aghf::geometry::Solid;
use aghf::model::Model;
use nalgebra::{DMatrix, Vector3};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::cell::RefCell;

/// The values of this library under the names in `Robot.constraints`.
fn constraints(model: &Model, q: &[f64]) -> Quantities {
    let n = model.dof();
    let at_link =
        |f: &aghf::model::Frame<f64>| CollisionSphere { body: f.body, centre: f.placement.translation, radius: 0.1 };
    let balls: Vec<CollisionSphere> = model.frames().iter().map(at_link).collect();
    let spheres = SphereClearance {
        balls: balls.clone(),
        spheres: vec![Sphere { centre: Vector3::new(0.3, -0.2, 0.5), radius: 0.25 }],
    };
    let half_space = SolidClearance {
        balls,
        solids: vec![Solid::half_space(&Vector3::new(0.6, 0.0, 0.8), -0.3)],
        names: Vec::new(),
    };
    let both = (spheres, half_space);
    let rows = Constraint::<f64>::dim(&both);
    let x = [q, &vec![0.0; n]].concat();
    let mut evaluator = Evaluator::new(model);
    let mut here = evaluator.at(&x).expect("lengths agree");
    let mut g = DMatrix::zeros(rows, 1);
    here.value(&both, g.as_mut_slice()).expect("the same robot");
    let w: Vec<f64> = (1..=rows).map(|j| j as f64).collect();
    let weights = Weights { first_order: &w, gauss_newton: Some(&vec![0.0; rows]) };
    let sums = here.weighted_derivatives(&both, weights).expect("the same robot");
    let gradient = DMatrix::from_column_slice(n, 1, &sums.gradient().as_slice()[..n]);
    let hessian = sums.hessian().view((0, 0), (n, n)).into_owned();
    let all = [("g", g), ("gradient", gradient), ("Hessian", hessian)];
    all.map(|(name, value)| (name.to_owned(), value)).into()
}

#[test]
fn places() {
    let all = RefCell::new(Comparison::default());
    let robot_and_state = any_robot().prop_flat_map(|r| (Just(r.clone()), state(&r.model)));
    let config = Config { source_file: Some(file!()), max_shrink_iters: 100, ..config(64) };
    let run = TestRunner::new(config).run(&robot_and_state, |(robot, [q, ..])| {
        let theirs = robot.oracle().call("constraints", &[&q]);
        let mut comparison = Comparison::default();
        let ours = constraints(&robot.model, &q);
        comparison.compare(&ours, &theirs, |_| FLOOR, |_| BOUND);
        prop_assert!(comparison.off.is_empty(), "{:?}", comparison.off);
        all.borrow_mut().merge(comparison);
        Ok(())
    });
    println!("{}", all.borrow());
    run.unwrap_or_else(|e| panic!("{e}"));
}
