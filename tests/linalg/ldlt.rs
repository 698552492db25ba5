//! The factorisation of symmetric matrices.

use crate::common::{config, numbers};
use aghf::linalg::Ldlt;
use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;
use proptest::prelude::*;

/// A symmetric positive definite matrix.
fn definite(n: usize, x: &[f64]) -> DMatrix<f64> {
    let factor = DMatrix::from_column_slice(n, n, &x[..n * n]);
    &factor * factor.transpose() + DMatrix::identity(n, n)
}

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn ldlt_solves(n in 1..7_usize, x in numbers(36), b in numbers(6)) {
        let h = definite(n, &x);
        let mut ldlt = Ldlt::new(n);
        // Only the lower triangle is read.
        ldlt.factorise(&h.lower_triangle());
        let mut solution = b[..n].to_vec();
        ldlt.solve(&mut solution);
        assert_close!(&(&h * DVector::from_vec(solution)), &b[..n], 1e-10);
        prop_assert!(ldlt.pivots().all(|d| d >= 1.0 - 1e-9));
        prop_assert!((ldlt.pivots().product::<f64>() / h.determinant() - 1.0).abs() < 1e-10);
        let mut inverse = DMatrix::identity(n, n);
        ldlt.solve_columns(&mut inverse);
        assert_close!(&(h * inverse), &DMatrix::identity(n, n), 1e-10);
    }

    /// `d(H^-1 b) = H^-1 (db - dH H^-1 b)`.
    #[test]
    fn ldlt_differentiates(n in 1..6_usize, x in numbers(25), y in numbers(25), b in numbers(10)) {
        let h = definite(n, &x);
        let rate = definite(n, &y);
        let mut ldlt = Ldlt::new(n);
        ldlt.factorise(&h.zip_map(&rate, Dual64::new));
        let mut solution: Vec<Dual64> = (0..n).map(|i| Dual64::new(b[i], b[5 + i])).collect();
        ldlt.solve(&mut solution);
        let value = DVector::from_iterator(n, solution.iter().map(|s| s.re));
        let slope = DVector::from_iterator(n, solution.iter().map(|s| s.eps));
        assert_close!(&(h * slope), &(DVector::from_column_slice(&b[5..5 + n]) - rate * value), 1e-9);
    }
}
