//! The ends of a periodic motion as unknowns.

use crate::direct::Period;
use crate::linalg::BlockTridiagonal;
use crate::nlp::{Bordered, Kkt};
use nalgebra::{DMatrix, DVector};

/// The ends of a periodic motion: the coefficients of slope and value at the start are the last unknowns, and those at
/// the end follow from them.
///
/// With the free coefficients $c = (c_0, \bar c, c_1)$ of the basis, whose first and last ones are slope and value at
/// start and end, $c = E (\bar c, b, y)$ is linear in the unknowns: $\bar c$, then those of the border `b`, then the
/// ends $y = c_0$ with $c_1 = P y$. Gradient and matrix are $E^T g$ and $E^T H E$. The columns of `y` are part of the
/// border, so that start and end, which are far from each other along the curve, do not fill the matrix.
pub(super) struct PeriodicEnds {
    pub period: Period,
    /// Gradient and matrix in all free coefficients and the border.
    gradient: DVector<f64>,
    hessian: Bordered,
}

impl PeriodicEnds {
    /// The ends for a matrix in all free coefficients and a border.
    pub fn new(period: Period, hessian: Bordered) -> Self {
        Self { period, gradient: DVector::zeros(hessian.order()), hessian }
    }

    /// The number of unknowns of the ends, slopes and values.
    pub fn count(&self) -> usize {
        2 * self.period.joints.len()
    }

    /// The unknown of the start from which coefficient `k` of the end follows, with its sign.
    fn source(&self, k: usize) -> (usize, f64) {
        let n = self.period.joints.len();
        let joint = k % n;
        (k - joint + self.period.joints[joint], self.period.signs[joint])
    }

    /// Exchanges gradient and matrix with those in all coefficients, or back.
    pub fn exchange(&mut self, out: &mut Kkt) {
        std::mem::swap(&mut self.gradient, &mut out.gradient);
        std::mem::swap(&mut self.hessian, &mut out.hessian);
    }

    /// Computes gradient and matrix in the unknowns.
    pub fn reduce(&self, out: &mut Kkt) {
        out.gradient.copy_from(&self.reduced_gradient(&self.gradient));
        self.reduce_matrix(&self.hessian, &mut out.hessian);
    }

    /// A gradient in the unknowns.
    pub fn reduced_gradient(&self, full: &DVector<f64>) -> DVector<f64> {
        let (ends, border) = (self.count(), self.hessian.border.ncols());
        let own = self.hessian.matrix.order() - 2 * ends;
        let mut to = DVector::zeros(own + border + ends);
        to.rows_mut(0, own).copy_from(&full.rows(ends, own));
        to.rows_mut(own, border).copy_from(&full.rows(own + 2 * ends, border));
        let of_ends = self.collect(&full.as_slice()[..own + 2 * ends]);
        to.rows_mut(own + border, ends).copy_from(&of_ends);
        to
    }

    /// A matrix in the unknowns.
    pub fn reduced(&self, full: &Bordered) -> Bordered {
        let (ends, border) = (self.count(), full.border.ncols());
        let last = full.matrix.diagonal.len() - 1;
        let blocks = full.matrix.diagonal.iter().enumerate();
        let sizes = blocks.map(|(e, block)| block.nrows() - self.cut(e, last).iter().sum::<usize>());
        let shared = full.matrix.coupling.first().map_or(0, DMatrix::ncols);
        let matrix = BlockTridiagonal::new(&sizes.collect::<Vec<_>>(), shared);
        let columns = border + ends;
        let mut reduced = Bordered {
            border: DMatrix::zeros(matrix.order(), columns),
            matrix,
            corner: DMatrix::zeros(columns, columns),
        };
        self.reduce_matrix(full, &mut reduced);
        reduced
    }

    /// The numbers of coefficients of the ends before and after the others of a block.
    fn cut(&self, block: usize, last: usize) -> [usize; 2] {
        [block == 0, block == last].map(|is_end| usize::from(is_end) * self.count())
    }

    /// The product of $E^T$ with a vector over all coefficients, in the unknowns of the ends.
    fn collect(&self, of: &[f64]) -> DVector<f64> {
        let ends = self.count();
        let mut sum = DVector::from_column_slice(&of[..ends]);
        for (k, value) in of[of.len() - ends..].iter().enumerate() {
            let (to, sign) = self.source(k);
            sum[to] += sign * value;
        }
        sum
    }

    /// The product of the matrix in all coefficients with the columns of $E$ of the ends.
    fn columns_of_ends(&self, full: &BlockTridiagonal<f64>) -> DMatrix<f64> {
        let (ends, order) = (self.count(), full.order());
        let mut columns = DMatrix::zeros(order, ends);
        let lower = |of: &DMatrix<f64>, i: usize, j: usize| of[(i.max(j), i.min(j))];
        let last = full.diagonal.len() - 1;
        let [first, bottom] = [&full.diagonal[0], &full.diagonal[last]];
        for k in 0..ends {
            for i in 0..first.nrows() {
                columns[(i, k)] += lower(first, i, k);
            }
            let (to, sign) = self.source(k);
            let (own, above) = (bottom.nrows() - ends + k, order - bottom.nrows());
            for i in 0..bottom.nrows() {
                columns[(above + i, to)] += sign * lower(bottom, i, own);
            }
            if let Some(coupling) = full.coupling.last() {
                for (i, value) in coupling.row(own).iter().enumerate() {
                    columns[(above - coupling.ncols() + i, to)] += sign * value;
                }
            }
        }
        columns
    }

    /// Computes a matrix in the unknowns.
    fn reduce_matrix(&self, full: &Bordered, out: &mut Bordered) {
        let (ends, border) = (self.count(), full.border.ncols());
        let (from, to) = (&full.matrix, &mut out.matrix);
        let last = from.diagonal.len() - 1;
        for (e, (from, to)) in from.diagonal.iter().zip(&mut to.diagonal).enumerate() {
            let first = self.cut(e, last)[0];
            to.copy_from(&from.view((first, first), to.shape()));
        }
        for (from, to) in from.coupling.iter().zip(&mut to.coupling) {
            to.copy_from(&from.rows(0, to.nrows()));
        }
        let own = out.border.nrows();
        let columns = self.columns_of_ends(from);
        let mut given = out.border.columns_mut(0, border);
        given.copy_from(&full.border.rows(ends, own));
        let mut of_ends = out.border.columns_mut(border, ends);
        of_ends.copy_from(&columns.rows(ends, own));
        let corner = &mut out.corner;
        corner.view_mut((0, 0), (border, border)).copy_from(&full.corner);
        for (j, column) in full.border.column_iter().enumerate() {
            let both = self.collect(column.as_slice());
            corner.view_mut((border, j), (ends, 1)).copy_from(&both);
            let both = both.transpose();
            corner.view_mut((j, border), (1, ends)).copy_from(&both);
        }
        for (j, column) in columns.column_iter().enumerate() {
            let both = self.collect(column.as_slice());
            let mut to = corner.view_mut((border, border + j), (ends, 1));
            to.copy_from(&both);
        }
    }
}
