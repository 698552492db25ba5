//! Block-tridiagonal matrices, such as the Hessian of a curve in which each segment is coupled only with its
//! neighbours.

use crate::scalar::Scalar;
use faer::dyn_stack::MemStack;
use faer::linalg::cholesky::llt::factor::{self, LltRegularization};
use faer::{MatMut, Par};
use nalgebra::{DMatrix, DVector};
use std::mem::MaybeUninit;

/// Memory of a factorisation, which it keeps for the next.
#[derive(Default)]
pub struct Scratch(Vec<MaybeUninit<u8>>);

/// A symmetric matrix of diagonal blocks, each coupled with the next only by its last few columns. Lower triangles are
/// stored.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockTridiagonal<S: Scalar> {
    /// The diagonal blocks.
    pub diagonal: Vec<DMatrix<S>>,
    /// Block `e + 1` by the last columns of block `e`.
    pub coupling: Vec<DMatrix<S>>,
}

impl<S: Scalar> BlockTridiagonal<S> {
    /// A zero matrix with diagonal blocks of these sizes, the last `shared` columns of each coupled with the next.
    #[must_use]
    pub fn new(sizes: &[usize], shared: usize) -> Self {
        let blocks = sizes.iter();
        Self {
            diagonal: blocks.clone().map(|n| DMatrix::zeros(*n, *n)).collect(),
            coupling: blocks.skip(1).map(|n| DMatrix::zeros(*n, shared)).collect(),
        }
    }

    /// The number of rows.
    #[must_use]
    pub fn order(&self) -> usize {
        self.diagonal.iter().map(DMatrix::nrows).sum()
    }

    /// All blocks.
    fn blocks(&self) -> impl Iterator<Item = &DMatrix<S>> {
        self.diagonal.iter().chain(&self.coupling)
    }

    /// All blocks.
    fn blocks_mut(&mut self) -> impl Iterator<Item = &mut DMatrix<S>> {
        self.diagonal.iter_mut().chain(&mut self.coupling)
    }

    /// Sets the matrix to `a + factor b`.
    pub fn set_sum(&mut self, a: &Self, factor: S, b: &Self) {
        for ((to, a), b) in self.blocks_mut().zip(a.blocks()).zip(b.blocks()) {
            to.zip_zip_apply(a, b, |to, a, b| *to = a + factor * b);
        }
    }

    /// The full matrix, both triangles.
    #[must_use]
    pub fn to_dense(&self) -> DMatrix<S> {
        let mut dense = DMatrix::zeros(self.order(), self.order());
        let mut at = 0;
        for (e, block) in self.diagonal.iter().enumerate() {
            let n = block.nrows();
            for j in 0..n {
                for i in j..n {
                    dense[(at + i, at + j)] = block[(i, j)];
                    dense[(at + j, at + i)] = block[(i, j)];
                }
            }
            at += n;
            if let Some(coupling) = self.coupling.get(e) {
                let before = at - coupling.ncols();
                let below = coupling.shape();
                dense.view_mut((at, before), below).copy_from(coupling);
                dense.view_mut((before, at), (below.1, below.0)).copy_from(&coupling.transpose());
            }
        }
        dense
    }
}

impl BlockTridiagonal<f64> {
    /// Computes the product with a vector.
    #[must_use]
    pub fn product(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut y = DVector::zeros(x.len());
        self.add_product(x, &mut y);
        y
    }

    /// Adds the product with the first entries of a vector to those of `y`.
    pub(crate) fn add_product(&self, x: &DVector<f64>, y: &mut DVector<f64>) {
        let mut at = 0;
        for (e, block) in self.diagonal.iter().enumerate() {
            let n = block.nrows();
            let own = x.rows(at, n);
            y.rows_mut(at, n).sygemv(1.0, block, &own, 1.0);
            at += n;
            if let Some(coupling) = self.coupling.get(e) {
                let (below, shared) = coupling.shape();
                let before = at - shared;
                let (upper, lower) = (x.rows(before, shared), x.rows(at, below));
                y.rows_mut(at, below).gemv(1.0, coupling, &upper, 1.0);
                y.rows_mut(before, shared).gemv_tr(1.0, coupling, &lower, 1.0);
            }
        }
    }

    /// Replaces the matrix by its Cholesky factor; returns true if it was positive definite. Otherwise the contents are
    /// undefined.
    pub fn factorise(&mut self) -> bool {
        self.factorise_in(&mut Scratch::default())
    }

    /// The same with memory that is kept.
    pub fn factorise_in(&mut self, scratch: &mut Scratch) -> bool {
        for e in 0..self.diagonal.len() {
            if !cholesky(&mut self.diagonal[e], scratch) {
                return false;
            }
            let Some(coupling) = self.coupling.get_mut(e) else {
                continue;
            };
            let (head, rest) = self.diagonal.split_at_mut(e + 1);
            // Only the last columns of the block below, and of its factor, are nonzero.
            let shared = coupling.ncols();
            let tail = head[e].nrows() - shared;
            let corner = head[e].view((tail, tail), (shared, shared)).into_owned();
            solve_right(&corner, coupling);
            rest[0].gemm(-1.0, coupling, &coupling.transpose(), 1.0);
        }
        true
    }

    /// Replaces the first entries of `b` by the solution; requires [`factorise`](Self::factorise).
    pub fn solve(&self, b: &mut DVector<f64>) {
        let mut at = 0;
        for (e, factor) in self.diagonal.iter().enumerate() {
            let n = factor.nrows();
            let mut own = b.rows_mut(at, n);
            factor.solve_lower_triangular_unchecked_mut(&mut own);
            at += n;
            if let Some(coupling) = self.coupling.get(e) {
                let (below, shared) = coupling.shape();
                let (known, mut own) = b.rows_range_pair_mut(at - shared..at, at..at + below);
                own.gemv(-1.0, coupling, &known, 1.0);
            }
        }
        for (e, factor) in self.diagonal.iter().enumerate().rev() {
            let n = factor.nrows();
            if let Some(coupling) = self.coupling.get(e) {
                let (below, shared) = coupling.shape();
                let (mut own, known) = b.rows_range_pair_mut(at - shared..at, at..at + below);
                own.gemv_tr(-1.0, coupling, &known, 1.0);
            }
            at -= n;
            let mut own = b.rows_mut(at, n);
            factor.tr_solve_lower_triangular_unchecked_mut(&mut own);
        }
    }
}

/// Replaces the lower triangle of a symmetric matrix by its Cholesky factor; returns true if it is positive definite.
fn cholesky(a: &mut DMatrix<f64>, Scratch(scratch): &mut Scratch) -> bool {
    let n = a.nrows();
    let needed = factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
    let needed = needed.unaligned_bytes_required();
    if scratch.len() < needed {
        scratch.resize(needed, MaybeUninit::uninit());
    }
    let columns = MatMut::from_column_major_slice_mut(a.as_mut_slice(), n, n);
    let factored = factor::cholesky_in_place(
        columns,
        LltRegularization::default(),
        Par::Seq,
        MemStack::new(scratch),
        Default::default(),
    );
    // An infinite pivot is not reported as an error.
    factored.is_ok() && (0..n).all(|i| a[(i, i)].is_finite())
}

/// Replaces `x` by $x L^{-T}$ for a lower triangular `l`.
fn solve_right(l: &DMatrix<f64>, x: &mut DMatrix<f64>) {
    for j in 0..l.nrows() {
        let (done, mut rest) = x.columns_range_pair_mut(0..j, j..);
        let mut column = rest.column_mut(0);
        column.gemv(-1.0, &done, &l.row(j).columns(0, j).transpose(), 1.0);
        column /= l[(j, j)];
    }
}
