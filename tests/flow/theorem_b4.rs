//! Theorem B4 block by block: every numbered function against the dual derivative of the quantity that it differentiates.
//!
//! The quantities on the dual side never meet a tensor. They are functions of the node over any scalar, made of `crba`,
//! `bias`, `aba` and of duals of these; a second level of duals differentiates them.

use crate::common::derivatives::{Derivatives, Parts, Quantity, node};
use crate::common::{config, model_and_node, robot, robots};
use aghf::flow::Node;
use aghf::flow::jacobian::theorem_b4::Quantities;
use aghf::flow::jacobian::{ForwardDual, JacobianKind, NodeBlocks, NodeJacobian, TheoremB4};
use aghf::linalg::Ldlt;
use aghf::model::{Model, random_tree};
use aghf::scalar::AlgebraOver;
use aghf::verify::reference::{At, bias_rate, constant, jacobian, mass, mass_rate, vector};
use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;
use proptest::prelude::*;

/// Penalties: one, where no term hides, and the paper's.
const PENALTIES: [f64; 2] = [1.0, 1e7];

/// The rounding error when `H` is solved with `solves` times.
fn bound(model: &Model, parts: &Parts<f64>, solves: i32) -> f64 {
    let h = mass(model, &parts[0][..model.dof()]).expect("lengths agree");
    let eigenvalues = h.symmetric_eigenvalues();
    1e-9 + 1e-15 * (eigenvalues.max() / eigenvalues.min()).powi(solves)
}

/// Asserts that each of the four blocks of a `2 N` by `2 N` matrix is right in its own size, the upper two and the lower
/// two after they are multiplied by a factor each: a `1 / k` must not hide an error, and where a `k` magnifies the
/// rounding of a small number, that is not one.
fn close_blocks(
    what: &str,
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    [upper, lower]: [f64; 2],
    bound: f64,
) {
    let n = a.nrows() / 2;
    for (row, factor) in [(0, upper), (n, lower)] {
        for column in [0, n] {
            let block = |m: &DMatrix<f64>| m.view((row, column), (n, n)) * factor;
            close(
                &format!("{what} ({row}, {column})"),
                &block(a),
                &block(b),
                bound,
            );
        }
    }
}

fn close<'a>(
    what: &str,
    a: impl IntoIterator<Item = &'a f64>,
    b: impl IntoIterator<Item = &'a f64>,
    bound: f64,
) {
    let error = crate::common::relative_error(a, b);
    assert!(
        error <= bound,
        "{what} is off by {error:e}, bound {bound:e}"
    );
}

/// (B49) to (B52).
fn check_terms(t: &Quantities<f64>, reference: &Derivatives, bound: f64) {
    for (of, found) in [
        (Quantity::Gamma, t.gamma()),
        (Quantity::Alpha1, t.alpha_1()),
        (Quantity::Alpha2, t.alpha_2()),
        (Quantity::CapitalGamma, t.capital_gamma()),
    ] {
        close(&format!("{of:?}"), &found, &reference.value(of), bound);
    }
}

/// (B53) to (B60), (B66) to (B70), (B76), (B77) and (B79): what is `N` by `N`.
fn check_parts(t: &Quantities<f64>, reference: &Derivatives, bound: f64) {
    use Quantity::{Alpha1, Alpha2, CapitalGamma, Gamma};
    // Part 0 is x, 1 is xdot, 2 is xddot; half 0 is P1, 1 is P2.
    for (what, found, of, part, half) in [
        ("(B53)", t.dgamma_dx_p1(), Gamma, 0, 0),
        ("(B54)", t.dgamma_dx_p2(), Gamma, 0, 1),
        ("(B55)", t.dalpha_1_dx_p1(), Alpha1, 0, 0),
        ("(B56)", t.dalpha_2_dx_p1(), Alpha2, 0, 0),
        ("(B57)", t.dalpha_1_dx_p2(), Alpha1, 0, 1),
        ("(B58)", t.dalpha_2_dx_p2(), Alpha2, 0, 1),
        ("(B59)", t.dcapital_gamma_dx_p1(), CapitalGamma, 0, 0),
        ("(B60)", t.dcapital_gamma_dx_p2(), CapitalGamma, 0, 1),
        ("(B66)", t.dalpha_1_dxdot_p2(), Alpha1, 1, 1),
        ("(B67)", t.dalpha_2_dxdot_p2(), Alpha2, 1, 1),
        ("(B68)", t.dgamma_dxdot_p1_unsimplified(), Gamma, 1, 0),
        ("(B69)", t.dgamma_dxdot_p2_unsimplified(), Gamma, 1, 1),
        ("(B70)", t.dcapital_gamma_dxdot_p2(), CapitalGamma, 1, 1),
        ("(B76)", t.dgamma_dxdot_p1(), Gamma, 1, 0),
        ("(B77)", t.dgamma_dxdot_p2(), Gamma, 1, 1),
        ("(B79)", t.dgamma_dxddot_p2(), Gamma, 2, 1),
    ] {
        close(what, &found, &reference.derivative(of, part, half), bound);
    }
    // What the theorem leaves out because it vanishes.
    let zero = DMatrix::zeros(reference.n, reference.n);
    for of in [Alpha1, Alpha2, CapitalGamma] {
        for (part, half) in [(1, 0), (2, 0), (2, 1)] {
            close(
                "left out",
                &zero,
                &reference.derivative(of, part, half),
                0.0,
            );
        }
    }
    close("left out", &zero, &reference.derivative(Gamma, 2, 0), 0.0);
}

/// (B74) and (B75): `Hdot` and `Cdot` are rates, here differentiated in the velocity of the rate.
fn check_derivatives_of_rates(t: &Quantities<f64>, model: &Model, parts: &Parts<f64>) {
    let n = model.dof();
    let z = parts.concat();
    // Differentiated in xdot alone, the rest held fixed.
    let moved = |xdot: &[Dual64]| {
        let mut z = constant(&z);
        z[2 * n..4 * n].copy_from_slice(xdot);
        z
    };
    let hdot = |xdot: &[Dual64]| mass_rate(&At::new(model, &moved(xdot), 1.0));
    let expected = jacobian(&parts[1], hdot).expect("lengths agree");
    let expected = expected.columns(0, n).into_owned();
    close("(B74)", t.dhdot_dxdot_p1().entries(), &expected, 1e-9);
    let cdot = |xdot: &[Dual64]| bias_rate(&At::new(model, &moved(xdot), 1.0));
    let expected = jacobian(&parts[1], cdot).expect("lengths agree");
    close(
        "(B75)",
        t.dcdot_dxdot_p1(),
        &expected.columns(0, n).into_owned(),
        1e-9,
    );
    close(
        "(B75) in P2",
        t.dcdot_dxdot_p2(),
        &expected.columns(n, n).into_owned(),
        1e-9,
    );
}

/// $\partial (H^T H)^{-1} / \partial x_{P1}$ times a vector, which (B45) to (B47) share.
fn check_derivative_of_the_inverse(t: &Quantities<f64>, model: &Model, q: &[f64], bound: f64) {
    let n = model.dof();
    let w = DVector::from_fn(n, |i, _| (1.0 + i as f64).cos());
    let solved = |q: &[Dual64]| {
        let mut ldlt = Ldlt::new(n);
        ldlt.factorise(&mass(model, q)?);
        let mut y = constant(w.as_slice());
        ldlt.solve(&mut y);
        ldlt.solve(&mut y);
        Ok(vector(&y))
    };
    let expected = jacobian(q, solved).expect("lengths agree");
    close("d(H^T H)^-1", &t.dhth_inverse_dx_p1(&w), &expected, bound);
}

/// (B45) to (B48), (B62) to (B65), (B78) and (B80): what is `2 N` by `2 N`.
fn check_blocks(t: &Quantities<f64>, reference: &Derivatives, k: f64, bound: f64) {
    use Quantity::{Omega1, Omega2, Omega3, Omega4};
    for (what, found, of, part, factors) in [
        ("(B45)", t.domega_1_dx(), Omega1, 0, [1.0, 1.0]),
        ("(B46)", t.domega_2_dx(k), Omega2, 0, [k, 1.0]),
        ("(B47)", t.domega_3_dx(k), Omega3, 0, [1.0, 1.0 / k]),
        ("(B48)", t.domega_4_dx(k), Omega4, 0, [k, 1.0]),
        ("(B62)", t.domega_1_dxdot(), Omega1, 1, [1.0, 1.0]),
        ("(B63)", t.domega_2_dxdot(k), Omega2, 1, [k, 1.0]),
        ("(B64)", t.domega_3_dxdot(k), Omega3, 1, [1.0, 1.0 / k]),
        ("(B65)", t.domega_4_dxdot(k), Omega4, 1, [k, 1.0]),
        (
            "(B78)",
            t.domega_dxddot_unsimplified(),
            Omega1,
            2,
            [1.0, 1.0],
        ),
        ("(B80)", t.domega_dxddot(), Omega1, 2, [1.0, 1.0]),
    ] {
        close_blocks(what, &found, &reference.block(of, part), factors, bound);
    }
    let sum = |part| {
        let block = |of| reference.block(of, part);
        block(Omega1) - (block(Omega2) - block(Omega3) + block(Omega4))
    };
    close_blocks("(B38)", &t.domega_dx(k), &sum(0), [k, 1.0 / k], bound);
    close_blocks("(B39)", &t.domega_dxdot(k), &sum(1), [1.0, 1.0 / k], bound);
    close_blocks("(B40)", &t.domega_dxddot(), &sum(2), [1.0, 1.0], bound);
}

fn check_node(model: &Model, parts: &Parts<f64>) {
    let mut theorem = TheoremB4::new(model);
    let t = theorem.gather(node(parts)).expect("lengths agree");
    for (run, k) in PENALTIES.into_iter().enumerate() {
        let reference = Derivatives::new(model, parts, k);
        if run == 0 {
            // Nothing here knows the penalty.
            check_terms(t, &reference, bound(model, parts, 1));
            check_parts(t, &reference, bound(model, parts, 1));
            check_derivatives_of_rates(t, model, parts);
            let (q, twice) = (&parts[0][..model.dof()], bound(model, parts, 2));
            check_derivative_of_the_inverse(t, model, q, twice);
        }
        check_blocks(t, &reference, k, bound(model, parts, 2));
    }
}

fn blocks_of(mut jacobian: impl NodeJacobian, parts: &Parts<f64>, k: f64) -> NodeBlocks {
    let mut blocks = NodeBlocks::new(parts[0].len() / 2);
    jacobian
        .evaluate(node(parts), k, &mut blocks)
        .expect("lengths agree");
    blocks
}

fn check_against_the_dual_jacobian(model: &Model, parts: &Parts<f64>) {
    let bound = bound(model, parts, 2);
    for k in [1.0, 1e3, 1e7] {
        let found = blocks_of(TheoremB4::new(model), parts, k);
        let expected = blocks_of(ForwardDual::new(model), parts, k);
        close_blocks("dOmega/dx", &found.dx, &expected.dx, [k, 1.0 / k], bound);
        close_blocks(
            "dOmega/dxdot",
            &found.dxdot,
            &expected.dxdot,
            [1.0, 1.0 / k],
            bound,
        );
        close_blocks(
            "dOmega/dxddot",
            &found.dxddot,
            &expected.dxddot,
            [1.0, 1.0],
            bound,
        );
    }
}

proptest! {
    #![proptest_config(config(16))]

    #[test]
    fn every_numbered_block_matches_duals((model, parts) in model_and_node()) {
        check_node(&model, &parts);
    }
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn the_jacobian_matches_that_by_duals((model, parts) in model_and_node()) {
        check_against_the_dual_jacobian(&model, &parts);
    }

    #[test]
    fn a_used_jacobian_gives_the_same_bits((model, parts) in model_and_node()) {
        let other = [parts[2].clone(), parts[0].clone(), parts[1].clone()];
        let mut jacobian = TheoremB4::new(&model);
        let mut blocks = NodeBlocks::new(model.dof());
        jacobian.evaluate(node(&other), 3.0, &mut blocks).expect("lengths agree");
        jacobian.evaluate(node(&parts), 7.0, &mut blocks).expect("lengths agree");
        prop_assert_eq!(blocks, blocks_of(TheoremB4::new(&model), &parts, 7.0));
    }
}

/// States in which terms vanish, so that a block cannot lean on them, and one in which none does.
fn states(n: usize) -> Vec<Parts<f64>> {
    let wave = |f: f64| crate::common::wave(n, f);
    let zero = vec![0.0; n];
    let state = |q: &[f64], v: &[f64], a: &[f64]| {
        [
            [q, v].concat(),
            [v, a].concat(),
            [wave(2.1), wave(0.3)].concat(),
        ]
    };
    vec![
        // Straight and at rest, straight and moving, bent and at rest, not accelerating.
        state(&zero, &zero, &zero),
        state(&zero, &wave(0.9), &wave(1.7)),
        state(&wave(0.4), &zero, &wave(1.7)),
        state(&wave(0.4), &wave(0.9), &zero),
        // xdot_P1 is not x_P2.
        [wave(0.7), wave(1.3), wave(2.1)].map(|half| {
            let shifted: Vec<f64> = half.iter().map(|x| 0.5 - x).collect();
            [half, shifted].concat()
        }),
    ]
}

/// Acceptance: the robots of the paper and a tree, in the states that hide terms.
#[test]
fn every_numbered_block_on_the_robots() {
    let models = ["pendulum_2", "pendulum_4", "kinova_gen3"].map(robot);
    let tree = random_tree(6, 3).expect("six joints");
    for model in models.into_iter().chain([tree]) {
        for parts in states(model.dof()) {
            check_node(&model, &parts);
        }
    }
    let digit = robot("digit_v3_pinned");
    let states = states(digit.dof());
    check_node(&digit, &states[0]);
    check_node(&digit, &states[4]);
}

#[test]
fn the_jacobian_of_every_robot() {
    for model in robots() {
        for parts in states(model.dof()) {
            check_against_the_dual_jacobian(&model, &parts);
        }
    }
}

/// The same code over other scalars: duals carry the value along bit for bit, single precision to its precision.
#[test]
fn it_runs_over_other_scalars() {
    fn of<S: AlgebraOver<f64>>(model: &Model, parts: &Parts<f64>) -> NodeBlocks<S> {
        let parts = parts
            .clone()
            .map(|part| part.into_iter().map(S::lift).collect());
        let mut blocks = NodeBlocks::new(model.dof());
        TheoremB4::new(model)
            .blocks(node(&parts), 5.0, &mut blocks)
            .expect("lengths agree");
        blocks
    }
    let model = robot("kinova_gen3");
    let parts = &states(model.dof())[4];
    let double = of::<f64>(&model, parts);
    close(
        "f64",
        &double.dx,
        &of::<Dual64>(&model, parts).dx.map(|x| x.re),
        1e-10,
    );
    close(
        "f32",
        &of::<f32>(&model, parts).dx.map(f64::from),
        &double.dx,
        1e-2,
    );
}

#[test]
fn it_is_found_by_name() {
    let kind: JacobianKind = serde_json::from_str("\"theorem_b4\"").expect("the name");
    assert_eq!(kind, JacobianKind::TheoremB4);
    assert_eq!(
        "theorem_b4".parse::<JacobianKind>().expect("the name"),
        kind
    );
    let model = robot("pendulum_2");
    let parts = &states(2)[4];
    let mut blocks = NodeBlocks::new(2);
    kind.build(&model)
        .evaluate(node(parts), 2.0, &mut blocks)
        .expect("lengths agree");
    assert_eq!(blocks, blocks_of(TheoremB4::new(&model), parts, 2.0));
}

#[test]
fn wrong_lengths_are_errors() {
    let model = robot("pendulum_2");
    let (long, short) = (vec![0.0; 4], vec![0.0; 3]);
    let mut jacobian = TheoremB4::new(&model);
    let mut blocks = NodeBlocks::new(2);
    for (x, xdot, xddot) in [
        (&short, &long, &long),
        (&long, &short, &long),
        (&long, &long, &short),
    ] {
        let t = 0.0;
        let node = Node { t, x, xdot, xddot };
        let error = jacobian
            .evaluate(node, 1.0, &mut blocks)
            .expect_err("one is short")
            .to_string();
        assert!(error.contains("expected 4 entries, found 3"), "{error}");
    }
    let good = [long.clone(), long.clone(), long];
    let too_large = jacobian.evaluate(node(&good), 1.0, &mut NodeBlocks::new(3));
    crate::common::assert_refused(too_large, "dx: expected 4 entries, found 6");
}
