//! Factors of symmetric matrices that need not be positive definite.

use crate::common::{config, numbers};
use aghf::linalg::Indefinite;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

proptest! {
    #![proptest_config(config(128))]

    /// The inertia is that of the eigenvalues, and a solution satisfies the equations. Only the lower triangle is read.
    #[test]
    fn inertia_and_solution(n in 1..9_usize, x in numbers(64), b in numbers(8), zeros in 0..4_usize) {
        let half = DMatrix::from_column_slice(n, n, &x[..n * n]);
        let mut matrix = &half + half.transpose();
        // Pivots of two rows.
        matrix.view_mut((0, 0), (zeros.min(n), zeros.min(n))).fill_with_identity();
        for i in 0..zeros.min(n) {
            matrix[(i, i)] = 0.0;
        }
        let eigenvalues = matrix.clone().symmetric_eigenvalues();
        prop_assume!(eigenvalues.iter().all(|value| value.abs() > 1e-6));
        let factor = Indefinite::new(matrix.lower_triangle());
        let negative = eigenvalues.iter().filter(|value| **value < 0.0).count();
        prop_assert_eq!(factor.inertia(), [n - negative, negative, 0]);
        let mut solution = DVector::from_column_slice(&b[..n]);
        factor.solve(solution.as_mut_slice());
        assert_close!(&(matrix * solution), &b[..n], 1e-7);
    }
}

/// Zeros and numbers that are not finite are neither positive nor negative.
#[test]
fn neither_positive_nor_negative() {
    assert_eq!(Indefinite::new(DMatrix::zeros(3, 3)).inertia(), [0, 0, 3]);
    let [positive, negative, other] = Indefinite::new(DMatrix::from_element(2, 2, f64::NAN)).inertia();
    assert_eq!([positive, negative, other], [0, 0, 2]);
}
