//! The right-hand side of the flow and its Jacobians beside their definition in Pinocchio's quantities.

use crate::common::{config, node, numbers, solve_bound};
use crate::compare::{Errors, add_worst, listed, relative_error};
use crate::python::{Oracle, Quantities};
use crate::random::{Robot, any_robot};
use aghf::aghf::jacobian::{JacobianKind, NodeBlocks};
use aghf::aghf::{AlgorithmB1, ControlForm, RightHandSide, TheoremB3};
use aghf::model::Model;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::RefCell;

/// Penalties: one, where no term hides, and the paper's.
const PENALTIES: [f64; 2] = [1.0, 1e7];

/// `x`, `xdot`, `xddot`.
type Parts = [Vec<f64>; 3];

#[test]
fn omega_and_its_jacobians() {
    let worst = RefCell::new(Errors::new());
    let run = TestRunner::new(config(24)).run(&robot_and_node(), |(robot, parts)| {
        let (model, oracle) = (&robot.model, robot.oracle());
        // Two solves with H, on both sides, on top of the rounding of the dynamics.
        let bound = solve_bound(model, &parts[0], 1e-9);
        for k in PENALTIES {
            let mut errors = omega_errors(model, &oracle, &parts, k);
            errors.extend(jacobian_errors(model, &oracle, &parts, k));
            for (name, error) in &errors {
                // Differences of order four are as good as their step lets them be, which `tests/jacobian.rs` says.
                let bound = match name.ends_with("difference") {
                    true => 1e-5 + 1e5 * bound,
                    false => bound,
                };
                prop_assert!(
                    *error <= bound,
                    "{name} at k = {k:e} is off by {error:e}, more than {bound:e}"
                );
            }
            add_worst(&mut worst.borrow_mut(), &errors);
        }
        Ok(())
    });
    println!("{}", listed(&worst.borrow()));
    run.unwrap_or_else(|e| panic!("{e}"));
}

fn robot_and_node() -> impl Strategy<Value = (Robot, Parts)> {
    any_robot().prop_flat_map(|robot| {
        let part = || numbers(2 * robot.model.dof());
        let node = (part(), part(), part()).prop_map(|(x, xdot, xddot)| [x, xdot, xddot]);
        (Just(robot.clone()), node)
    })
}

/// The errors of every way to the right-hand side.
fn omega_errors(model: &Model, oracle: &Oracle, parts: &Parts, k: f64) -> Errors {
    let m = parts[0].len();
    let of = |rhs: &mut dyn RightHandSide<f64, f64>| {
        let mut omega = DMatrix::zeros(m, 1);
        rhs.omega(node(parts), k, omega.as_mut_slice())
            .expect("lengths agree");
        omega
    };
    let mut by_theorem = DMatrix::zeros(m, 1);
    theorem_b3(oracle, parts)
        .omega(node(parts), k, by_theorem.as_mut_slice())
        .expect("lengths agree");
    let theirs = oracle.define("omega", &parts.concat(), k);
    let ways = [
        ("control form", of(&mut ControlForm::new(model))),
        ("Algorithm B1", of(&mut AlgorithmB1::new(model))),
        ("Theorem B3 of Pinocchio's quantities", by_theorem),
    ];
    let error = |(way, ours)| {
        (
            format!("Omega, {way}"),
            halves_error(&ours, &theirs["Omega"], [1.0 / k, 1.0]),
        )
    };
    ways.map(error).into()
}

/// The errors of every Jacobian, all blocks.
fn jacobian_errors(model: &Model, oracle: &Oracle, parts: &Parts, k: f64) -> Errors {
    let theirs = oracle.define("jacobian", &parts.concat(), k);
    let omega = &oracle.define("omega", &parts.concat(), k)["Omega"];
    let error = |(name, kind): (String, JacobianKind)| {
        let mut ours = NodeBlocks::new(model.dof());
        let mut jacobian = kind.build(model);
        jacobian
            .at(node(parts), k, &mut ours)
            .expect("lengths agree");
        let blocks = [
            ("dx", &ours.dx),
            ("dxdot", &ours.dxdot),
            ("dxddot", &ours.dxddot),
        ];
        // Differences do not see what is small beside Omega.
        let floors = match kind {
            JacobianKind::Difference => halves(omega).map(|half| half.amax().max(1.0)),
            _ => [1.0 / k, 1.0],
        };
        let errors = blocks.map(|(block, ours)| halves_error(ours, &theirs[block], floors));
        let worst = errors.into_iter().fold(0.0, f64::max);
        (format!("Jacobian, {name}"), worst)
    };
    JacobianKind::by_name().map(error).collect()
}

/// The rows of `Omega_P1` and those of `Omega_P2`.
fn halves(m: &DMatrix<f64>) -> [DMatrix<f64>; 2] {
    let n = m.nrows() / 2;
    [0, n].map(|row| m.rows(row, n).into_owned())
}

/// The worse error of the two halves, each relative to its own largest entry: the first has parts of the size `1 / k`, which
/// is the floor where it is zero but for rounding, the second of the size `k`.
fn halves_error(ours: &DMatrix<f64>, theirs: &DMatrix<f64>, floors: [f64; 2]) -> f64 {
    let (ours, theirs) = (halves(ours), halves(theirs));
    let error = |i: usize| relative_error(&ours[i], &theirs[i], floors[i]);
    error(0).max(error(1))
}

/// Theorem B3 with everything that it is written in taken from Pinocchio.
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
    // Inverse dynamics at rest is H w and gravity.
    let w = vector(vdot) - &t.fd0;
    t.dh_dq_w = &at(&zero, w.as_slice())["dID/dq"] - &at(&zero, &zero)["dID/dq"];
    t
}
