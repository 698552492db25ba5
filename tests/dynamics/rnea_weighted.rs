//! Contracted derivatives of inverse dynamics and of the mass matrix against hyper-dual numbers through `rnea` and `crba`.

use crate::common::{any_model, config, dual_jacobian, numbers};
use aghf::dynamics::{
    Data, InverseDynamicsDerivatives, RneaVjp, RneaWeightedHessian, crba,
    mass_matrix_product_derivative, rnea, rnea_derivatives, rnea_second_order, rnea_vjp,
    rnea_weighted_hessian,
};
use aghf::model::Model;
use nalgebra::{DMatrix, DVector};
use num_dual::{Dual64, HyperDual64};
use proptest::prelude::*;

/// A model with `q, v, a` behind one another, and weights.
fn model_state_weights() -> impl Strategy<Value = (Model, Vec<f64>, Vec<f64>)> {
    any_model().prop_flat_map(|model| {
        let n = model.dof();
        (Just(model), numbers(3 * n), numbers(n))
    })
}

/// $w^T ID$ at `q, v, a`, differentiated along the coordinates `i` and `j` of the three together.
fn contraction(model: &Model, state: &[f64], w: &[f64], i: usize, j: usize) -> HyperDual64 {
    let n = model.dof();
    let one = |a: usize, b: usize| if a == b { 1.0 } else { 0.0 };
    let state: Vec<HyperDual64> = (state.iter().enumerate())
        .map(|(m, x)| HyperDual64::new(*x, one(m, i), one(m, j), 0.0))
        .collect();
    let mut tau = vec![HyperDual64::from(0.0); n];
    let (q, v, a) = (&state[..n], &state[n..2 * n], &state[2 * n..]);
    rnea(model, &mut Data::new(model), q, v, a, &mut tau).expect("lengths agree");
    tau.iter()
        .zip(w)
        .fold(HyperDual64::from(0.0), |sum, (t, w)| sum + *t * *w)
}

/// One block of the Hessian of $w^T ID$; rows and columns start at the given coordinates.
fn block(model: &Model, state: &[f64], w: &[f64], row: usize, column: usize) -> DMatrix<f64> {
    let n = model.dof();
    DMatrix::from_fn(n, n, |i, j| {
        contraction(model, state, w, row + i, column + j).eps1eps2
    })
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn both_in_one_are_each_alone((model, state, _) in model_state_weights()) {
        let n = model.dof();
        let (q, v, a) = (&state[..n], &state[n..2 * n], &state[2 * n..]);
        let data = &mut Data::new(&model);
        let (mut first, mut second) = (InverseDynamicsDerivatives::new(n), RneaWeightedHessian::new(n));
        let (mut first_alone, mut second_alone) = (first.clone(), second.clone());
        rnea_derivatives(&model, data, q, v, a, &mut first_alone).expect("lengths");
        let w: Vec<f64> = first_alone.tau.iter().map(|u| 2.0 * u).collect();
        rnea_weighted_hessian(&model, data, q, v, a, &w, &mut second_alone).expect("lengths");
        let weigh = |tau: &DVector<f64>, w: &mut [f64]| w.copy_from_slice((tau * 2.0).as_slice());
        rnea_second_order(&model, data, [q, v, a], weigh, &mut first, &mut second).expect("lengths");
        prop_assert_eq!((first, second), (first_alone, second_alone));
    }

    #[test]
    fn the_gradient_matches_duals((model, state, w) in model_state_weights()) {
        let n = model.dof();
        let mut gradient = RneaVjp::new(n);
        let (q, v, a) = (&state[..n], &state[n..2 * n], &state[2 * n..]);
        rnea_vjp(&model, &mut Data::new(&model), q, v, a, &w, &mut gradient).expect("lengths");
        let by_duals: Vec<f64> = (0..3 * n).map(|i| contraction(&model, &state, &w, i, i).eps1).collect();
        assert_close!(&gradient.q, &by_duals[..n], 1e-10);
        assert_close!(&gradient.v, &by_duals[n..2 * n], 1e-10);
        assert_close!(&gradient.a, &by_duals[2 * n..], 1e-10);
    }

    #[test]
    fn the_hessian_matches_hyper_duals((model, state, w) in model_state_weights()) {
        let n = model.dof();
        let mut hessian = RneaWeightedHessian::new(n);
        let (q, v, a) = (&state[..n], &state[n..2 * n], &state[2 * n..]);
        // A used workspace must not matter.
        let mut data = Data::new(&model);
        rnea_weighted_hessian(&model, &mut data, a, q, v, &w, &mut hessian).expect("lengths agree");
        rnea_weighted_hessian(&model, &mut data, q, v, a, &w, &mut hessian).expect("lengths agree");
        assert_close!(&hessian.qq, &block(&model, &state, &w, 0, 0), 1e-10);
        assert_close!(&hessian.qv, &block(&model, &state, &w, 0, n), 1e-10);
        assert_close!(&hessian.vv, &block(&model, &state, &w, n, n), 1e-10);
        assert_close!(&hessian.qa, &block(&model, &state, &w, 0, 2 * n), 1e-10);
        // What the docs say is zero.
        assert_close!(&block(&model, &state, &w, n, 2 * n), &DMatrix::zeros(n, n), 1e-12);
        assert_close!(&block(&model, &state, &w, 2 * n, 2 * n), &DMatrix::zeros(n, n), 1e-12);
    }

    #[test]
    fn the_contracted_mass_matrix_matches_duals((model, state, w) in model_state_weights()) {
        let n = model.dof();
        let mut k = DMatrix::zeros(n, n);
        mass_matrix_product_derivative(&model, &mut Data::new(&model), &state[..n], &w, &mut k).expect("lengths agree");
        let times_w = |q: &[Dual64]| {
            let mut h = DMatrix::zeros(n, n);
            crba(&model, &mut Data::new(&model), q, &mut h).expect("lengths agree");
            (0..n).map(|i| (0..n).fold(Dual64::from(0.0), |sum, j| sum + h[(i, j)] * w[j])).collect()
        };
        assert_close!(&k, &dual_jacobian(times_w, &state[..n]), 1e-10);
    }
}

#[test]
fn wrong_lengths_are_errors() {
    let model = crate::common::robot("pendulum_2");
    let data = &mut Data::new(&model);
    let (x, short) = ([0.0; 2], [0.0; 1]);
    let mut gradient = RneaVjp::new(2);
    let error = rnea_vjp(&model, data, &x, &x, &x, &short, &mut gradient);
    assert!(
        error
            .expect_err("short")
            .to_string()
            .contains("w: expected 2 entries, found 1")
    );
    let mut small = RneaWeightedHessian::new(1);
    rnea_weighted_hessian(&model, data, &x, &x, &x, &x, &mut small).expect_err("small");
    mass_matrix_product_derivative(&model, data, &x, &short, &mut DMatrix::zeros(2, 2))
        .expect_err("short");
}
