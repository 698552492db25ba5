//! Explicit tensors of second derivatives with named contractions.
//!
//! One convention holds everywhere: **a derivative index comes last**, in the order of differentiation.
//!
//! - for a matrix `M`: $(dM)\_{ijk} = \partial M_{ij} / \partial x_k$,
//! - and $(d^2 M)\_{ijkl} = \partial^2 M_{ij} / (\partial x_k\\, \partial x_l)$;
//! - for a vector `f`: $(d^2 f)\_{ijk} = \partial^2 f_i / (\partial x_j\\, \partial y_k)$ in the field named `dxdy`.

use crate::error::{Result, check_length};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DMatrixView, DVector};
use std::ops::{Add, Index, IndexMut};

/// A tensor $T_{ijk}$ of `N` by `N` by `N` entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensor3<S: Scalar> {
    n: usize,
    /// Entries in the order in which the first index varies fastest.
    entries: Vec<S>,
}

/// A tensor $T_{ijkl}$ of `N` by `N` by `N` by `N` entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensor4<S: Scalar> {
    n: usize,
    /// Entries in the order in which the first index varies fastest.
    entries: Vec<S>,
}

impl<S: Scalar> Tensor3<S> {
    /// The zero tensor of order `n`.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { n, entries: vec![S::zero(); n.pow(3)] }
    }

    /// Sets every entry to `value`.
    pub fn fill(&mut self, value: S) {
        self.entries.fill(value);
    }

    /// All entries, in the order in which the first index varies fastest.
    #[must_use]
    pub fn entries(&self) -> &[S] {
        &self.entries
    }

    /// The matrices of the first two indices, one for each value of the third.
    fn slices(&self) -> impl Iterator<Item = DMatrixView<'_, S>> {
        (self.entries.chunks_exact((self.n * self.n).max(1)))
            .map(|slice| DMatrixView::from_slice(slice, self.n, self.n))
    }

    /// Computes the matrix $M_{jk} = \sum_i T_{ijk}\\, w_i$; `w` has `N` entries. Cost O(N^3).
    #[must_use]
    pub fn times_first(&self, w: &DVector<S>) -> DMatrix<S> {
        let mut result = DMatrix::zeros(self.n, self.n);
        for (mut column, slice) in result.column_iter_mut().zip(self.slices()) {
            column.gemv_tr(S::one(), &slice, w, S::zero());
        }
        result
    }

    /// Computes the matrix $M_{ik} = \sum_j T_{ijk}\\, w_j$; `w` has `N` entries. Cost O(N^3).
    #[must_use]
    pub fn times_second(&self, w: &DVector<S>) -> DMatrix<S> {
        let mut result = DMatrix::zeros(self.n, self.n);
        for (mut column, slice) in result.column_iter_mut().zip(self.slices()) {
            column.gemv(S::one(), &slice, w, S::zero());
        }
        result
    }

    /// Computes the matrix $M_{ij} = \sum_k T_{ijk}\\, w_k$; `w` has `N` entries. Cost O(N^3).
    #[must_use]
    pub fn times_third(&self, w: &DVector<S>) -> DMatrix<S> {
        let mut result = DMatrix::zeros(self.n, self.n);
        for (slice, factor) in self.slices().zip(w) {
            result.zip_apply(&slice, |sum, entry| *sum += entry * *factor);
        }
        result
    }

    /// Computes the tensor $R_{ijk} = \sum_l M_{il}\\, T_{ljk}$; `m` is `N` by `N`. Cost O(N^4).
    #[must_use]
    pub fn map_first(&self, m: &DMatrix<S>) -> Self {
        self.of_slices(|slice| m * slice)
    }

    /// Computes the tensor $R_{ijk} = \sum_l T_{ilk}\\, M_{lj}$; `m` is `N` by `N`. Cost O(N^4).
    #[must_use]
    pub fn map_second(&self, m: &DMatrix<S>) -> Self {
        self.of_slices(|slice| slice * m)
    }

    /// Computes the tensor $R_{ijk} = T_{ikj}$.
    #[must_use]
    pub fn swap_last(&self) -> Self {
        let mut result = Self::new(self.n);
        for k in 0..self.n {
            for j in 0..self.n {
                for i in 0..self.n {
                    result[(i, j, k)] = self[(i, k, j)];
                }
            }
        }
        result
    }

    /// Applies a function to each slice.
    fn of_slices(&self, f: impl Fn(DMatrixView<'_, S>) -> DMatrix<S>) -> Self {
        let entries = (self.slices()).flat_map(|slice| f(slice).as_slice().to_vec());
        Self { n: self.n, entries: entries.collect() }
    }

    /// Checks that the order of a result is `n`.
    pub(crate) fn check(&self, what: &'static str, n: usize) -> Result<()> {
        check_length(what, n, self.n)
    }
}

impl<S: Scalar> Tensor4<S> {
    /// The zero tensor of order `n`.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { n, entries: vec![S::zero(); n.pow(4)] }
    }

    /// Sets every entry to `value`.
    pub fn fill(&mut self, value: S) {
        self.entries.fill(value);
    }

    /// All entries, in the order in which the first index varies fastest.
    #[must_use]
    pub fn entries(&self) -> &[S] {
        &self.entries
    }

    /// Computes the tensor $R_{ijk} = \sum_l T_{ijkl}\\, w_l$ into `out`; `w` has `N` entries. Cost O(N^4).
    pub fn times_fourth(&self, w: &[S], out: &mut Tensor3<S>) {
        out.fill(S::zero());
        for (slice, factor) in (self.entries.chunks_exact(self.n.pow(3).max(1))).zip(w) {
            for (sum, entry) in out.entries.iter_mut().zip(slice) {
                *sum += *entry * *factor;
            }
        }
    }

    /// Computes the matrix $M_{kl} = \sum_{ij} T_{ijkl}\\, u_i\\, w_j$; `u` and `w` have `N` entries. Cost O(N^4).
    #[must_use]
    pub fn times_first_and_second(&self, u: &DVector<S>, w: &DVector<S>) -> DMatrix<S> {
        let slices = self.entries.chunks_exact((self.n * self.n).max(1));
        let entry = |slice| u.dot(&(DMatrixView::from_slice(slice, self.n, self.n) * w));
        DMatrix::from_iterator(self.n, self.n, slices.map(entry))
    }

    /// Checks that the order of a result is `n`.
    pub(crate) fn check(&self, what: &'static str, n: usize) -> Result<()> {
        check_length(what, n, self.n)
    }
}

impl<S: Scalar> Add<&Self> for Tensor3<S> {
    type Output = Self;
    fn add(mut self, other: &Self) -> Self {
        for (a, b) in self.entries.iter_mut().zip(&other.entries) {
            *a += *b;
        }
        self
    }
}

impl<S: Scalar> Index<(usize, usize, usize)> for Tensor3<S> {
    type Output = S;
    #[inline]
    fn index(&self, (i, j, k): (usize, usize, usize)) -> &S {
        &self.entries[i + self.n * (j + self.n * k)]
    }
}

impl<S: Scalar> IndexMut<(usize, usize, usize)> for Tensor3<S> {
    #[inline]
    fn index_mut(&mut self, (i, j, k): (usize, usize, usize)) -> &mut S {
        &mut self.entries[i + self.n * (j + self.n * k)]
    }
}

impl<S: Scalar> Index<(usize, usize, usize, usize)> for Tensor4<S> {
    type Output = S;
    #[inline]
    fn index(&self, (i, j, k, l): (usize, usize, usize, usize)) -> &S {
        &self.entries[i + self.n * (j + self.n * (k + self.n * l))]
    }
}

impl<S: Scalar> IndexMut<(usize, usize, usize, usize)> for Tensor4<S> {
    #[inline]
    fn index_mut(&mut self, (i, j, k, l): (usize, usize, usize, usize)) -> &mut S {
        &mut self.entries[i + self.n * (j + self.n * (k + self.n * l))]
    }
}
