//! The tensors of second derivatives: their symmetries, the tensors derived from them, and cases by hand. Their
//! correctness is tested in `derivatives`.

use crate::common::{assert_refused, config, model_and_state, relative_error, robot};
use aghf::dynamics::{
    BiasRateDerivatives, Data, ForwardDynamicsDerivatives, ForwardDynamicsSecondDerivatives,
    InverseDynamicsSecondDerivatives, MassMatrixDerivatives, aba_second_derivatives, bias, bias_rate_derivatives, crba,
    crba_second_derivatives, mass_matrix_and_rate, mass_matrix_rate_derivatives, rnea_second_derivatives,
};
use aghf::linalg::Tensor3;
use aghf::model::{Model, random_chain};
use nalgebra::{DMatrix, DVector};
use num_dual::HyperDual64;
use proptest::prelude::*;

/// The largest error of the tensors of inverse dynamics, relative to their largest entry.
const BOUND: f64 = 1e-9;

/// The mixed second derivative of `f` at `x` along two directions.
fn mixed(f: &impl Fn(&[HyperDual64]) -> Vec<HyperDual64>, x: &[f64], one: &[f64], two: &[f64]) -> Vec<f64> {
    let input: Vec<HyperDual64> = (0..x.len()).map(|i| HyperDual64::new(x[i], one[i], two[i], 0.0)).collect();
    f(&input).iter().map(|y| y.eps1eps2).collect()
}

fn unit(n: usize, i: usize) -> Vec<f64> {
    (0..n).map(|j| f64::from(u8::from(i == j))).collect()
}

fn zeros<S: aghf::scalar::Scalar>(n: usize) -> Vec<S> {
    vec![S::zero(); n]
}

fn mass(model: &Model, q: &[HyperDual64]) -> Vec<HyperDual64> {
    let mut h = DMatrix::zeros(model.dof(), model.dof());
    crba(model, &mut Data::new(model), q, &mut h).expect("lengths agree");
    h.as_slice().to_vec()
}

fn id_tensors(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> InverseDynamicsSecondDerivatives<f64> {
    let mut out = InverseDynamicsSecondDerivatives::new(model.dof());
    rnea_second_derivatives(model, &mut Data::new(model), q, v, a, &mut out).expect("lengths agree");
    out
}

fn mass_tensors(model: &Model, q: &[f64], v: &[f64]) -> MassMatrixDerivatives<f64> {
    let mut out = MassMatrixDerivatives::new(model.dof());
    crba_second_derivatives(model, &mut Data::new(model), q, v, &mut out).expect("lengths agree");
    out
}

fn close(what: &str, a: &[f64], b: &[f64], bound: f64) {
    let error = relative_error(a, b);
    assert!(error <= bound, "{what} is off by {error:e}, bound {bound:e}");
}

fn check_rates(model: &Model, x: &[f64], xdot: &[f64]) {
    let n = model.dof();
    let (q, v) = x.split_at(n);
    let (qdot, vdot) = xdot.split_at(n);
    let mut dhdot = Tensor3::new(n);
    mass_matrix_rate_derivatives(&mass_tensors(model, q, v).dqdq, qdot, &mut dhdot).expect("sizes agree");
    let by_duals = |k| mixed(&|q: &[HyperDual64]| mass(model, q), q, qdot, &unit(n, k));
    let expected: Vec<f64> = (0..n).flat_map(by_duals).collect();
    close("dHdot/dq", dhdot.entries(), &expected, BOUND);

    let bias_of = |z: &[HyperDual64]| {
        let mut c = zeros(n);
        bias(model, &mut Data::new(model), &z[..n], &z[n..], &mut c).expect("lengths agree");
        c
    };
    let mut dcdot = BiasRateDerivatives::new(n);
    bias_rate_derivatives(
        &id_tensors(model, q, v, &zeros(n)),
        &DVector::from_column_slice(qdot),
        &DVector::from_column_slice(vdot),
        &mut dcdot,
    )
    .expect("sizes agree");
    let columns = |from: usize| -> Vec<f64> {
        let column = |k| mixed(&bias_of, x, xdot, &unit(2 * n, from + k));
        (0..n).flat_map(column).collect()
    };
    close("dCdot/dq", dcdot.dq.as_slice(), &columns(0), BOUND);
    close("dCdot/dv", dcdot.dv.as_slice(), &columns(n), BOUND);
}

proptest! {
    #![proptest_config(config(48))]

    #[test]
    fn the_derivatives_of_the_rates_match_duals((model, [x, xdot, _]) in crate::common::model_and_node()) {
        check_rates(&model, &x, &xdot);
    }

    /// Symmetry in the two derivatives and in the two indices of `H`, exact.
    #[test]
    fn second_derivatives_are_symmetric((model, q, v, a) in model_and_state()) {
        let n = model.dof();
        let id = id_tensors(&model, &q, &v, &a);
        prop_assert_eq!(&id.dqdq().swap_last(), id.dqdq());
        prop_assert_eq!(&id.dvdv().swap_last(), id.dvdv());
        let mass = mass_tensors(&model, &q, &v);
        close("dH/dq as d2ID/dadq", id.dadq().entries(), mass.dq.entries(), 1e-12);
        let (mut h, mut hdot) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        mass_matrix_and_rate(&model, &mut Data::new(&model), &q, &v, &mut h, &mut hdot).expect("lengths agree");
        close("H", mass.h.as_slice(), h.as_slice(), 1e-12);
        close("Hdot", mass.hdot.as_slice(), hdot.as_slice(), 1e-12);
        for i in 0..n {
            for j in 0..n {
                for k in 0..n {
                    prop_assert_eq!(mass.dq[(i, j, k)], mass.dq[(j, i, k)]);
                    for l in 0..n {
                        let entry = mass.dqdq[(i, j, k, l)];
                        prop_assert_eq!(entry, mass.dqdq[(j, i, k, l)]);
                        prop_assert_eq!(entry, mass.dqdq[(i, j, l, k)]);
                    }
                }
            }
        }
    }

    /// Results that were used before are overwritten entirely, also for another tree.
    #[test]
    fn used_results_give_the_same_bits((model, q, v, a) in model_and_state()) {
        let mut data = Data::new(&model);
        let chain = random_chain(model.dof(), 1).expect("it has joints");
        let mut id = id_tensors(&chain, &a, &q, &v);
        rnea_second_derivatives(&model, &mut data, &q, &v, &a, &mut id).expect("lengths agree");
        prop_assert_eq!(id, id_tensors(&model, &q, &v, &a));
        let mut mass = mass_tensors(&model, &a, &q);
        mass.dqdq.fill(1.0);
        crba_second_derivatives(&model, &mut data, &q, &v, &mut mass).expect("lengths agree");
        prop_assert_eq!(mass, mass_tensors(&model, &q, &v));
    }
}

/// A pendulum of one link by hand: `ID = m l^2 a + m g l cos q` with `l` half a metre.
#[test]
fn a_single_pendulum_by_hand() {
    let model = robot("pendulum_1");
    let id = id_tensors(&model, &[0.3], &[0.7], &[1.9]);
    let weight = 9.81 * 0.5;
    assert!((id.dqdq()[(0, 0, 0)] + weight * 0.3_f64.cos()).abs() < 1e-14);
    for tensor in [id.dvdv(), id.dqdv(), id.dadq()] {
        assert!(tensor[(0, 0, 0)].abs() < 1e-14);
    }
}

/// Two links by hand: `H_00 = 1.5 + cos q_1`, `H_01 = 1/4 + cos(q_1) / 2`.
#[test]
fn the_mass_matrix_of_a_double_pendulum_by_hand() {
    let q1 = 0.8_f64;
    let mass = mass_tensors(&robot("pendulum_2"), &[0.2, q1], &[0.5, 2.0]);
    let check = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14);
    check(mass.dq[(0, 0, 1)], -q1.sin());
    check(mass.dq[(0, 1, 1)], -q1.sin() / 2.0);
    check(mass.dq[(0, 0, 0)], 0.0);
    check(mass.dq[(1, 1, 1)], 0.0);
    check(mass.dqdq[(0, 0, 1, 1)], -q1.cos());
    check(mass.dqdq[(0, 1, 1, 1)], -q1.cos() / 2.0);
    check(mass.dqdq[(0, 0, 0, 1)], 0.0);
    check(mass.hdot[(0, 0)], -2.0 * q1.sin());
}

#[test]
fn wrong_lengths_are_errors_not_panics() {
    let model = robot("pendulum_3");
    let data = &mut Data::new(&model);
    let (good, bad, short) = ([0.0; 3], [0.0; 2], "expected 3 entries, found 2");
    let mut id = InverseDynamicsSecondDerivatives::new(3);
    let mut mass = MassMatrixDerivatives::new(3);
    for (q, v, a) in [(&bad[..], &good[..], &good[..]), (&good, &bad, &good), (&good, &good, &bad)] {
        assert_refused(rnea_second_derivatives(&model, data, q, v, a, &mut id), short);
    }
    for (q, v) in [(&bad[..], &good[..]), (&good, &bad)] {
        assert_refused(crba_second_derivatives(&model, data, q, v, &mut mass), short);
    }
    let mut small = InverseDynamicsSecondDerivatives::new(2);
    let of_id = rnea_second_derivatives(&model, data, &good, &good, &good, &mut small);
    assert_refused(of_id, "dqdq: expected 3 entries, found 2");
    let mut small = MassMatrixDerivatives::new(2);
    let of_h = crba_second_derivatives(&model, data, &good, &good, &mut small);
    assert_refused(of_h, short);
    for (qdot, size, words) in
        [(&bad[..], 3, "d2h: expected 2 entries, found 3"), (&good, 2, "out: expected 3 entries, found 2")]
    {
        let out = &mut Tensor3::new(size);
        assert_refused(mass_matrix_rate_derivatives(&mass.dqdq, qdot, out), words);
    }
    let mut rate = BiasRateDerivatives::new(3);
    let (long, short_one) = (DVector::zeros(3), DVector::zeros(2));
    let of_vdot = bias_rate_derivatives(&id, &long, &short_one, &mut rate);
    assert_refused(of_vdot, "vdot: expected 3 entries, found 2");
    let of_both = bias_rate_derivatives(&id, &short_one, &short_one, &mut rate);
    assert_refused(of_both, "expected 2 entries, found 3");
    let fd = ForwardDynamicsDerivatives::<f64>::new(2);
    let mut out = ForwardDynamicsSecondDerivatives::new(3);
    assert_refused(aba_second_derivatives(&fd, &id, &mut out), "entries, found");
}
