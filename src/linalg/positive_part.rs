//! The nearest positive semidefinite matrix.

use nalgebra::{DMatrix, SymmetricEigen};

/// Sets the negative eigenvalues of a symmetric matrix to zero; returns true if it has none. A matrix that is not
/// finite is left unchanged.
pub(crate) fn positive_part(from: &DMatrix<f64>, to: &mut DMatrix<f64>) -> bool {
    /// The relative rounding error of an eigenvalue that is zero.
    const ROUNDING: f64 = 1e-12;
    to.copy_from(from);
    // Most costs depend on a few variables only: zero rows and columns are left out.
    let own: Vec<usize> = (0..from.nrows()).filter(|i| from.column(*i).iter().any(|x| *x != 0.0)).collect();
    let inner = from.select_rows(&own).select_columns(&own);
    let shift = ROUNDING * inner.amax();
    let mut shifted = inner.clone();
    (0..own.len()).for_each(|i| shifted[(i, i)] += shift);
    if own.is_empty() || !shift.is_finite() || shifted.cholesky().is_some() {
        return true;
    }
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(inner);
    let mut scaled = eigenvectors.clone();
    for (mut column, value) in scaled.column_iter_mut().zip(eigenvalues.iter()) {
        column *= value.max(0.0);
    }
    let positive = scaled * eigenvectors.transpose();
    for (j, column) in own.iter().enumerate() {
        for (i, row) in own.iter().enumerate() {
            to[(*row, *column)] = positive[(i, j)];
        }
    }
    false
}
