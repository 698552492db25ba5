//! The factorisation `H = L D L^T` without pivots, square roots or comparisons.

use crate::scalar::Scalar;
use nalgebra::{DMatrix, Dyn, Matrix, RawStorage};

/// The factors of a symmetric positive definite matrix.
///
/// `L` is unit lower triangular and `D` diagonal, with $H = L D L^T$. A positive definite matrix needs neither pivoting
/// nor square roots (Golub and Van Loan, *Matrix Computations*, 4.1.2), so that the factorisation also works over dual
/// numbers and over a finite field. Over `f64` a matrix that is not positive definite shows in [`Ldlt::pivots`].
#[derive(Clone, Debug)]
pub struct Ldlt<S: Scalar> {
    /// `L` strictly below the diagonal, `D` on it; the upper triangle is unused and zero.
    factors: DMatrix<S>,
}

impl<S: Scalar> Ldlt<S> {
    /// Allocates the factors of matrices of order `n`.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { factors: DMatrix::zeros(n, n) }
    }

    /// Factorises the `n` by `n` matrix `h`, of which only the lower triangle is read. About `n^3 / 3` operations.
    pub fn factorise<V: RawStorage<S, Dyn, Dyn>>(&mut self, h: &Matrix<S, Dyn, Dyn, V>) {
        let n = self.factors.nrows();
        for j in 0..n {
            for i in j..n {
                self.factors[(i, j)] = h[(i, j)];
            }
        }
        // Each column is subtracted from those to its right, so that memory is accessed in order.
        for j in 0..n {
            let (done, right) = self.factors.as_mut_slice().split_at_mut((j + 1) * n);
            let column = &mut done[j * n + j..];
            let inverse = S::one() / column[0];
            for (c, target) in right.chunks_exact_mut(n).enumerate() {
                let below = &column[1 + c..];
                let factor = below[0] * inverse;
                for (x, l) in target[j + 1 + c..].iter_mut().zip(below) {
                    *x -= *l * factor;
                }
            }
            column[1..].iter_mut().for_each(|l| *l *= inverse);
        }
    }

    /// The diagonal of `D`: entry `i` is the diagonal entry of column `i` after elimination of the columns before it.
    pub fn pivots(&self) -> impl Iterator<Item = S> + '_ {
        (0..self.factors.nrows()).map(|i| self.factors[(i, i)])
    }

    /// Replaces `b` by $H^{-1} b$; `b` has `n` entries. About `2 n^2` operations.
    pub fn solve(&self, b: &mut [S]) {
        for k in 0..self.factors.nrows() {
            let [known, rest @ ..] = &mut b[k..] else {
                return;
            };
            for (x, l) in rest.iter_mut().zip(&self.column(k)[1..]) {
                *x -= *l * *known;
            }
        }
        for k in (0..self.factors.nrows()).rev() {
            let [unknown, rest @ ..] = &mut b[k..] else {
                return;
            };
            let column = self.column(k);
            let known = (rest.iter().zip(&column[1..])).fold(S::zero(), |sum, (x, l)| sum + *x * *l);
            *unknown = *unknown / column[0] - known;
        }
    }

    /// Column `k` of the factors from the diagonal down.
    fn column(&self, k: usize) -> &[S] {
        let n = self.factors.nrows();
        &self.factors.as_slice()[k * n + k..(k + 1) * n]
    }

    /// Replaces each column of `b`, `n` rows, by $H^{-1}$ times it.
    pub fn solve_columns(&self, b: &mut DMatrix<S>) {
        let n = b.nrows();
        if n > 0 {
            for column in b.as_mut_slice().chunks_exact_mut(n) {
                self.solve(column);
            }
        }
    }
}
