//! The integral of a running cost along a curve of a basis, with its derivatives in the coefficients.

use super::{BlockTridiagonal, Grid, Point, PointCost, PointDerivatives};
use crate::error::{Result, check_length};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

/// The sum $\sum_g w_g\, l(q, \dot q, \ddot q)$ over the points of a [`Grid`], a function of the coefficients `N` by `count`.
///
/// With $\phi_m^x$ the function `m` (`x` = 0) and its derivatives at a point and $W^{xy}$ the `N` by `N` blocks of the Hessian of `l` there,
///
/// $$ \frac{\partial}{\partial c_m} = \sum_g w_g \sum_x \phi_m^x \frac{\partial l}{\partial z^x}, \qquad
///    \frac{\partial^2}{\partial c_m \partial c_n} = \sum_g w_g \sum_{x, y} \phi_m^x \phi_n^y\, W^{xy}. $$
///
/// The products of functions are tabulated, so all blocks of the Hessian of a piece with `p` functions and `M` points are one product of
/// matrices: $N^2$ by $9 M$ times $9 M$ by $p^2 / 2$.
pub struct Objective<'g, S: Scalar, P> {
    grid: &'g Grid<S>,
    cost: P,
    dof: usize,
    /// $q, v, a$ at the points of a piece, one column each.
    states: DMatrix<S>,
    gradients: DMatrix<S>,
    point: PointDerivatives<S>,
    /// The blocks $W^{xy}$ at the points of a piece, one column each.
    hessians: DMatrix<S>,
    metrics: DMatrix<S>,
    blocks: DMatrix<S>,
    gradient: DMatrix<S>,
}

/// The derivatives of an objective in the unknown coefficients, function by function.
#[derive(Clone, Debug)]
pub struct Derivatives<S: Scalar> {
    /// The gradient.
    pub gradient: DVector<S>,
    /// The Hessian.
    pub hessian: BlockTridiagonal<S>,
    /// The metric of Gauss and Newton.
    pub metric: BlockTridiagonal<S>,
}

impl<S: Scalar> Derivatives<S> {
    /// Room for the unknowns of a grid, for a robot with `dof` joints.
    #[must_use]
    pub fn new(grid: &Grid<S>, dof: usize) -> Self {
        let sizes: Vec<_> = (0..grid.pieces)
            .map(|e| grid.block(e).len() * dof)
            .collect();
        let matrix = BlockTridiagonal::new(&sizes, 2 * dof);
        Self {
            gradient: DVector::zeros(grid.free.len() * dof),
            hessian: matrix.clone(),
            metric: matrix,
        }
    }
}

impl<'g, S: Scalar, P: PointCost<S>> Objective<'g, S, P> {
    /// The integral of `cost` for a robot with `dof` joints.
    #[must_use]
    pub fn new(grid: &'g Grid<S>, cost: P, dof: usize) -> Self {
        let (points, functions) = (grid.points(), grid.table.nrows());
        Self {
            grid,
            cost,
            dof,
            states: DMatrix::zeros(dof, 3 * points),
            gradients: DMatrix::zeros(dof, 3 * points),
            point: PointDerivatives::new(dof),
            hessians: DMatrix::zeros(dof * dof, 9 * points),
            metrics: DMatrix::zeros(dof * dof, 9 * points),
            blocks: DMatrix::zeros(dof * dof, grid.pairs.len()),
            gradient: DMatrix::zeros(dof, functions),
        }
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &'g Grid<S> {
        self.grid
    }

    /// `N`.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// The integral.
    ///
    /// # Errors
    /// `coefficients` has the wrong size.
    pub fn value(&mut self, coefficients: &DMatrix<S>) -> Result<S> {
        self.check(coefficients)?;
        let mut sum = S::zero();
        for e in 0..self.grid.pieces {
            self.place(coefficients, e);
            for g in 0..self.grid.points() {
                let point = point(self.grid, &self.states, e, g);
                sum += self.grid.weights[g] * self.cost.value(point)?;
            }
        }
        Ok(sum)
    }

    /// The integral, and its derivatives into `out`.
    ///
    /// # Errors
    /// `coefficients` has the wrong size.
    pub fn derivatives(
        &mut self,
        coefficients: &DMatrix<S>,
        out: &mut Derivatives<S>,
    ) -> Result<S> {
        self.check(coefficients)?;
        out.gradient.fill(S::zero());
        out.hessian.fill_zero();
        out.metric.fill_zero();
        let mut sum = S::zero();
        for e in 0..self.grid.pieces {
            self.place(coefficients, e);
            for g in 0..self.grid.points() {
                let at = point(self.grid, &self.states, e, g);
                let weight = self.grid.weights[g];
                sum += weight * self.cost.derivatives(at, &mut self.point)?;
                self.keep(g, weight);
            }
            self.gradient
                .gemm(S::one(), &self.gradients, &self.grid.transposed, S::zero());
            self.add_gradient(e, &mut out.gradient);
            let products = &self.grid.products;
            self.blocks
                .gemm(S::one(), &self.hessians, products, S::zero());
            self.add_blocks(&self.blocks, e, &mut out.hessian);
            self.blocks
                .gemm(S::one(), &self.metrics, products, S::zero());
            self.add_blocks(&self.blocks, e, &mut out.metric);
        }
        Ok(sum)
    }

    /// The Gram matrix of the velocities: the square of the norm is $\tfrac{T}{\pi^2} \int |\delta v|^2 dt$, which for
    /// the longest wave that vanishes at both ends is the mean square of $\delta q$.
    #[must_use]
    pub fn gram(&self) -> BlockTridiagonal<S> {
        let (n, grid) = (self.dof, self.grid);
        let pieces = S::from_f64(grid.pieces as f64 / std::f64::consts::PI.powi(2));
        let scale = grid.weights.iter().fold(S::zero(), |sum, w| sum + *w) * pieces;
        let mut blocks = DMatrix::zeros(n * n, grid.pairs.len());
        for pair in 0..grid.pairs.len() {
            let velocities = (0..grid.points()).map(|g| grid.products[(9 * g + 4, pair)]);
            let entry = scale * velocities.fold(S::zero(), |sum, x| sum + x);
            (0..n).for_each(|j| blocks[(j * (n + 1), pair)] = entry);
        }
        let mut gram = Derivatives::new(grid, n).hessian;
        for e in 0..grid.pieces {
            self.add_blocks(&blocks, e, &mut gram);
        }
        gram
    }

    fn check(&self, coefficients: &DMatrix<S>) -> Result<()> {
        check_length("coefficients", self.dof, coefficients.nrows())?;
        check_length("coefficients", self.grid.count(), coefficients.ncols())
    }

    /// The curve at the points of piece `e`.
    fn place(&mut self, coefficients: &DMatrix<S>, e: usize) {
        let own = coefficients.columns(self.grid.first(e), self.grid.table.nrows());
        self.states
            .gemm(S::one(), &own, &self.grid.table, S::zero());
    }

    /// Files the derivatives at point `g`: the gradient weighted, the others not, as the table of products has the weights.
    fn keep(&mut self, g: usize, weight: S) {
        let n = self.dof;
        for x in 0..3 {
            let gradient = self.point.gradient.rows(x * n, n) * weight;
            self.gradients.set_column(3 * g + x, &gradient);
            for y in 0..3 {
                let column = (9 * g + 3 * x + y) * n * n;
                let pairs = [
                    (&self.point.hessian, &mut self.hessians),
                    (&self.point.metric, &mut self.metrics),
                ];
                for (from, to) in pairs {
                    let to = &mut to.as_mut_slice()[column..column + n * n];
                    for (j, to) in to.chunks_exact_mut(n).enumerate() {
                        let start = (y * n + j) * 3 * n + x * n;
                        to.copy_from_slice(&from.as_slice()[start..start + n]);
                    }
                }
            }
        }
    }

    fn add_gradient(&self, e: usize, out: &mut DVector<S>) {
        let (n, first, free) = (self.dof, self.grid.first(e), &self.grid.free);
        for (m, column) in self.gradient.column_iter().enumerate() {
            if free.contains(&(first + m)) {
                let mut target = out.rows_mut((first + m - free.start) * n, n);
                target += column;
            }
        }
    }

    /// Adds the blocks of piece `e` where they belong.
    fn add_blocks(&self, blocks: &DMatrix<S>, e: usize, out: &mut BlockTridiagonal<S>) {
        let (n, first, free) = (self.dof, self.grid.first(e), &self.grid.free);
        for (pair, &(a, b)) in self.grid.pairs.iter().enumerate() {
            if !(free.contains(&(first + a)) && free.contains(&(first + b))) {
                continue;
            }
            let block = &blocks.as_slice()[pair * n * n..(pair + 1) * n * n];
            // Functions 0 and 1 of a piece are the last two of the block before.
            let mut target = match (a < 2, b < 2) {
                (false, false) => out.diagonal[e].view_mut(((a - 2) * n, (b - 2) * n), (n, n)),
                (false, true) => out.coupling[e - 1].view_mut(((a - 2) * n, b * n), (n, n)),
                (true, _) => {
                    let matrix = &mut out.diagonal[e - 1];
                    let tail = matrix.nrows() - 2 * n;
                    matrix.view_mut((tail + a * n, tail + b * n), (n, n))
                }
            };
            for (j, mut column) in target.column_iter_mut().enumerate() {
                for (x, y) in column.iter_mut().zip(&block[j * n..(j + 1) * n]) {
                    *x += *y;
                }
            }
        }
    }
}

/// What the running cost reads at point `g` of piece `e`.
pub(super) fn point<'a, S: Scalar>(
    grid: &Grid<S>,
    states: &'a DMatrix<S>,
    e: usize,
    g: usize,
) -> Point<'a, S> {
    let n = states.nrows();
    let index = e * grid.points() + g;
    let state = &states.as_slice()[3 * g * n..(3 * g + 3) * n];
    Point {
        index,
        time: grid.times[index],
        q: &state[..n],
        v: &state[n..2 * n],
        a: &state[2 * n..],
    }
}
