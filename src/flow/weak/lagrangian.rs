//! A Lagrangian and the metric of its flow at quadrature points.

use crate::error::Result;
use crate::scalar::Scalar;
use nalgebra::DMatrix;

/// A curve at the points of a segment.
#[derive(Clone, Copy, Debug)]
pub struct StatePoints<'a, S: Scalar> {
    /// Index of the first point along time.
    pub first: usize,
    /// Times, s.
    pub times: &'a [S],
    /// $[q; v; \dot x_{P2}; \dot x_{P1}]$ at each point, one column each: `4 N` by `M`. The first three are the input
    /// of inverse dynamics.
    pub states: &'a DMatrix<S>,
}

impl<S: Scalar> StatePoints<'_, S> {
    /// The number of points, `M`.
    #[must_use]
    pub fn count(&self) -> usize {
        self.times.len()
    }

    /// The number of joints `N`.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.states.nrows() / 4
    }
}

/// A Lagrangian $L(t, x, \dot x)$ and its derivatives at the points of a segment.
#[derive(Clone, Debug)]
pub struct LagrangianDerivatives<S: Scalar> {
    /// The values of $L$, `M` entries.
    pub values: Vec<S>,
    /// $\partial L / \partial x$ of each point, one column each, then $\partial L / \partial \dot x$: `2 N` by `2 M`.
    pub gradients: DMatrix<S>,
    /// Second derivatives, one column per block of `2 N` by `2 N` in column-major order: those in $x\\, x$ of each
    /// point, then those in $x\\, \dot x$, $\dot x\\, x$ and $\dot x\\, \dot x$; $4 N^2$ by `4 M`.
    pub hessians: DMatrix<S>,
    /// True for the Gauss-Newton second derivatives, without the terms that make them indefinite.
    pub convex: bool,
}

impl<S: Scalar> LagrangianDerivatives<S> {
    /// Zeros for `points` points of a model with `n` joints.
    #[must_use]
    pub fn new(n: usize, points: usize) -> Self {
        Self {
            values: vec![S::zero(); points],
            gradients: DMatrix::zeros(2 * n, 2 * points),
            hessians: DMatrix::zeros(4 * n * n, 4 * points),
            convex: false,
        }
    }

    /// The second derivatives of one kind at point `g`, `2 N` by `2 N` in column-major order: 0 for those in $x\\, x$,
    /// 1 in $x\\, \dot x$, 2 in $\dot x\\, x$, 3 in $\dot x\\, \dot x$.
    pub fn block_mut(&mut self, g: usize, kind: usize) -> &mut [S] {
        let column = kind * self.values.len() + g;
        self.hessians.column_mut(column).data.into_slice_mut()
    }

    /// Adds `value` to the second derivative in the entries `row` and `column` of $[x; \dot x]$ at point `g`.
    /// Off-diagonal entries must be added at both of their places.
    pub fn add(&mut self, g: usize, row: usize, column: usize, value: S) {
        let (points, size) = (self.values.len(), self.gradients.nrows());
        let kind = 2 * (row / size) + column / size;
        self.hessians[(column % size * size + row % size, kind * points + g)] += value;
    }
}

/// A Lagrangian with the metric of its flow at quadrature points: the integrand of the weak form.
///
/// [`AnalyticLagrangian`](super::AnalyticLagrangian) implements it analytically for inverse dynamics;
/// [`DualLagrangian`](super::DualLagrangian) for any [`Lagrangian`](crate::flow::Lagrangian), differentiated by dual
/// numbers.
pub trait PointLagrangian<S: Scalar> {
    /// Computes $L$ at all points into `values`, `M` entries.
    ///
    /// # Errors
    /// `at` has the wrong number of rows.
    fn values(&mut self, at: StatePoints<'_, S>, values: &mut [S]) -> Result<()>;

    /// Computes $L$ and its derivatives into `out`, which is overwritten.
    ///
    /// # Errors
    /// Those of [`values`](Self::values).
    fn derivatives(
        &mut self,
        at: StatePoints<'_, S>,
        out: &mut LagrangianDerivatives<S>,
    ) -> Result<()>;

    /// Computes the metric $G(t, x)$ into `out`, one column per point, `2 N` by `2 N` in column-major order.
    ///
    /// # Errors
    /// Those of [`values`](Self::values).
    fn metrics(&mut self, at: StatePoints<'_, S>, out: &mut DMatrix<S>) -> Result<()>;
}
