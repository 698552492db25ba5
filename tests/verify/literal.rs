//! Statements of the text that are wrong or ambiguous: read literally they fail over the field.

use aghf::dynamics::bias_rate_derivatives;
use aghf::flow::jacobian::theorem_b4::Quantities;
use aghf::verify::field::{Gf, RandomInstance, Wrt, derivative, gathered};
use aghf::verify::reference::{alpha_2, capital_gamma};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// An instance whose robot has enough joints, not all of them prismatic: some small robots do not show the failure.
fn instance() -> (RandomInstance, Quantities<Gf>) {
    let p = RandomInstance::random(&mut ChaCha8Rng::seed_from_u64(1)).expect("there is a joint");
    let quantities = gathered(&p).expect("sizes agree");
    (p, quantities)
}

/// `w`, `H w` and `dH/dx_P1 H w` with the derivative index last.
fn of_w(t: &Quantities<Gf>) -> (DVector<Gf>, DVector<Gf>, DMatrix<Gf>) {
    let w = &t.xdot_p2 - &t.fd0.a;
    let hw = &t.mass.h * &w;
    let first = t.mass.dq.times_first(&hw);
    (w, hw, first)
}

#[test]
fn b59_and_b60_and_b70_read_left_to_right_are_transposed() {
    let (p, t) = instance();
    let (w, hw, first) = of_w(&t);
    let (h, dh_w) = (&t.mass.h, t.mass.dq.times_second(&w));
    let rest = t.mass.dqdq.times_first_and_second(&hw, &w) + dh_w.tr_mul(&(&dh_w - h * &t.fd0.dq));
    let b59 = -t.fd0.dq.tr_mul(&first) + rest;
    let b60 = -t.fd0.dv.tr_mul(&first) - dh_w.tr_mul(&(h * &t.fd0.dv));
    let b70 = first + dh_w.tr_mul(h);
    for (literal, part) in [(b59, Wrt::XP1), (b60, Wrt::XP2), (b70, Wrt::XdotP2)] {
        assert_ne!(literal, derivative(&p, part, capital_gamma).expect("sizes agree"));
    }
}

#[test]
fn b56_with_rows_in_q_fails() {
    let (p, t) = instance();
    let reference = derivative(&p, Wrt::XP1, alpha_2).expect("sizes agree");
    let force = &t.mass.h * &t.xdot_p2 + &t.c;
    let twice = t.mass.h.tr_mul(&(&force + &force));
    let mixed = t.d2fd0.dqdv.times_first(&twice);
    assert_eq!(t.dalpha_2_dx_p1(), reference);
    assert_ne!(t.dalpha_2_dx_p1() + mixed.transpose() - mixed, reference);
}

#[test]
fn lines_8_to_10_of_algorithm_b2_as_printed_fail() {
    let (_, t) = instance();
    // Line 8: the mixed derivative of FD_0 is not that of ID at FD_0.
    assert_ne!(&t.d2fd0.dqdv, t.d2id.dqdv());
    // Line 9: d2FD_0/dx_P1^2 cannot do without d2ID/dx_P1^2.
    let mut printed = t.d2fd0.clone();
    let none = aghf::linalg::Tensor3::new(t.c.len());
    let without = t.d2id.clone().with(none, t.d2id.dvdv().clone());
    aghf::dynamics::aba_second_derivatives(&t.fd0, &without, &mut printed).expect("sizes agree");
    assert_ne!(printed.dqdq, t.d2fd0.dqdq);
    // Line 10: with the mixed derivative in the place of d2C/dx_P2^2.
    let mut printed = t.dcdot.clone();
    let without = t.d2c.clone().with(t.d2c.dqdq().clone(), t.d2c.dqdv().clone());
    bias_rate_derivatives(&without, &t.xdot_p1, &t.xdot_p2, &mut printed).expect("sizes agree");
    assert_ne!(printed.dv, t.dcdot.dv);
}
