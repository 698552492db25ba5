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
/// So twice the symmetric and twice the antisymmetric parts are kept, half of each, which takes half of the products that all blocks
/// would.
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

    /// The rows where $i \ge j$ is kept, the second for $i > j$.
    fn rows(&self, i: usize, j: usize) -> (usize, usize) {
        let row = before(self.dof, j) + i - j;
        // Each column up to this has one on the diagonal.
        (row, row.wrapping_sub(j + 1))
    }

    /// What is kept of $W^{xy}$, $x \le y$, at point `g`: $W_{ij} + W_{ji}$ for $i \ge j$, or $W_{ij}$ where $x = y$, and $W_{ij} - W_{ji}$ for
    /// $i > j$, column by column.
    pub(super) fn kept(&mut self, [x, y]: [usize; 2], g: usize) -> (&mut [S], &mut [S]) {
        let column = index(x, y) * self.points + g;
        let (rows, below) = (self.symmetric.nrows(), self.antisymmetric.nrows());
        let symmetric = &mut self.symmetric.as_mut_slice()[column * rows..(column + 1) * rows];
        if x == y {
            return (symmetric, &mut []);
        }
        let column = column - 3 * self.points;
        let antisymmetric = self.antisymmetric.as_mut_slice();
        (
            symmetric,
            &mut antisymmetric[column * below..(column + 1) * below],
        )
    }

    /// Makes the matrix of point `g` this one.
    pub fn set(&mut self, g: usize, matrix: &DMatrix<S>) {
        let n = self.dof;
        for (x, y) in BLOCKS {
            let (symmetric, antisymmetric) = self.kept([x, y], g);
            let entry = |i: usize, j: usize| matrix[(x * n + i, y * n + j)];
            fold(n, x == y, entry, symmetric, antisymmetric);
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
            if block < 3 {
                return symmetric;
            }
            let half = S::from_f64(0.5);
            if i == j {
                return symmetric * half;
            }
            let antisymmetric = self.antisymmetric[(below, (block - 3) * self.points + g)];
            if i > j {
                (symmetric + antisymmetric) * half
            } else {
                (symmetric - antisymmetric) * half
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

/// The sums and differences that [`PointHessians::kept`] speaks of, of the entries of a block.
#[inline]
pub(super) fn fold<T: Scalar>(
    n: usize,
    is_symmetric: bool,
    entry: impl Fn(usize, usize) -> T,
    symmetric: &mut [T],
    antisymmetric: &mut [T],
) {
    let (mut symmetric, mut antisymmetric) = (symmetric.iter_mut(), antisymmetric.iter_mut());
    for j in 0..n {
        for i in j..n {
            let here = entry(i, j);
            let Some(sum) = symmetric.next() else {
                return;
            };
            if is_symmetric {
                *sum = here;
                continue;
            }
            let mirrored = entry(j, i);
            *sum = here + mirrored;
            if i > j
                && let Some(difference) = antisymmetric.next()
            {
                *difference = here - mirrored;
            }
        }
    }
}

/// The weighted products of functions that go with the parts that are kept: of the functions at the points of a piece, `table`, for
/// each of `pairs`.
pub(super) fn products<S: Scalar>(
    table: &DMatrix<S>,
    weights: &[S],
    pairs: &[(usize, usize)],
) -> [DMatrix<S>; 2] {
    let (points, half) = (weights.len(), S::from_f64(0.5));
    let mut products = [6, 3].map(|rows| DMatrix::zeros(rows * points, pairs.len()));
    for (pair, &(a, b)) in pairs.iter().enumerate() {
        for (block, (x, y)) in BLOCKS.into_iter().enumerate() {
            for (g, weight) in weights.iter().enumerate() {
                let product = |x, y| *weight * table[(a, 3 * g + x)] * table[(b, 3 * g + y)];
                let row = block * points + g;
                if x == y {
                    products[0][(row, pair)] = product(x, x);
                } else {
                    let (one, other) = (product(x, y) * half, product(y, x) * half);
                    products[0][(row, pair)] = one + other;
                    products[1][(row - 3 * points, pair)] = one - other;
                }
            }
        }
    }
    products
}
