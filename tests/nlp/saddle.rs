//! Steps of the saddle-point equations against those of the dense matrix.

use crate::common::{config, numbers};
use crate::dense::unit_norm;
use aghf::nlp::{Kkt, Options, Progress};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// The equations with the unit matrix as norm.
fn system(hessian: &DMatrix<f64>, slopes: &DMatrix<f64>, gradient: &[f64], values: &[f64]) -> Kkt {
    let mut kkt = unit_norm(hessian.nrows());
    kkt.hessian.matrix.diagonal[0].copy_from(hessian);
    kkt.gradient.copy_from_slice(gradient);
    kkt.equalities.slopes = slopes.clone();
    kkt.equalities.values = DVector::from_column_slice(values);
    kkt
}

proptest! {
    #![proptest_config(config(128))]

    /// The step keeps the linearised equalities, the gradient of the Lagrangian with the changed multipliers vanishes,
    /// and the multiple of the norm is zero if and only if the Hessian is positive definite along the equalities.
    #[test]
    fn steps_solve_the_equations(n in 2..7_usize, m in 1..4_usize, x in numbers(36), rows in numbers(24),
                                 b in numbers(12)) {
        let m = m.min(n - 1);
        let half = DMatrix::from_column_slice(n, n, &x[..n * n]);
        let hessian = &half + half.transpose();
        let slopes = DMatrix::from_column_slice(n, m, &rows[..n * m]);
        let svd = slopes.clone().svd(true, false);
        prop_assume!(svd.singular_values.min() > 1e-2);
        let mut kkt = system(&hessian, &slopes, &b[..n], &b[6..6 + m]);
        let mut progress = Progress::default();
        let step = kkt.step(1.0, &mut progress, &Options::default()).expect("a multiple of the norm is enough");
        let multiple = progress.regularisation;
        assert_close!(&(slopes.tr_mul(&step.x) + &kkt.equalities.values), &vec![0.0; m][..], 1e-8);
        let matrix = &hessian + DMatrix::identity(n, n) * multiple;
        let rest = &matrix * &step.x + &slopes * &step.multipliers + &kkt.gradient;
        assert_close!(&rest, &vec![0.0; n][..], 1e-6);
        // Along the equalities.
        let range = svd.u.expect("it was asked for");
        let project = DMatrix::identity(n, n) - &range * range.transpose();
        let along = &project * &hessian * &project + (DMatrix::identity(n, n) - &project) * 1e3;
        let least = along.symmetric_eigenvalues().min();
        prop_assume!(least.abs() > 1e-6);
        prop_assert_eq!(multiple == 0.0, least > 0.0);
    }
}

/// Equalities that follow from others leave the step as it is.
#[test]
fn dependent_equalities() {
    let hessian = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 2.0, 4.0]));
    let mut found = Vec::new();
    for copies in 1..4 {
        let slopes = DMatrix::from_fn(3, copies, |i, _| [1.0, 1.0, 0.0][i]);
        let mut kkt = system(&hessian, &slopes, &[1.0, 0.0, 1.0], &vec![0.5; copies]);
        let step = kkt.step(1.0, &mut Progress::default(), &Options::default());
        found.push(step.expect("it is definite along the equalities").x);
    }
    for step in &found {
        assert_close!(step, &found[0], 1e-6);
    }
}
