//! Factors of block-tridiagonal symmetric matrices that need not be positive definite.

use super::Indefinite;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The factor of a symmetric matrix of diagonal blocks, each coupled with the next by a few of its columns, and of a
/// border: block by block, each with pivots of its own.
#[derive(Debug)]
pub struct BlockIndefinite {
    blocks: Vec<Block>,
    /// The solutions for the columns of the border.
    border: DMatrix<f64>,
    /// The factor of the Schur complement of the border, if there is one.
    corner: Option<Indefinite>,
}

/// The factor of a block after the elimination of those before.
#[derive(Debug)]
struct Block {
    factor: Indefinite,
    rows: Range<usize>,
    /// The coupling with the block before, and the rows of its columns in the whole matrix.
    coupling: DMatrix<f64>,
    before: Range<usize>,
    /// The solutions for the unit vectors of the columns that are coupled with the next block.
    units: DMatrix<f64>,
}

impl BlockIndefinite {
    /// Factorises a matrix of these diagonal blocks, of which the lower triangles are read. A coupling is the next
    /// block by these columns of a block; a border has columns of all rows and a corner of its own, or none. A block of
    /// `n` rows with `s` coupled columns costs $O(n^3 + s n^2)$.
    #[must_use]
    pub fn new(
        diagonal: Vec<DMatrix<f64>>,
        couplings: &[(Range<usize>, DMatrix<f64>)],
        (border, mut corner): (DMatrix<f64>, DMatrix<f64>),
    ) -> Self {
        let mut blocks = Vec::<Block>::new();
        for (e, mut matrix) in diagonal.into_iter().enumerate() {
            let (n, first) = (matrix.nrows(), blocks.last().map_or(0, |block| block.rows.end));
            let (mut coupling, mut before) = (DMatrix::zeros(n, 0), 0..0);
            if let Some(last) = blocks.last() {
                let (columns, of) = &couplings[e - 1];
                let product = of * last.units.rows_range(columns.clone());
                matrix.gemm(-1.0, &product, &of.transpose(), 1.0);
                let start = last.rows.start;
                (coupling, before) = (of.clone(), start + columns.start..start + columns.end);
            }
            let factor = Indefinite::new(matrix);
            let coupled = couplings.get(e).map_or(0..0, |(columns, _)| columns.clone());
            let mut units = DMatrix::zeros(n, coupled.len());
            units.rows_range_mut(coupled).fill_with_identity();
            factor.solve(units.as_mut_slice());
            blocks.push(Block { factor, rows: first..first + n, coupling, before, units });
        }
        let mut whole = Self { blocks, border: DMatrix::zeros(border.nrows(), 0), corner: None };
        if border.ncols() > 0 {
            let mut solutions = border.clone();
            for mut column in solutions.column_iter_mut() {
                let mut solution = column.clone_owned();
                whole.solve(&mut solution);
                column.copy_from(&solution);
            }
            corner.gemm_tr(-1.0, &border, &solutions, 1.0);
            (whole.border, whole.corner) = (solutions, Some(Indefinite::new(corner)));
        }
        whole
    }

    /// The numbers of positive, negative and all other eigenvalues; see [`Indefinite::inertia`].
    #[must_use]
    pub fn inertia(&self) -> [usize; 3] {
        let factors = self.blocks.iter().map(|block| &block.factor).chain(&self.corner);
        factors.fold([0; 3], |sum, of| {
            let own = of.inertia();
            [0, 1, 2].map(|i| sum[i] + own[i])
        })
    }

    /// Replaces `b`, with the rows of the border last, by the solution.
    pub fn solve(&self, b: &mut DVector<f64>) {
        let n = self.border.nrows();
        if self.corner.is_some() {
            let (head, mut tail) = b.rows_range_pair_mut(..n, n..);
            tail.gemv_tr(-1.0, &self.border, &head, 1.0);
        }
        for block in &self.blocks {
            let known = b.rows_range(block.before.clone()).into_owned();
            let mut own = b.rows_range_mut(block.rows.clone());
            own.gemv(-1.0, &block.coupling, &known, 1.0);
            block.factor.solve(&mut b.as_mut_slice()[block.rows.clone()]);
        }
        for (block, next) in self.blocks.iter().zip(self.blocks.iter().skip(1)).rev() {
            let known = next.coupling.tr_mul(&b.rows_range(next.rows.clone()));
            b.rows_range_mut(block.rows.clone()).gemv(-1.0, &block.units, &known, 1.0);
        }
        if let Some(corner) = &self.corner {
            corner.solve(&mut b.as_mut_slice()[n..]);
            let (mut head, tail) = b.rows_range_pair_mut(..n, n..);
            head.gemv(-1.0, &self.border, &tail, 1.0);
        }
    }
}
