//! Readings of the printed equations that `proofs/` does not follow: they fail exactly over the field.

use aghf::dynamics::{Data, aba, crba, mass_matrix_and_rate, mass_matrix_product_derivative};
use aghf::flow::{TheoremB3, activation};
use aghf::scalar::PrimeField;
use aghf::verify::field::RandomInstance;
use nalgebra::{DMatrix, DVector};
use num_traits::Zero;
use rand::SeedableRng;

/// An instance with a robot large enough that bodies carry others about axes of all kinds.
fn instance() -> RandomInstance {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    std::iter::repeat_with(|| RandomInstance::random(&mut rng).expect("there is a joint"))
        .find(|p| p.dof() >= 7)
        .expect("instances do not end")
}

fn omega_4(p: &RandomInstance, t: &mut TheoremB3<PrimeField>, dh_dq_w: DMatrix<PrimeField>) -> DVector<PrimeField> {
    t.dh_dq_w = dh_dq_w;
    let mut omega_4 = DVector::zeros(2 * p.dof());
    t.omega_4(p.node(), p.k, &mut omega_4);
    omega_4
}

/// (B9), (B34): with `w` contracted over the derivative index, or without the transpose of the bracket.
#[test]
fn omega_4_depends_on_the_index_that_is_contracted() {
    let p = instance();
    let (n, node, data) = (p.dof(), p.node(), &mut Data::new(&p.model));
    let (q, v) = (node.x_p1(), node.x_p2());
    let zero = DVector::zeros(n);
    let mut t = TheoremB3::new(n);
    crba(&p.model, data, q, &mut t.h).expect("lengths agree");
    aba(&p.model, data, q, v, zero.as_slice(), t.fd0.as_mut_slice()).expect("lengths agree");
    let w = DVector::from_column_slice(node.xdot_p2()) - &t.fd0;

    let mut ours = DMatrix::zeros(n, n);
    mass_matrix_product_derivative(&p.model, data, q, w.as_slice(), &mut ours).expect("lengths agree");
    let (mut h, mut over_derivatives) = (ours.clone(), ours.clone());
    mass_matrix_and_rate(&p.model, data, q, w.as_slice(), &mut h, &mut over_derivatives).expect("lengths agree");

    let right = omega_4(&p, &mut t, ours.clone());
    assert_ne!(right, omega_4(&p, &mut t, over_derivatives));
    assert_ne!(right, omega_4(&p, &mut t, ours.transpose()));
    assert_eq!(right, omega_4(&p, &mut t, ours));
}

/// (A3) does not vanish wherever `g <= 0`.
#[test]
fn the_activation_does_not_vanish_on_the_boundary() {
    let p = instance();
    assert!(!activation(PrimeField::zero(), p.extra[0]).is_zero());
    assert!(activation(-1e-3, 200.0) > 0.4);
}
