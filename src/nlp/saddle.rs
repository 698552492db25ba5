//! The equalities in the primal-dual equations.
//!
//! The step $p$ and the change $l$ of the multipliers solve
//!
//! $$ W p + A^T l = -g, \quad A p - \delta_c l = -c . $$
//!
//! It is a step of descent along the equalities if and only if the matrix of these equations has as many positive
//! eigenvalues as there are unknowns and as many negative ones as there are equalities (NW 16.3).
//!
//! An equality depends on the unknowns of one block of $W$, on those with which the block before is coupled, and on the
//! border. With the multipliers of each block after its unknowns the matrix has the blocks of $W$, is factorised block
//! by block, and has the sum of the inertias of the blocks and of the border.

use super::Bordered;
use crate::linalg::BlockIndefinite;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The least change of an equality per change of its multiplier if rows are dependent, for an objective of the size 1:
/// $\delta_c$ as in WB (3.1).
const COMPLIANCE: f64 = 1e-8;

/// The gradients and the values of the equalities at an iterate, and the factor of the matrix.
#[derive(Debug, Default)]
pub struct Saddle {
    slopes: Vec<Slope>,
    pub values: DVector<f64>,
    factor: Option<BlockIndefinite>,
    /// The rows of the factor of the unknowns before the border, and of the equalities.
    rows: [Vec<usize>; 2],
    compliance: f64,
}

/// The gradient of an equality.
#[derive(Debug)]
struct Slope {
    block: usize,
    /// The unknowns of the block and those of the block before on which it may depend, and its derivatives in them.
    range: Range<usize>,
    own: DVector<f64>,
    border: DVector<f64>,
}

impl Saddle {
    /// Returns true if there are no equalities.
    pub fn is_empty(&self) -> bool {
        self.slopes.is_empty()
    }

    /// Removes all equalities.
    pub fn clear(&mut self) {
        self.slopes.clear();
    }

    /// Adds an equality with this gradient, which depends on the unknowns of one block of the matrix, on those with
    /// which the block before is coupled and on the border alone.
    pub fn push(&mut self, hessian: &Bordered, block: usize, gradient: &DVector<f64>) {
        let blocks = &hessian.matrix.diagonal;
        let first: usize = blocks[..block].iter().map(DMatrix::nrows).sum();
        let shared = block.checked_sub(1).map_or(0, |before| hessian.matrix.coupling[before].ncols());
        let range = first - shared..first + blocks[block].nrows();
        let border = gradient.rows_range(hessian.border.nrows()..).into_owned();
        self.slopes.push(Slope { block, own: gradient.rows_range(range.clone()).into_owned(), range, border });
    }

    /// Factorises the matrix with `W`; returns false if it has not the inertia of a minimum. Dependent equalities get a
    /// compliance relative to `scale`.
    pub(super) fn factorise(&mut self, hessian: &Bordered, scale: f64) -> bool {
        self.rows = self.places(hessian);
        let m = self.slopes.len();
        match self.factorise_with(hessian, 0.0) {
            None => true,
            Some([_, negative, zero]) if negative > m && zero == 0 => false,
            Some(_) => self.relax(hessian, scale),
        }
    }

    /// Returns true if the factor has a compliance.
    pub(super) fn is_relaxed(&self) -> bool {
        self.compliance > 0.0
    }

    /// Factorises the matrix with a compliance, for equalities that are dependent but for rounding; returns false if it
    /// has not the inertia of a minimum.
    pub(super) fn relax(&mut self, hessian: &Bordered, scale: f64) -> bool {
        self.factorise_with(hessian, COMPLIANCE / scale).is_none()
    }

    /// Factorises the matrix with a compliance; returns its inertia if it is not that of a minimum.
    fn factorise_with(&mut self, hessian: &Bordered, compliance: f64) -> Option<[usize; 3]> {
        let factor = self.factor_with(hessian, compliance);
        let inertia = factor.inertia();
        (self.factor, self.compliance) = (Some(factor), compliance);
        (inertia[..2] != [hessian.order(), self.slopes.len()]).then_some(inertia)
    }

    /// The rows of the unknowns before the border, and of the equalities, each after the unknowns of its block.
    fn places(&self, hessian: &Bordered) -> [Vec<usize>; 2] {
        let (mut unknowns, mut equalities) = (Vec::new(), vec![0; self.slopes.len()]);
        let mut next = 0;
        for (e, block) in hessian.matrix.diagonal.iter().enumerate() {
            unknowns.extend(next..next + block.nrows());
            next += block.nrows();
            for (slope, row) in self.slopes.iter().zip(&mut equalities) {
                if slope.block == e {
                    *row = next;
                    next += 1;
                }
            }
        }
        [unknowns, equalities]
    }

    /// The factor of the matrix with a compliance of all equalities.
    fn factor_with(&self, hessian: &Bordered, compliance: f64) -> BlockIndefinite {
        let [unknowns, equalities] = &self.rows;
        let order = unknowns.len() + equalities.len();
        let mut border = DMatrix::zeros(order, hessian.corner.ncols());
        for (from, to) in hessian.border.row_iter().zip(unknowns) {
            border.row_mut(*to).copy_from(&from);
        }
        let (mut diagonal, mut couplings, mut first) = (Vec::new(), Vec::new(), 0);
        for (e, block) in hessian.matrix.diagonal.iter().enumerate() {
            let n = block.nrows();
            let own = self.slopes.iter().zip(equalities).filter(|(slope, _)| slope.block == e);
            let count = n + own.clone().count();
            let mut matrix = DMatrix::zeros(count, count);
            matrix.view_mut((0, 0), (n, n)).copy_from(block);
            let before = e.checked_sub(1).map(|before| &hessian.matrix.coupling[before]);
            let shared = before.map_or(0, DMatrix::ncols);
            let mut coupling = DMatrix::zeros(count, shared);
            if let Some(before) = before {
                coupling.rows_mut(0, n).copy_from(before);
            }
            for (slope, row) in own {
                border.row_mut(*row).tr_copy_from(&slope.border);
                let (row, (above, here)) = (row - first, slope.own.rows_range_pair(..shared, shared..));
                coupling.row_mut(row).tr_copy_from(&above);
                matrix.view_mut((row, 0), (1, n)).tr_copy_from(&here);
                matrix[(row, row)] = -compliance;
            }
            if e > 0 {
                let end = hessian.matrix.diagonal[e - 1].nrows();
                couplings.push((end - shared..end, coupling));
            }
            diagonal.push(matrix);
            first += count;
        }
        BlockIndefinite::new(diagonal, &couplings, (border, hessian.corner.clone()))
    }

    /// Solves $W p + A^T l = b$, $A p - \delta_c l = e$: replaces `b` by `p` and `e` by `l`.
    pub(super) fn solve(&self, b: &mut DVector<f64>, e: &mut DVector<f64>) {
        let Some(factor) = &self.factor else {
            return;
        };
        let [unknowns, equalities] = &self.rows;
        let border = unknowns.len() + equalities.len()..b.len() + e.len();
        let (mut both, rows) = (DVector::zeros(border.end), unknowns.iter().copied().chain(border));
        for (value, row) in b.iter().zip(rows.clone()).chain(e.iter().zip(equalities.iter().copied())) {
            both[row] = *value;
        }
        factor.solve(&mut both);
        for (value, row) in b.iter_mut().zip(rows).chain(e.iter_mut().zip(equalities.iter().copied())) {
            *value = both[row];
        }
    }

    /// The rounding of $A^T l$.
    pub(super) fn rounding(&self, l: &DVector<f64>) -> f64 {
        let largest = self.slopes.iter().zip(l).map(|(slope, l)| l.abs() * slope.own.amax().max(slope.border.amax()));
        f64::EPSILON * largest.fold(0.0, f64::max)
    }

    /// Subtracts $A^T l$ from `b`, and $A p - \delta_c l$ from `e`.
    pub(super) fn subtract(&self, [p, l]: [&DVector<f64>; 2], b: &mut DVector<f64>, e: &mut DVector<f64>) {
        for (j, Slope { range, own, border, .. }) in self.slopes.iter().enumerate() {
            let last = p.len() - border.len()..;
            e[j] += self.compliance * l[j];
            e[j] -= own.dot(&p.rows_range(range.clone())) + border.dot(&p.rows_range(last.clone()));
            b.rows_range_mut(range.clone()).axpy(-l[j], own, 1.0);
            b.rows_range_mut(last).axpy(-l[j], border, 1.0);
        }
    }
}
