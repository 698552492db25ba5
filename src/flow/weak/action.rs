//! The action of a curve and its derivatives in the coefficients.

use super::{LagrangianDerivatives, PointLagrangian, StateGrid, StatePoints};
use crate::error::{Result, check_length};
use crate::linalg::{BlockTridiagonal, multiply};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

/// The action $A(c) = \sum_g w_g L(t_g, x, \dot x)$ of the curve $x = \sum_m c_m \varphi_m$ on a [`StateGrid`], a
/// function of the coefficients, `2 N` by `count`.
///
/// $$ \frac{\partial A}{\partial c_m} = \sum_g w_g \left( \varphi_m L_x + \dot\varphi_m L_{\dot x} \right), $$
/// $$ \frac{\partial^2 A}{\partial c_m \partial c_n} = \sum_g w_g \left( \varphi_m \varphi_n L_{x x} + \varphi_m \dot\varphi_n L_{x \dot x} +
///    \dot\varphi_m \varphi_n L_{\dot x x} + \dot\varphi_m \dot\varphi_n L_{\dot x \dot x} \right), \qquad
///    M_{m n} = \sum_g w_g\\, \varphi_m \varphi_n\\, G . $$
///
/// As $\Omega = G^{-1} (\frac{d}{dt} L_{\dot x} - L_x)$, the flow tested with these functions in its own metric is
/// $M \dot c = -\nabla A$: it needs no derivative of the control, and the conditions between segments follow from the
/// action.
/// The sums over points are one product of matrices, $p^2 / 2$ by `4 M` times `4 M` by $4 N^2$ on each segment.
pub struct Action<'g, S: Scalar, L> {
    grid: &'g StateGrid<S>,
    /// The Lagrangian.
    pub lagrangian: L,
    size: usize,
    states: DMatrix<S>,
    values: Vec<S>,
    /// Allocated when derivatives or a metric are first requested.
    room: Option<Room<S>>,
}

/// Scratch space of derivatives and metrics.
struct Room<S: Scalar> {
    at_points: LagrangianDerivatives<S>,
    metrics: DMatrix<S>,
    sums: DMatrix<S>,
    gradient: DMatrix<S>,
}

/// The derivatives of an action in the unknown coefficients, function by function.
#[derive(Clone, Debug)]
pub struct ActionDerivatives<S: Scalar> {
    /// The gradient.
    pub gradient: DVector<S>,
    /// The Hessian.
    pub hessian: BlockTridiagonal<S>,
}

impl<S: Scalar> ActionDerivatives<S> {
    /// Zeros for the unknowns of a grid and a robot with `dof` joints.
    #[must_use]
    pub fn new(grid: &StateGrid<S>, dof: usize) -> Self {
        let sizes = (0..grid.segments).map(|e| grid.block(e).len() * 2 * dof);
        let sizes: Vec<_> = sizes.collect();
        Self {
            gradient: DVector::zeros(sizes.iter().sum()),
            hessian: BlockTridiagonal::new(&sizes, 2 * dof),
        }
    }
}

impl<'g, S: Scalar, L: PointLagrangian<S>> Action<'g, S, L> {
    /// The action of `lagrangian` on `grid` for a robot with `dof` joints.
    #[must_use]
    pub fn new(grid: &'g StateGrid<S>, lagrangian: L, dof: usize) -> Self {
        let points = grid.points();
        Self {
            grid,
            lagrangian,
            size: 2 * dof,
            states: DMatrix::zeros(4 * dof, points),
            values: vec![S::zero(); points],
            room: None,
        }
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &'g StateGrid<S> {
        self.grid
    }

    /// The number of joints `N`.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.size / 2
    }

    /// Computes $A$.
    ///
    /// # Errors
    /// `coefficients` is not `2 N` by the number of functions of the grid.
    pub fn value(&mut self, coefficients: &DMatrix<S>) -> Result<S> {
        let (grid, mut sum) = (self.grid, S::zero());
        for e in 0..grid.segments {
            self.place(coefficients, e)?;
            let here = points(grid, &self.states, e);
            self.lagrangian.values(here, &mut self.values)?;
            for (weight, value) in grid.weights.iter().zip(&self.values) {
                sum += *weight * *value;
            }
        }
        Ok(sum)
    }

    /// Computes $A$, and its derivatives into `out`.
    ///
    /// # Errors
    /// `coefficients` is not `2 N` by the number of functions of the grid.
    pub fn derivatives(
        &mut self,
        coefficients: &DMatrix<S>,
        out: &mut ActionDerivatives<S>,
    ) -> Result<S> {
        let (grid, mut sum) = (self.grid, S::zero());
        let (size, count) = (self.size, grid.points());
        out.gradient.fill(S::zero());
        for e in 0..grid.segments {
            self.place(coefficients, e)?;
            let here = points(grid, &self.states, e);
            let Room {
                at_points,
                sums,
                gradient,
                ..
            } = self.room.get_or_insert_with(|| Room::new(grid, size));
            at_points.convex = false;
            self.lagrangian.derivatives(here, at_points)?;
            for (g, weight) in grid.weights.iter().enumerate() {
                sum += *weight * at_points.values[g];
                for column in [g, count + g] {
                    let mut column = at_points.gradients.column_mut(column);
                    column *= *weight;
                }
            }
            multiply(&at_points.gradients, &grid.table.transpose(), gradient);
            let first = e * grid.degree();
            for (m, column) in gradient.column_iter().enumerate() {
                if grid.free().contains(&(first + m)) {
                    let mut own = out.gradient.rows_mut((first + m - 1) * size, size);
                    own += column;
                }
            }
            multiply(&at_points.hessians, grid.products(), sums);
            add_blocks(grid, sums, size, e, &mut out.hessian);
        }
        Ok(sum)
    }

    /// Computes the Gauss-Newton Hessian into `out`.
    ///
    /// # Errors
    /// `coefficients` is not `2 N` by the number of functions of the grid.
    pub fn gauss_newton(
        &mut self,
        coefficients: &DMatrix<S>,
        out: &mut BlockTridiagonal<S>,
    ) -> Result<()> {
        let (grid, size) = (self.grid, self.size);
        for e in 0..grid.segments {
            self.place(coefficients, e)?;
            let here = points(grid, &self.states, e);
            let room = self.room.get_or_insert_with(|| Room::new(grid, size));
            room.at_points.convex = true;
            self.lagrangian.derivatives(here, &mut room.at_points)?;
            multiply(&room.at_points.hessians, grid.products(), &mut room.sums);
            add_blocks(grid, &room.sums, size, e, out);
        }
        Ok(())
    }

    /// Computes the metric $M$ of the flow.
    ///
    /// # Errors
    /// `coefficients` is not `2 N` by the number of functions of the grid.
    pub fn metric(
        &mut self,
        coefficients: &DMatrix<S>,
        out: &mut BlockTridiagonal<S>,
    ) -> Result<()> {
        let (grid, size) = (self.grid, self.size);
        let products = grid.products().rows(0, grid.points()).into_owned();
        for e in 0..grid.segments {
            self.place(coefficients, e)?;
            let here = points(grid, &self.states, e);
            let room = self.room.get_or_insert_with(|| Room::new(grid, size));
            self.lagrangian.metrics(here, &mut room.metrics)?;
            multiply(&room.metrics, &products, &mut room.sums);
            add_blocks(grid, &room.sums, size, e, out);
        }
        Ok(())
    }

    /// Computes the Gram matrix of the velocities: the square of the norm is $\tfrac{T}{\pi^2} \int |\delta v|^2 dt$.
    #[must_use]
    pub fn gram(&self) -> BlockTridiagonal<S> {
        let (grid, n) = (self.grid, self.size / 2);
        let segments = S::from_f64(grid.segments as f64 / std::f64::consts::PI.powi(2));
        let scale = grid.weights.iter().fold(S::zero(), |sum, w| sum + *w) * segments;
        let values = grid.products().rows(0, grid.points());
        let mut gram = ActionDerivatives::new(grid, n).hessian;
        let mut sums = DMatrix::zeros(self.size * self.size, grid.pairs.len());
        for (pair, column) in values.column_iter().enumerate() {
            for i in n..self.size {
                sums[(i * self.size + i, pair)] = column.sum() * scale;
            }
        }
        for e in 0..grid.segments {
            add_blocks(grid, &sums, self.size, e, &mut gram);
        }
        gram
    }

    /// Evaluates the curve of segment `e` at its points.
    fn place(&mut self, coefficients: &DMatrix<S>, e: usize) -> Result<()> {
        check_length("coefficients", self.size, coefficients.nrows())?;
        check_length("coefficients", self.grid.count(), coefficients.ncols())?;
        let (grid, n, count) = (self.grid, self.size / 2, self.grid.points());
        let own = coefficients.columns(e * grid.degree(), grid.degree() + 1);
        let mut curve = DMatrix::zeros(self.size, 2 * count);
        multiply(&own.into_owned(), &grid.table, &mut curve);
        let (x, xdot) = curve.columns_range_pair(..count, count..);
        self.states.rows_mut(0, 2 * n).copy_from(&x);
        self.states.rows_mut(2 * n, n).copy_from(&xdot.rows(n, n));
        self.states.rows_mut(3 * n, n).copy_from(&xdot.rows(0, n));
        Ok(())
    }
}

impl<S: Scalar> Room<S> {
    fn new(grid: &StateGrid<S>, size: usize) -> Self {
        let points = grid.points();
        Self {
            at_points: LagrangianDerivatives::new(size / 2, points),
            metrics: DMatrix::zeros(size * size, points),
            sums: DMatrix::zeros(size * size, grid.pairs.len()),
            gradient: DMatrix::zeros(size, grid.degree() + 1),
        }
    }
}

/// The input of a Lagrangian at the points of segment `e`.
fn points<'a, S: Scalar>(
    grid: &'a StateGrid<S>,
    states: &'a DMatrix<S>,
    e: usize,
) -> StatePoints<'a, S> {
    let first = e * grid.points();
    StatePoints {
        first,
        times: &grid.times[first..first + grid.points()],
        states,
    }
}

/// Writes the blocks of the pairs of functions of segment `e`, one column each, added to the contribution of the
/// previous segment, which must have been written before.
fn add_blocks<S: Scalar>(
    grid: &StateGrid<S>,
    sums: &DMatrix<S>,
    size: usize,
    e: usize,
    out: &mut BlockTridiagonal<S>,
) {
    let (first, free) = (e * grid.degree(), grid.free());
    for (&(a, b), block) in grid.pairs.iter().zip(sums.column_iter()) {
        if !(free.contains(&(first + a)) && free.contains(&(first + b))) {
            continue;
        }
        let block = block.reshape_generic(nalgebra::Dyn(size), nalgebra::Dyn(size));
        // The first function of a segment is among the unknowns of the segment before.
        let place = |function: usize| (function - 1) * size;
        match (a, b) {
            (0, _) => {
                let before = &mut out.diagonal[e - 1];
                let tail = before.nrows() - size;
                let mut own = before.view_mut((tail, tail), (size, size));
                own += block;
            }
            (_, 0) => out.coupling[e - 1]
                .view_mut((place(a), 0), (size, size))
                .copy_from(&block),
            _ => out.diagonal[e]
                .view_mut((place(a), place(b)), (size, size))
                .copy_from(&block),
        }
    }
}
