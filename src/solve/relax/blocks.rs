//! Hessians at the points of a quadrature, and what pairs of functions make of them.

use super::Grid;
use crate::scalar::Scalar;
use nalgebra::DMatrix;

/// The blocks $W^{xy}$, `N` by `N`, of a Hessian in $z = [q; v; a]$ that have to be there, $x \le y$: the symmetric ones first.
const BLOCKS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Which of them $W^{xy}$ is.
const fn index(x: usize, y: usize) -> usize {
    if x == y { x } else { x + y + 2 }
}

/// Symmetric matrices in $z = [q; v; a]$, `3 N` by `3 N`, one at each point of a piece.
///
/// Two functions $\phi_a, \phi_b$ of a curve make a block of its Hessian of them, with $\phi^x$ the derivative that goes with `x`:
///
/// $$ \sum_{x, y} \phi_a^x \phi_b^y\, W^{xy} = \sum_x \phi_a^x \phi_b^x\, W^{xx} + \sum_{x < y}
///    (\phi_a^x \phi_b^y + \phi_a^y \phi_b^x) \frac{W^{xy} + W^{xy\,T}}{2} + (\phi_a^x \phi_b^y - \phi_a^y \phi_b^x) \frac{W^{xy} - W^{xy\,T}}{2}. $$
///
/// So the symmetric and the antisymmetric parts are kept, half of each, which takes half of the products that all blocks would.
#[derive(Clone, Debug)]
pub struct PointHessians<S: Scalar> {
    dof: usize,
    points: usize,
    /// A row for each $i \ge j$; a column for each point of each block.
    symmetric: DMatrix<S>,
    /// A row for each $i > j$; a column for each point of the blocks with $x < y$.
    antisymmetric: DMatrix<S>,
}

/// How many entries below the diagonal columns before `j` have, the diagonal with them.
fn before(n: usize, j: usize) -> usize {
    j * n - j * j.saturating_sub(1) / 2
}

impl<S: Scalar> PointHessians<S> {
    /// Zero at `points` points, for a robot with `dof` joints.
    #[must_use]
    pub fn new(dof: usize, points: usize) -> Self {
        let half = dof * dof.saturating_sub(1) / 2;
        Self {
            dof,
            points,
            symmetric: DMatrix::zeros(half + dof, 6 * points),
            antisymmetric: DMatrix::zeros(half, 3 * points),
        }
    }

    /// The rows where $i \ge j$ are kept, the second for $i > j$.
    fn rows(&self, i: usize, j: usize) -> (usize, usize) {
        let row = before(self.dof, j) + i - j;
        // Each column up to this has one on the diagonal.
        (row, row.wrapping_sub(j + 1))
    }

    /// Puts entries $(i, j)$ and $(j, i)$ of $W^{xy}$, $i \ge j$ and $x \le y$, of the points from `start` on.
    #[inline]
    pub(super) fn put(
        &mut self,
        start: usize,
        [x, y]: [usize; 2],
        [i, j]: [usize; 2],
        here: &[S],
        mirrored: &[S],
    ) {
        let (symmetric, antisymmetric) = self.rows(i, j);
        let column = index(x, y) * self.points + start;
        let half = S::from_f64(0.5);
        for (g, (a, b)) in here.iter().zip(mirrored).enumerate() {
            if x == y {
                self.symmetric[(symmetric, column + g)] = *a;
                continue;
            }
            self.symmetric[(symmetric, column + g)] = (*a + *b) * half;
            if i > j {
                let column = column + g - 3 * self.points;
                self.antisymmetric[(antisymmetric, column)] = (*a - *b) * half;
            }
        }
    }

    /// Makes the matrix of point `g` this one.
    pub fn set(&mut self, g: usize, matrix: &DMatrix<S>) {
        let n = self.dof;
        for (x, y) in BLOCKS {
            for j in 0..n {
                for i in j..n {
                    let [here, mirrored] =
                        [(i, j), (j, i)].map(|(i, j)| matrix[(x * n + i, y * n + j)]);
                    self.put(g, [x, y], [i, j], &[here], &[mirrored]);
                }
            }
        }
    }

    /// Adds a matrix in the first parts of $z$, `2 N` by `2 N` for $[q; v]$, to that of point `g`.
    pub fn add(&mut self, g: usize, matrix: &DMatrix<S>) {
        let mut sum = self.get(g);
        let mut part = sum.view_mut((0, 0), matrix.shape());
        part += matrix;
        self.set(g, &sum);
    }

    /// The matrix of point `g`.
    #[must_use]
    pub fn get(&self, g: usize) -> DMatrix<S> {
        let n = self.dof;
        DMatrix::from_fn(3 * n, 3 * n, |row, column| {
            let (row, column) = if row / n <= column / n {
                (row, column)
            } else {
                (column, row)
            };
            let (block, i, j) = (index(row / n, column / n), row % n, column % n);
            let (at, below) = self.rows(i.max(j), i.min(j));
            let symmetric = self.symmetric[(at, block * self.points + g)];
            if block < 3 || i == j {
                return symmetric;
            }
            let antisymmetric = self.antisymmetric[(below, (block - 3) * self.points + g)];
            if i > j {
                symmetric + antisymmetric
            } else {
                symmetric - antisymmetric
            }
        })
    }

    /// The block that each pair of functions of a piece makes, `N` by `N`, handed to `take`.
    pub(super) fn integrate(
        &self,
        grid: &Grid<S>,
        sums: &mut [DMatrix<S>; 2],
        mut take: impl FnMut(usize, &DMatrix<S>),
    ) {
        let n = self.dof;
        let [symmetric, antisymmetric] = sums;
        let products = grid.products();
        symmetric.gemm(S::one(), &self.symmetric, &products[0], S::zero());
        if n > 1 {
            antisymmetric.gemm(S::one(), &self.antisymmetric, &products[1], S::zero());
        }
        let mut block = DMatrix::zeros(n, n);
        for pair in 0..symmetric.ncols() {
            let (mut at, mut below) = (0, 0);
            for j in 0..n {
                for i in j..n {
                    let sum = symmetric[(at, pair)];
                    at += 1;
                    if i == j {
                        block[(i, j)] = sum;
                    } else {
                        let turned = antisymmetric[(below, pair)];
                        below += 1;
                        block[(i, j)] = sum + turned;
                        block[(j, i)] = sum - turned;
                    }
                }
            }
            take(pair, &block);
        }
    }

    /// Room for the sums that [`integrate`](Self::integrate) makes of so many pairs.
    pub(super) fn sums(dof: usize, pairs: usize) -> [DMatrix<S>; 2] {
        let half = dof * dof.saturating_sub(1) / 2;
        [half + dof, half].map(|rows| DMatrix::zeros(rows, pairs))
    }
}

/// The weighted products of functions that go with the parts that are kept: of the functions at the points of a piece, `table`, for
/// each of `pairs`.
pub(super) fn products<S: Scalar>(
    table: &DMatrix<S>,
    weights: &[S],
    pairs: &[(usize, usize)],
) -> [DMatrix<S>; 2] {
    let points = weights.len();
    let mut products = [6, 3].map(|rows| DMatrix::zeros(rows * points, pairs.len()));
    for (pair, &(a, b)) in pairs.iter().enumerate() {
        for (block, (x, y)) in BLOCKS.into_iter().enumerate() {
            for (g, weight) in weights.iter().enumerate() {
                let product = |x, y| *weight * table[(a, 3 * g + x)] * table[(b, 3 * g + y)];
                let row = block * points + g;
                if x == y {
                    products[0][(row, pair)] = product(x, x);
                } else {
                    products[0][(row, pair)] = product(x, y) + product(y, x);
                    products[1][(row - 3 * points, pair)] = product(x, y) - product(y, x);
                }
            }
        }
    }
    products
}
