//! Weighted derivatives of inverse dynamics: their consistency and invalid input. Their correctness is tested in
//! `derivatives`.

use crate::common::{assert_refused, config, model_and_state, robot};
use aghf::dynamics::{
    Data, InverseDynamicsDerivatives, RneaVjp, RneaWeightedHessian, mass_matrix_product_derivative, rnea_derivatives,
    rnea_second_order, rnea_vjp, rnea_weighted_hessian,
};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn both_in_one_are_each_alone((model, q, v, a) in model_and_state()) {
        let n = model.dof();
        let (q, v, a) = (&q[..], &v[..], &a[..]);
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

}

#[test]
fn wrong_lengths_are_errors() {
    let model = robot("pendulum_2");
    let data = &mut Data::new(&model);
    let (x, short) = ([0.0; 2], [0.0; 1]);
    let mut gradient = RneaVjp::new(2);
    let short_w = "w: expected 2 entries, found 1";
    let vjp = rnea_vjp(&model, data, &x, &x, &x, &short, &mut gradient);
    assert_refused(vjp, short_w);
    let mut small = RneaWeightedHessian::new(1);
    let hessian = rnea_weighted_hessian(&model, data, &x, &x, &x, &x, &mut small);
    assert_refused(hessian, "expected 2 entries, found 1");
    let k = &mut DMatrix::zeros(2, 2);
    let product = mass_matrix_product_derivative(&model, data, &x, &short, k);
    assert_refused(product, short_w);
}
