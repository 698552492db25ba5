//! Factors of symmetric matrices that need not be positive definite.

use faer::linalg::solvers::{Lblt, Solve};
use faer::{MatMut, MatRef, Side};
use nalgebra::{DMatrix, DVector};

/// The factor $L B L^T$ of a symmetric matrix, with pivots of one or two rows (Bunch and Kaufman; NW 3.4).
#[derive(Clone, Debug)]
pub struct Indefinite(Lblt<f64>);

impl Indefinite {
    /// Factorises a matrix, of which the lower triangle is read. It costs $O(n^3)$.
    #[must_use]
    pub fn new(matrix: &DMatrix<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        Self(Lblt::new(MatRef::from_column_major_slice(matrix.as_slice(), rows, columns), Side::Lower))
    }

    /// The numbers of positive, negative and all other eigenvalues (Sylvester); those are zero or not a number.
    #[must_use]
    pub fn inertia(&self) -> [usize; 3] {
        let (diagonal, below) = (self.0.B_diag().column_vector(), self.0.B_subdiag().column_vector());
        let n = diagonal.nrows();
        let [mut positive, mut negative, mut i] = [0; 3];
        while i < n {
            // The eigenvalues of the pivot; the second of one row is zero.
            let mut pair = [diagonal[i], 0.0];
            if i + 1 < n && below[i] != 0.0 {
                let [mean, half] = [0.5 * (diagonal[i] + diagonal[i + 1]), 0.5 * (diagonal[i] - diagonal[i + 1])];
                let root = half.hypot(below[i]);
                pair = [mean + root, mean - root];
                i += 1;
            }
            positive += pair.iter().filter(|value| **value > 0.0).count();
            negative += pair.iter().filter(|value| **value < 0.0).count();
            i += 1;
        }
        [positive, negative, n - positive - negative]
    }

    /// Replaces `b` by the solution.
    pub fn solve(&self, b: &mut DVector<f64>) {
        let n = b.len();
        self.0.solve_in_place(MatMut::from_column_major_slice_mut(b.as_mut_slice(), n, 1));
    }
}
