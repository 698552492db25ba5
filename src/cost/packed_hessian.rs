//! Hessians at quadrature points, and their products with pairs of functions.

use crate::linalg::multiply;
use crate::scalar::{LANES, Lanes, Scalar};
use nalgebra::{DMatrix, DVector};
use std::cmp::Ordering;

/// The stored blocks $W^{xy}$, `N` by `N`, of a Hessian in $z = [q; v; a]$, $x \le y$: the symmetric ones first.
const BLOCKS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// The index of $W^{xy}$ among them.
const fn index(x: usize, y: usize) -> usize {
    if x == y { x } else { x + y + 2 }
}

/// Symmetric matrices in $z = [q; v; a]$, `3 N` by `3 N`, one per point of a segment.
///
/// The block of the Hessian of a curve for two of its functions $\phi_a, \phi_b$ is, with $\phi^x$ the derivative that
/// belongs to `x`,
///
/// $$ \sum_{x, y} \phi_a^x \phi_b^y\\, W^{xy} = \sum_x \phi_a^x \phi_b^x\\, W^{xx} + \sum_{x < y}
///    (\phi_a^x \phi_b^y + \phi_a^y \phi_b^x) \frac{W^{xy} + W^{xy\\,T}}{2} + (\phi_a^x \phi_b^y - \phi_a^y \phi_b^x)
///    \frac{W^{xy} - W^{xy\\,T}}{2}. $$
///
/// Only half of twice the symmetric and half of twice the antisymmetric parts are stored, which halves the number of
/// products.
#[derive(Clone, Debug)]
pub struct PackedHessian<S: Scalar> {
    dof: usize,
    capacity: usize,
    /// One column for each $i \ge j$; one row per point and block.
    symmetric: DMatrix<S>,
    /// One column for each $i > j$; one row per point and block with $x < y$.
    antisymmetric: DMatrix<S>,
    /// A block of the Hessian of a curve.
    block: DMatrix<S>,
}

/// The number of points with storage, a multiple of the number of lanes.
fn capacity(points: usize) -> usize {
    points.next_multiple_of(LANES)
}

/// The number of entries on and below the diagonal in the columns before `j`.
fn before(n: usize, j: usize) -> usize {
    j * n - j * j.saturating_sub(1) / 2
}

impl<S: Scalar> PackedHessian<S> {
    /// Zeros at `points` points for a robot with `dof` joints.
    #[must_use]
    pub fn new(dof: usize, points: usize) -> Self {
        let half = dof * dof.saturating_sub(1) / 2;
        Self {
            dof,
            capacity: capacity(points),
            symmetric: DMatrix::zeros(6 * capacity(points), half + dof),
            antisymmetric: DMatrix::zeros(3 * capacity(points), half),
            block: DMatrix::zeros(dof, dof),
        }
    }

    /// The columns of the entry $i \ge j$; the second is for $i > j$.
    fn columns(&self, i: usize, j: usize) -> (usize, usize) {
        let column = before(self.dof, j) + i - j;
        // Each column of the block up to this has one on the diagonal.
        (column, column.wrapping_sub(j + 1))
    }

    /// Overwrites $W^{xy}$, $x \le y$, at `W` points from `start` on. Stored are $W_{ij} + W_{ji}$ for $i \ge j$, or
    /// $W_{ij}$ if $x = y$, and $W_{ij} - W_{ji}$ for $i > j$.
    #[inline]
    pub(crate) fn put<const W: usize>(
        &mut self,
        [x, y]: [usize; 2],
        start: usize,
        entry: impl Fn(usize, usize) -> Lanes<S, W>,
    ) {
        let row = index(x, y) * self.capacity + start;
        let columns = self.symmetric.as_mut_slice();
        let mut sums = columns.chunks_exact_mut(6 * self.capacity);
        let columns = self.antisymmetric.as_mut_slice();
        let mut differences = columns.chunks_exact_mut(3 * self.capacity);
        for j in 0..self.dof {
            for i in j..self.dof {
                let Some(sum) = sums.next() else {
                    return;
                };
                let here = entry(i, j);
                if x == y {
                    sum[row..row + W].copy_from_slice(&here.0);
                    continue;
                }
                let mirrored = entry(j, i);
                sum[row..row + W].copy_from_slice(&(here + mirrored).0);
                if i > j
                    && let Some(difference) = differences.next()
                {
                    let row = row - 3 * self.capacity;
                    difference[row..row + W].copy_from_slice(&(here - mirrored).0);
                }
            }
        }
    }

    /// Adds a matrix in $z$, or in its leading part $[q; v]$, to that of point `g`.
    pub fn add(&mut self, g: usize, matrix: &DMatrix<S>) {
        self.add_wide(g, &matrix.map(|x| Lanes([x])));
    }

    /// Adds a matrix to those of `W` points from `start` on, side by side.
    pub(crate) fn add_wide<const W: usize>(&mut self, start: usize, matrix: &DMatrix<Lanes<S, W>>) {
        fn add<S: Scalar, const W: usize>(to: &mut [S], from: Lanes<S, W>) {
            for (to, from) in to.iter_mut().zip(from.0) {
                *to += from;
            }
        }
        let n = self.dof;
        let parts = matrix.nrows() / n;
        let columns = self.symmetric.as_mut_slice();
        let mut sums = columns.chunks_exact_mut(6 * self.capacity);
        let columns = self.antisymmetric.as_mut_slice();
        let mut differences = columns.chunks_exact_mut(3 * self.capacity);
        for j in 0..n {
            for i in j..n {
                let Some(sum) = sums.next() else {
                    return;
                };
                let mut difference = if i > j { differences.next() } else { None };
                for (x, y) in BLOCKS.into_iter().filter(|(_, y)| *y < parts) {
                    let row = index(x, y) * self.capacity + start;
                    let here = matrix[(x * n + i, y * n + j)];
                    if x == y {
                        add(&mut sum[row..], here);
                        continue;
                    }
                    let mirrored = matrix[(x * n + j, y * n + i)];
                    add(&mut sum[row..], here + mirrored);
                    if let Some(difference) = &mut difference {
                        add(&mut difference[row - 3 * self.capacity..], here - mirrored);
                    }
                }
            }
        }
    }

    /// Copies the entries of a pair of joints, `i` not before `j`, from those of another pair, at all points.
    pub(super) fn copy_entry(&mut self, [a, b]: [usize; 2], other: &Self, [i, j]: [usize; 2]) {
        let (to, difference) = self.columns(a.max(b), a.min(b));
        let (from, other_difference) = other.columns(i, j);
        self.symmetric.set_column(to, &other.symmetric.column(from));
        if i > j {
            let sign = if a > b { S::one() } else { -S::one() };
            let column = other.antisymmetric.column(other_difference) * sign;
            self.antisymmetric.set_column(difference, &column);
        }
    }

    /// Adds to the second derivative in the acceleration of joint `i` at point `g`.
    pub(crate) fn add_acceleration(&mut self, g: usize, i: usize, second: S) {
        let (at, _) = self.columns(i, i);
        self.symmetric[(index(2, 2) * self.capacity + g, at)] += second;
    }

    /// Overwrites the matrix of point `g`.
    pub fn set(&mut self, g: usize, matrix: &DMatrix<S>) {
        let n = self.dof;
        for (x, y) in BLOCKS {
            self.put([x, y], g, |i, j| Lanes([matrix[(x * n + i, y * n + j)]]));
        }
    }

    /// The matrix of point `g`.
    #[must_use]
    pub fn get(&self, g: usize) -> DMatrix<S> {
        let n = self.dof;
        DMatrix::from_fn(3 * n, 3 * n, |row, column| {
            let (row, column) = if row / n <= column / n { (row, column) } else { (column, row) };
            let (block, i, j) = (index(row / n, column / n), row % n, column % n);
            let (at, below) = self.columns(i.max(j), i.min(j));
            let symmetric = self.symmetric[(block * self.capacity + g, at)];
            if block < 3 {
                return symmetric;
            }
            let half = S::from_f64(0.5);
            if i == j {
                return symmetric * half;
            }
            let antisymmetric = self.antisymmetric[((block - 3) * self.capacity + g, below)];
            if i > j { (symmetric + antisymmetric) * half } else { (symmetric - antisymmetric) * half }
        })
    }

    /// Computes the product of the matrix of point `g` with a vector of `3 N` entries, in O(N^2) operations.
    pub fn product(&self, g: usize, vector: &DVector<S>, out: &mut DVector<S>) {
        let (n, half) = (self.dof, S::from_f64(0.5));
        out.fill(S::zero());
        let columns = self.symmetric.as_slice();
        let mut sums = columns.chunks_exact(6 * self.capacity);
        let columns = self.antisymmetric.as_slice();
        let mut differences = columns.chunks_exact(3 * self.capacity);
        for j in 0..n {
            for i in j..n {
                let Some(sum) = sums.next() else {
                    return;
                };
                let difference = if i > j { differences.next() } else { None };
                for (block, (x, y)) in BLOCKS.into_iter().enumerate() {
                    let sum = sum[block * self.capacity + g];
                    // The entries (i, j) and (j, i) of the block.
                    let (here, mirrored) = match (difference, block.checked_sub(3)) {
                        (Some(of), Some(block)) => {
                            let difference = of[block * self.capacity + g];
                            ((sum + difference) * half, (sum - difference) * half)
                        }
                        (None, Some(_)) => (sum * half, sum * half),
                        (_, None) => (sum, sum),
                    };
                    let mut add = |row: usize, column: usize, entry: S| {
                        out[row] += entry * vector[column];
                    };
                    add(x * n + i, y * n + j, here);
                    if i > j {
                        add(x * n + j, y * n + i, mirrored);
                    }
                    if x < y {
                        add(y * n + j, x * n + i, here);
                        if i > j {
                            add(y * n + i, x * n + j, mirrored);
                        }
                    }
                }
            }
        }
    }

    /// Computes the `N` by `N` block of each pair of functions of a segment of time `horizon` times that of
    /// `products`, and passes it to `take`, which may change it.
    pub(crate) fn integrate(
        &mut self,
        products: &[DMatrix<S>; 2],
        horizon: S,
        sums: &mut [DMatrix<S>; 2],
        mut take: impl FnMut(usize, &mut DMatrix<S>),
    ) {
        let n = self.dof;
        self.scale(horizon);
        let [symmetric, antisymmetric] = sums;
        multiply(&products[0], &self.symmetric, symmetric);
        multiply(&products[1], &self.antisymmetric, antisymmetric);
        let block = &mut self.block;
        for pair in 0..symmetric.nrows() {
            let (mut at, mut below) = (0, 0);
            for j in 0..n {
                for i in j..n {
                    let sum = symmetric[(pair, at)];
                    at += 1;
                    if i == j {
                        block[(i, j)] = sum;
                    } else {
                        let turned = antisymmetric[(pair, below)];
                        below += 1;
                        block[(i, j)] = sum + turned;
                        block[(j, i)] = sum - turned;
                    }
                }
            }
            take(pair, block);
        }
    }

    /// Multiplies the blocks $W^{xy}$ by $T^{1 - x - y}$.
    fn scale(&mut self, horizon: S) {
        let rate = S::one() / horizon;
        let factors = BLOCKS.map(|(x, y)| (0..x + y).fold(horizon, |product, _| product * rate));
        for (matrix, factors) in [(&mut self.symmetric, &factors[..]), (&mut self.antisymmetric, &factors[3..])] {
            for mut column in matrix.column_iter_mut() {
                for (block, factor) in factors.iter().enumerate() {
                    let mut own = column.rows_mut(block * self.capacity, self.capacity);
                    own *= *factor;
                }
            }
        }
    }

    /// The entry $W^{xy}_{ij}$ at the points from `start` on.
    fn lanes(&self, [x, y]: [usize; 2], (i, j): (usize, usize), start: usize) -> Lanes<S, LANES> {
        if x > y {
            return self.lanes([y, x], (j, i), start);
        }
        let (at, below) = self.columns(i.max(j), i.min(j));
        let of = |matrix: &DMatrix<S>, block: usize, column: usize| {
            Lanes(std::array::from_fn(|lane| matrix[(block * self.capacity + start + lane, column)]))
        };
        let sum = of(&self.symmetric, index(x, y), at);
        if x == y {
            return sum;
        }
        let half = Lanes::splat(S::from_f64(0.5));
        match i.cmp(&j) {
            Ordering::Equal => sum * half,
            Ordering::Greater => (sum + of(&self.antisymmetric, index(x, y) - 3, below)) * half,
            Ordering::Less => (sum - of(&self.antisymmetric, index(x, y) - 3, below)) * half,
        }
    }

    /// Overwrites `out`, the matrices of a curve in the state $x = [q; v]$, by these, in $(x_{P1}, x_{P2}, \dot x_{P2})$,
    /// plus `stiff` times the square of the slip $\dot x_{P1} - x_{P2}$ halved.
    pub(crate) fn in_states(&self, stiff: S, out: &mut Self) {
        let (n, zero, stiff) = (self.dof, Lanes::splat(S::zero()), Lanes::splat(stiff));
        for start in (0..self.capacity).step_by(LANES) {
            let own = |xy, i: usize, j: usize| self.lanes(xy, (i % n, j % n), start);
            // Rows and columns are those of q, then those of v.
            out.put([0, 0], start, |i, j| {
                let entry = own([i / n, j / n], i, j);
                if i == j && i >= n { entry + stiff } else { entry }
            });
            out.put([1, 1], start, |i, j| match (i < n, j < n) {
                (false, false) => own([2, 2], i, j),
                (true, true) if i == j => stiff,
                _ => zero,
            });
            out.put([0, 1], start, |i, j| match j < n {
                false => own([i / n, 2], i, j),
                true if i == n + j => zero - stiff,
                true => zero,
            });
            for of_second in [[2, 2], [0, 2], [1, 2]] {
                out.put(of_second, start, |_, _| zero);
            }
        }
    }

    /// Storage for the sums of [`integrate`](Self::integrate) for this number of pairs.
    pub(crate) fn sums(dof: usize, pairs: usize) -> [DMatrix<S>; 2] {
        let half = dof * dof.saturating_sub(1) / 2;
        [half + dof, half].map(|columns| DMatrix::zeros(pairs, columns))
    }
}

/// The weighted products of functions that belong to the stored parts: of the functions at the points of a segment,
/// `table`, one row for each of `pairs`.
pub(crate) fn products<S: Scalar>(table: &DMatrix<S>, weights: &[S], pairs: &[(usize, usize)]) -> [DMatrix<S>; 2] {
    let (capacity, half) = (capacity(weights.len()), S::from_f64(0.5));
    let mut products = [6, 3].map(|blocks| DMatrix::zeros(pairs.len(), blocks * capacity));
    for (pair, &(a, b)) in pairs.iter().enumerate() {
        for (block, (x, y)) in BLOCKS.into_iter().enumerate() {
            for (g, weight) in weights.iter().enumerate() {
                let product = |x, y| *weight * table[(a, 3 * g + x)] * table[(b, 3 * g + y)];
                let column = block * capacity + g;
                if x == y {
                    products[0][(pair, column)] = product(x, x);
                } else {
                    let (one, other) = (product(x, y) * half, product(y, x) * half);
                    products[0][(pair, column)] = one + other;
                    products[1][(pair, column - 3 * capacity)] = one - other;
                }
            }
        }
    }
    products
}
