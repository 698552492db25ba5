//! Gram matrices.

use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

/// The number of rows of a tile.
pub(crate) const ROWS: usize = 2;

/// Computes the lower triangle of $A^T D A$ from the columns of `A` and a diagonal `D`, in tiles that stay in
/// registers; `scaled` is memory for some columns of $D A$.
pub(crate) fn weighted_gram<'a, S: Scalar>(
    columns: impl Fn(usize) -> &'a [S],
    diagonal: &DVector<S>,
    scaled: &mut [Vec<S>; ROWS],
    out: &mut DMatrix<S>,
) {
    const COLUMNS: usize = 4;
    let last = out.nrows() - 1;
    for row in (0..=last).step_by(ROWS) {
        for (k, scaled) in scaled.iter_mut().enumerate() {
            let column = columns((row + k).min(last)).iter().zip(diagonal);
            scaled.clear();
            scaled.extend(column.map(|(x, d)| *x * *d));
        }
        for column in (0..=row + 1).step_by(COLUMNS) {
            let right: [&[S]; COLUMNS] = std::array::from_fn(|k| columns((column + k).min(last)));
            let mut sums = [[S::zero(); COLUMNS]; ROWS];
            for k in 0..diagonal.len() {
                for (sums, scaled) in sums.iter_mut().zip(&*scaled) {
                    for (sum, right) in sums.iter_mut().zip(&right) {
                        *sum += scaled[k] * right[k];
                    }
                }
            }
            for (i, sums) in sums.into_iter().enumerate() {
                for (j, sum) in sums.into_iter().enumerate() {
                    if row + i <= last && column + j <= last {
                        out[(row + i, column + j)] = sum;
                    }
                }
            }
        }
    }
}
