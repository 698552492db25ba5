//! `H = L D L^T` without pivots, square roots or comparisons.

use super::Scalar;
use nalgebra::DMatrix;

/// The factors of a symmetric positive definite matrix.
///
/// `L` is unit lower triangular and `D` diagonal, with $H = L D L^T$. Neither pivoting nor a square root is needed for a
/// positive definite matrix (Golub and Van Loan, *Matrix Computations*, 4.1.2), so the factorisation runs over dual
/// numbers and over a field alike. Over `f64` a matrix that is not positive definite shows in [`Ldlt::pivots`].
#[derive(Clone, Debug)]
pub struct Ldlt<S: Scalar> {
    /// `L` strictly below the diagonal, `D` on it; above is unused and stays zero.
    factors: DMatrix<S>,
}

impl<S: Scalar> Ldlt<S> {
    /// Room for matrices of order `n`.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            factors: DMatrix::zeros(n, n),
        }
    }

    /// Factorises the `n` by `n` matrix `h`, of which it reads the lower triangle. About `n^3 / 3` operations.
    pub fn factorise(&mut self, h: &DMatrix<S>) {
        let n = self.factors.nrows();
        for j in 0..n {
            for i in j..n {
                let mut entry = h[(i, j)];
                for k in 0..j {
                    entry -= self.factors[(i, k)] * self.factors[(j, k)] * self.factors[(k, k)];
                }
                self.factors[(i, j)] = if i == j {
                    entry
                } else {
                    entry / self.factors[(j, j)]
                };
            }
        }
    }

    /// The diagonal of `D`: entry `i` is what column `i` of `H` has left once the columns before it are eliminated.
    pub fn pivots(&self) -> impl Iterator<Item = S> + '_ {
        (0..self.factors.nrows()).map(|i| self.factors[(i, i)])
    }

    /// Replaces `b` by $H^{-1} b$; `b` has `n` entries. About `2 n^2` operations.
    pub fn solve(&self, b: &mut [S]) {
        let n = self.factors.nrows();
        for i in 0..n {
            for k in 0..i {
                let known = b[k];
                b[i] -= self.factors[(i, k)] * known;
            }
        }
        for i in 0..n {
            b[i] /= self.factors[(i, i)];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                let known = b[k];
                b[i] -= self.factors[(k, i)] * known;
            }
        }
    }

    /// Replaces every column of `b` by $H^{-1}$ times it; `b` has `n` rows.
    pub fn solve_columns(&self, b: &mut DMatrix<S>) {
        let n = b.nrows();
        if n > 0 {
            for column in b.as_mut_slice().chunks_exact_mut(n) {
                self.solve(column);
            }
        }
    }
}
