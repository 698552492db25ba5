//! The right-hand side of the flow and its Jacobians compared with their definition in Pinocchio's quantities.

use crate::common::{condition, config, node, numbers};
use crate::compare::{Comparison, relative_error};
use crate::python::{Oracle, Quantities};
use crate::random::{Robot, any_robot};
use aghf::flow::jacobian::{JacobianKind, NodeBlocks};
use aghf::flow::{AlgorithmB1, ControlForm, RightHandSide, TheoremB3};
use aghf::model::Model;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::cell::RefCell;

/// Penalties: one, where no term is negligible, and the paper's.
const PENALTIES: [f64; 2] = [1.0, 1e7];

/// `x`, `xdot`, `xddot`.
type Parts = [Vec<f64>; 3];

#[test]
fn omega_and_its_jacobians() {
    let all = RefCell::new(Comparison::default());
    let config = Config { source_file: Some(file!()), max_shrink_iters: 100, ..config(128) };
    let run = TestRunner::new(config).run(&robot_and_node(), |(robot, parts)| {
        let (model, oracle) = (&robot.model, robot.oracle());
        for k in PENALTIES {
            let mut comparison = compare_omega(model, &oracle, &parts, k);
            comparison.merge(compare_jacobians(model, &oracle, &parts, k));
            prop_assert!(comparison.off.is_empty(), "k = {k:e}: {:?}", comparison.off);
            all.borrow_mut().merge(comparison);
        }
        Ok(())
    });
    println!("{}", all.borrow());
    run.unwrap_or_else(|e| panic!("{e}"));
}

/// The largest relative error of a result of two solves with `H` on both sides. The oracle has its own mass matrix and
/// differences, with independent rounding: its errors grow with the square of the condition number.
fn bound(model: &Model, parts: &Parts) -> f64 {
    1e-9 + 1e-15 * condition(model, &parts[0]).powi(2)
}

fn robot_and_node() -> impl Strategy<Value = (Robot, Parts)> {
    let robot = any_robot().prop_map(Robot::without_friction);
    robot.prop_flat_map(|robot| {
        let part = || numbers(2 * robot.model.dof());
        let node = (part(), part(), part()).prop_map(|(x, xdot, xddot)| [x, xdot, xddot]);
        (Just(robot.clone()), node)
    })
}

/// Compares every form of the right-hand side.
fn compare_omega(model: &Model, oracle: &Oracle, parts: &Parts, k: f64) -> Comparison {
    let m = parts[0].len();
    let of = |rhs: &mut dyn RightHandSide<f64, f64>| {
        let mut omega = DMatrix::zeros(m, 1);
        rhs.omega(node(parts), k, omega.as_mut_slice()).expect("lengths agree");
        omega
    };
    let mut by_theorem = DMatrix::zeros(m, 1);
    theorem_b3(oracle, parts).omega(node(parts), k, by_theorem.as_mut_slice()).expect("lengths agree");
    let theirs = oracle.define("omega", &parts.concat(), k);
    let ways = [
        ("control form", of(&mut ControlForm::new(model))),
        ("Algorithm B1", of(&mut AlgorithmB1::new(model))),
        ("Theorem B3 of Pinocchio's quantities", by_theorem),
    ];
    let mut comparison = Comparison::default();
    for (way, ours) in ways {
        let error = halves_error(&ours, &theirs["Omega"], [1.0 / k, 1.0]);
        comparison.add(&format!("Omega, {way}"), error, bound(model, parts));
    }
    comparison
}

/// Compares all blocks of every Jacobian.
///
/// The bound is ten times that of Omega: the weights of the differences in the definition sum to 4.4, and Omega is
/// larger at their points. Equally accurate rules (two more angles, half the step) change the definition by up to twice
/// the bound of Omega.
fn compare_jacobians(model: &Model, oracle: &Oracle, parts: &Parts, k: f64) -> Comparison {
    let theirs = oracle.define("jacobian", &parts.concat(), k);
    let omega = &oracle.define("omega", &parts.concat(), k)["Omega"];
    let rounding = 10.0 * bound(model, parts);
    let mut comparison = Comparison::default();
    for (name, kind) in JacobianKind::by_name() {
        let mut ours = NodeBlocks::new(model.dof());
        let mut jacobian = kind.build(model);
        jacobian.evaluate(node(parts), k, &mut ours).expect("lengths agree");
        let (floors, bound) = match kind {
            // Differences lose entries that are small beside Omega, and their step preserves only half of the digits.
            JacobianKind::Difference => {
                let floors = halves(omega).map(|half| half.amax().max(1.0));
                (floors, 1e-6 + rounding)
            }
            _ => ([1.0 / k, 1.0], rounding),
        };
        for (block, ours) in [("dx", &ours.dx), ("dxdot", &ours.dxdot), ("dxddot", &ours.dxddot)] {
            let error = halves_error(ours, &theirs[block], floors);
            comparison.add(&format!("Jacobian, {name}"), error, bound);
        }
    }
    comparison
}

/// The rows of `Omega_P1` and those of `Omega_P2`.
fn halves(m: &DMatrix<f64>) -> [DMatrix<f64>; 2] {
    let n = m.nrows() / 2;
    [0, n].map(|row| m.rows(row, n).into_owned())
}

/// The larger error of the two halves, each relative to its own largest entry: the first has parts of the size `1 / k`,
/// which is the floor where it is zero up to rounding, the second of the size `k`.
fn halves_error(ours: &DMatrix<f64>, theirs: &DMatrix<f64>, floors: [f64; 2]) -> f64 {
    let (ours, theirs) = (halves(ours), halves(theirs));
    let error = |i: usize| relative_error(&ours[i], &theirs[i], floors[i]);
    error(0).max(error(1))
}

/// Theorem B3 with all of its quantities from Pinocchio.
fn theorem_b3(oracle: &Oracle, [x, xdot, _]: &Parts) -> TheoremB3<f64> {
    let n = x.len() / 2;
    let ((q, v), (qdot, vdot)) = (x.split_at(n), xdot.split_at(n));
    let zero = vec![0.0; n];
    let at = |v: &[f64], a: &[f64]| oracle.call("dynamics", &[q, v, a, &zero]);
    let column = |name: &str, of: &Quantities| of[name].column(0).into_owned();
    let vector = DVector::from_column_slice;
    let free = at(v, &zero);
    let mut t = TheoremB3::new(n);
    t.h = free["H"].clone();
    t.hdot = at(qdot, &zero)["Hdot"].clone();
    t.c = column("C", &free);
    t.cdot = &free["dID/dq"] * vector(qdot) + &free["dID/dv"] * vector(vdot);
    t.fd0 = column("FD", &free);
    t.dfd0_dq = free["dFD/dq"].clone();
    t.dfd0_dv = free["dFD/dv"].clone();
    // Inverse dynamics at rest are H w and gravity.
    let w = vector(vdot) - &t.fd0;
    t.dh_dq_w = &at(&zero, w.as_slice())["dID/dq"] - &at(&zero, &zero)["dID/dq"];
    t
}
