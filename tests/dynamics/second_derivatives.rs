//! The tensors of second derivatives against hyper-dual numbers through the plain dynamics.

use crate::common::{config, model_and_state, relative_error, robot, robots};
use aghf::dynamics::{
    BiasRateDerivatives, Data, ForwardDynamicsDerivatives, ForwardDynamicsSecondDerivatives,
    InverseDynamicsSecondDerivatives, MassMatrixDerivatives, aba, aba_derivatives,
    aba_second_derivatives, bias, bias_rate_derivatives, crba, crba_second_derivatives,
    mass_matrix_rate_derivatives, rnea, rnea_second_derivatives,
};
use aghf::linalg::{Tensor3, Tensor4};
use aghf::model::Model;
use nalgebra::{DMatrix, DVector};
use num_dual::HyperDual64;
use proptest::prelude::*;

/// How far the tensors of inverse dynamics may be off, relative to their largest entry.
const BOUND: f64 = 1e-9;

/// What rounding leaves of the solves with `H`.
fn solve_bound(model: &Model, q: &[f64]) -> f64 {
    let mut h = DMatrix::zeros(model.dof(), model.dof());
    crba(model, &mut Data::new(model), q, &mut h).expect("lengths agree");
    let eigenvalues = h.symmetric_eigenvalues();
    BOUND + 1e-13 * eigenvalues.max() / eigenvalues.min()
}

/// The mixed second derivative of `f` at `x` along two directions.
fn mixed(
    f: &impl Fn(&[HyperDual64]) -> Vec<HyperDual64>,
    x: &[f64],
    one: &[f64],
    two: &[f64],
) -> Vec<f64> {
    let input: Vec<HyperDual64> = (0..x.len())
        .map(|i| HyperDual64::new(x[i], one[i], two[i], 0.0))
        .collect();
    f(&input).iter().map(|y| y.eps1eps2).collect()
}

fn unit(n: usize, i: usize) -> Vec<f64> {
    (0..n).map(|j| f64::from(u8::from(i == j))).collect()
}

/// All second derivatives of `f` at `x`: entry `[j][k]` is that in `x_j` and `x_k`.
fn second(f: impl Fn(&[HyperDual64]) -> Vec<HyperDual64>, x: &[f64]) -> Vec<Vec<Vec<f64>>> {
    let n = x.len();
    let at = |j, k| mixed(&f, x, &unit(n, j), &unit(n, k));
    (0..n).map(|j| (0..n).map(|k| at(j, k)).collect()).collect()
}

/// The part of [`second`] whose derivatives are in the `N` coordinates from `j` and from `k` on.
fn part(all: &[Vec<Vec<f64>>], n: usize, j: usize, k: usize) -> Tensor3<f64> {
    let mut tensor = Tensor3::new(n);
    for a in 0..n {
        for b in 0..n {
            for i in 0..n {
                tensor[(i, a, b)] = all[j + a][k + b][i];
            }
        }
    }
    tensor
}

fn zeros<S: aghf::scalar::Scalar>(n: usize) -> Vec<S> {
    vec![S::zero(); n]
}

fn mass(model: &Model, q: &[HyperDual64]) -> Vec<HyperDual64> {
    let mut h = DMatrix::zeros(model.dof(), model.dof());
    crba(model, &mut Data::new(model), q, &mut h).expect("lengths agree");
    h.as_slice().to_vec()
}

fn id_tensors(
    model: &Model,
    q: &[f64],
    v: &[f64],
    a: &[f64],
) -> InverseDynamicsSecondDerivatives<f64> {
    let mut out = InverseDynamicsSecondDerivatives::new(model.dof());
    rnea_second_derivatives(model, &mut Data::new(model), q, v, a, &mut out)
        .expect("lengths agree");
    out
}

fn mass_tensors(model: &Model, q: &[f64], v: &[f64]) -> MassMatrixDerivatives<f64> {
    let mut out = MassMatrixDerivatives::new(model.dof());
    crba_second_derivatives(model, &mut Data::new(model), q, v, &mut out).expect("lengths agree");
    out
}

fn close(what: &str, a: &[f64], b: &[f64], bound: f64) {
    let error = relative_error(a, b);
    assert!(
        error <= bound,
        "{what} is off by {error:e}, bound {bound:e}"
    );
}

fn check_mass(model: &Model, q: &[f64], v: &[f64]) {
    let n = model.dof();
    let tensors = mass_tensors(model, q, v);
    let (mut dq, mut dqdq) = (Tensor3::new(n), Tensor4::new(n));
    let mut hdot = vec![0.0; n * n];
    for k in 0..n {
        for l in 0..n {
            let input: Vec<HyperDual64> = (0..n)
                .map(|i| HyperDual64::new(q[i], unit(n, k)[i], unit(n, l)[i], 0.0))
                .collect();
            let h = mass(model, &input);
            for j in 0..n {
                for i in 0..n {
                    dq[(i, j, k)] = h[i + n * j].eps1;
                    dqdq[(i, j, k, l)] = h[i + n * j].eps1eps2;
                }
            }
            if l == 0 {
                for (rate, h) in hdot.iter_mut().zip(&h) {
                    *rate += h.eps1 * v[k];
                }
            }
            if (k, l) == (0, 0) {
                let values: Vec<f64> = h.iter().map(|h| h.re).collect();
                close("H", tensors.h.as_slice(), &values, BOUND);
            }
        }
    }
    close("Hdot", tensors.hdot.as_slice(), &hdot, BOUND);
    close("dH/dq", tensors.dq.entries(), dq.entries(), BOUND);
    close("d2H/dq2", tensors.dqdq.entries(), dqdq.entries(), BOUND);
}

fn check_inverse_dynamics(model: &Model, q: &[f64], v: &[f64], a: &[f64]) {
    let n = model.dof();
    let torque = |z: &[HyperDual64]| {
        let mut tau = zeros(n);
        let mut data = Data::new(model);
        rnea(
            model,
            &mut data,
            &z[..n],
            &z[n..2 * n],
            &z[2 * n..],
            &mut tau,
        )
        .expect("lengths");
        tau
    };
    let all = second(torque, &[q, v, a].concat());
    let id = id_tensors(model, q, v, a);
    for (what, tensor, (j, k)) in [
        ("d2ID/dq2", &id.dqdq, (0, 0)),
        ("d2ID/dv2", &id.dvdv, (n, n)),
        ("d2ID/dqdv", &id.dqdv, (0, n)),
        ("d2ID/dadq", &id.dadq, (2 * n, 0)),
    ] {
        close(what, tensor.entries(), part(&all, n, j, k).entries(), BOUND);
    }
}

fn check_forward_dynamics(model: &Model, q: &[f64], v: &[f64], tau: &[f64]) {
    let n = model.dof();
    let constant: Vec<HyperDual64> = tau.iter().map(|t| HyperDual64::from(*t)).collect();
    let acceleration = |z: &[HyperDual64]| {
        let mut a = zeros(n);
        aba(
            model,
            &mut Data::new(model),
            &z[..n],
            &z[n..],
            &constant,
            &mut a,
        )
        .expect("lengths");
        a
    };
    let all = second(acceleration, &[q, v].concat());
    let mut data = Data::new(model);
    let mut fd = ForwardDynamicsDerivatives::new(n);
    aba_derivatives(model, &mut data, q, v, tau, &mut fd).expect("lengths agree");
    let id = id_tensors(model, q, v, fd.a.as_slice());
    let mut out = ForwardDynamicsSecondDerivatives::new(n);
    aba_second_derivatives(&fd, &id, &mut out).expect("sizes agree");
    let bound = solve_bound(model, q);
    for (what, tensor, (j, k)) in [
        ("d2FD/dq2", &out.dqdq, (0, 0)),
        ("d2FD/dv2", &out.dvdv, (n, n)),
        ("d2FD/dqdv", &out.dqdv, (0, n)),
    ] {
        close(what, tensor.entries(), part(&all, n, j, k).entries(), bound);
    }
}

fn check_rates(model: &Model, x: &[f64], xdot: &[f64]) {
    let n = model.dof();
    let (q, v) = x.split_at(n);
    let (qdot, vdot) = xdot.split_at(n);
    let mut dhdot = Tensor3::new(n);
    mass_matrix_rate_derivatives(&mass_tensors(model, q, v).dqdq, qdot, &mut dhdot)
        .expect("sizes agree");
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
    fn the_derivatives_of_the_mass_matrix_match_duals((model, q, v, _) in model_and_state()) {
        check_mass(&model, &q, &v);
    }

    #[test]
    fn the_second_derivatives_of_inverse_dynamics_match_duals((model, q, v, a) in model_and_state()) {
        check_inverse_dynamics(&model, &q, &v, &a);
    }

    #[test]
    fn the_second_derivatives_of_forward_dynamics_match_duals((model, q, v, tau) in model_and_state()) {
        check_forward_dynamics(&model, &q, &v, &tau);
    }

    #[test]
    fn the_derivatives_of_the_rates_match_duals((model, [x, xdot, _]) in crate::common::model_and_node()) {
        check_rates(&model, &x, &xdot);
    }

    /// Symmetry in the two derivatives and in the two indices of `H`, exact.
    #[test]
    fn second_derivatives_are_symmetric((model, q, v, a) in model_and_state()) {
        let n = model.dof();
        let id = id_tensors(&model, &q, &v, &a);
        prop_assert_eq!(&id.dqdq.swap_last(), &id.dqdq);
        prop_assert_eq!(&id.dvdv.swap_last(), &id.dvdv);
        let mass = mass_tensors(&model, &q, &v);
        close("dH/dq as d2ID/dadq", id.dadq.entries(), mass.dq.entries(), 1e-12);
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

    /// Results that were used elsewhere are overwritten entirely: nothing of another state is left.
    #[test]
    fn used_results_give_the_same_bits((model, q, v, a) in model_and_state()) {
        let mut data = Data::new(&model);
        let mut id = id_tensors(&model, &a, &q, &v);
        id.dqdv.fill(1.0);
        rnea_second_derivatives(&model, &mut data, &q, &v, &a, &mut id).expect("lengths agree");
        prop_assert_eq!(id, id_tensors(&model, &q, &v, &a));
        let mut mass = mass_tensors(&model, &a, &q);
        mass.dqdq.fill(1.0);
        crba_second_derivatives(&model, &mut data, &q, &v, &mut mass).expect("lengths agree");
        prop_assert_eq!(mass, mass_tensors(&model, &q, &v));
    }
}

/// Every robot at rest in its zero position, straight, and moving.
#[test]
fn all_robots_at_the_states_that_hide_terms() {
    for model in robots() {
        let n = model.dof();
        let wave = |f: f64| -> Vec<f64> { (0..n).map(|i| (f * (i as f64 + 1.0)).sin()).collect() };
        let zero = zeros(n);
        for (q, v, a) in [
            (zero.clone(), zero.clone(), zero.clone()),
            (zero.clone(), wave(0.9), zero.clone()),
            (wave(0.4), zero.clone(), zero.clone()),
            (wave(0.4), zero.clone(), wave(1.1)),
            (wave(0.7), wave(1.3), wave(2.1)),
        ] {
            check_mass(&model, &q, &v);
            check_inverse_dynamics(&model, &q, &v, &a);
            check_forward_dynamics(&model, &q, &v, &a);
            check_rates(&model, &[q, v.clone()].concat(), &[v, a].concat());
        }
    }
}

/// A pendulum of one link by hand: `ID = m l^2 a + m g l cos q` with `l` half a metre.
#[test]
fn a_single_pendulum_by_hand() {
    let model = robot("pendulum_1");
    let id = id_tensors(&model, &[0.3], &[0.7], &[1.9]);
    let weight = 9.81 * 0.5;
    assert!((id.dqdq[(0, 0, 0)] + weight * 0.3_f64.cos()).abs() < 1e-14);
    for tensor in [&id.dvdv, &id.dqdv, &id.dadq] {
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
    let mut data = Data::new(&model);
    let (good, bad) = ([0.0; 3], [0.0; 2]);
    let mut id = InverseDynamicsSecondDerivatives::new(3);
    let mut mass = MassMatrixDerivatives::new(3);
    for (q, v, a) in [
        (&bad[..], &good[..], &good[..]),
        (&good, &bad, &good),
        (&good, &good, &bad),
    ] {
        rnea_second_derivatives(&model, &mut data, q, v, a, &mut id).expect_err("too short");
    }
    crba_second_derivatives(&model, &mut data, &bad, &good, &mut mass).expect_err("too short");
    crba_second_derivatives(&model, &mut data, &good, &bad, &mut mass).expect_err("too short");
    let mut small = InverseDynamicsSecondDerivatives::new(2);
    let error = rnea_second_derivatives(&model, &mut data, &good, &good, &good, &mut small);
    let message = error.expect_err("too small").to_string();
    assert!(
        message.contains("dqdq: expected 3 entries, found 2"),
        "{message}"
    );
    let mut small = MassMatrixDerivatives::new(2);
    crba_second_derivatives(&model, &mut data, &good, &good, &mut small).expect_err("too small");
    mass_matrix_rate_derivatives(&mass.dqdq, &bad, &mut Tensor3::new(3)).expect_err("too short");
    mass_matrix_rate_derivatives(&mass.dqdq, &good, &mut Tensor3::new(2)).expect_err("too small");
    let mut rate = BiasRateDerivatives::new(3);
    let (long, short) = (DVector::zeros(3), DVector::zeros(2));
    bias_rate_derivatives(&id, &long, &short, &mut rate).expect_err("too short");
    bias_rate_derivatives(&id, &short, &short, &mut rate).expect_err("too short");
    let fd = ForwardDynamicsDerivatives::<f64>::new(2);
    let mut out = ForwardDynamicsSecondDerivatives::new(3);
    aba_second_derivatives(&fd, &id, &mut out).expect_err("sizes differ");
}
