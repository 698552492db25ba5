//! Factors of symmetric matrices that need not be positive definite.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::lblt::{factor, solve};
use faer::perm::PermRef;
use faer::{MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// The factor $L B L^T$ of a symmetric matrix, with pivots of one or two rows (Bunch and Kaufman; NW 3.4).
#[derive(Clone, Debug)]
pub struct Indefinite {
    /// $L$ with the diagonal of $B$ on its diagonal.
    lower: DMatrix<f64>,
    /// The diagonal of $B$, and its entries below that.
    pivots: [Diag<f64>; 2],
    /// The permutation of the rows, and its inverse.
    permutation: [Vec<usize>; 2],
}

impl Indefinite {
    /// Factorises a matrix, of which the lower triangle is read, on one core. It costs $O(n^3)$.
    #[must_use]
    pub fn new(mut matrix: DMatrix<f64>) -> Self {
        let n = matrix.nrows();
        let mut memory =
            MemBuffer::new(factor::cholesky_in_place_scratch::<usize, f64>(n, Par::Seq, Default::default()));
        let (mut below, [mut forward, mut backward]) = (Diag::zeros(n), [vec![0; n], vec![0; n]]);
        factor::cholesky_in_place(
            MatMut::from_column_major_slice_mut(matrix.as_mut_slice(), n, n),
            below.as_mut(),
            &mut forward,
            &mut backward,
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        let mut diagonal = Diag::zeros(n);
        for i in 0..n {
            diagonal[i] = matrix[(i, i)];
        }
        Self { lower: matrix, pivots: [diagonal, below], permutation: [forward, backward] }
    }

    /// The numbers of positive, negative and all other eigenvalues (Sylvester); those are zero or not a number.
    #[must_use]
    pub fn inertia(&self) -> [usize; 3] {
        let ([diagonal, below], n) = (&self.pivots, self.lower.nrows());
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

    /// Replaces the columns of `b`, one after the other, by the solutions.
    pub fn solve(&self, b: &mut [f64]) {
        let n = self.lower.nrows();
        let columns = b.len().checked_div(n).unwrap_or(0);
        let [diagonal, below] = &self.pivots;
        let [forward, backward] = &self.permutation;
        let mut memory = MemBuffer::new(solve::solve_in_place_scratch::<usize, f64>(n, columns, Par::Seq));
        solve::solve_in_place(
            MatRef::from_column_major_slice(self.lower.as_slice(), n, n),
            diagonal.as_ref(),
            below.as_ref(),
            PermRef::new_checked(forward, backward, n),
            MatMut::from_column_major_slice_mut(b, n, columns),
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }
}
