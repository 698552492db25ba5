//! A Lagrangian and the metric of its flow at the points of a quadrature.

use crate::error::Result;
use crate::scalar::Scalar;
use nalgebra::DMatrix;

/// A curve at the points of a segment.
#[derive(Clone, Copy, Debug)]
pub struct StatePoints<'a, S: Scalar> {
    /// Which point the first is, counted along time.
    pub first: usize,
    /// Times, s.
    pub times: &'a [S],
    /// $[q; v; \dot x_{P2}; \dot x_{P1}]$ at each point, a column each: `4 N` by `M`. The first three are what inverse dynamics reads.
    pub states: &'a DMatrix<S>,
}

impl<S: Scalar> StatePoints<'_, S> {
    /// The number of points, `M`.
    #[must_use]
    pub fn count(&self) -> usize {
        self.times.len()
    }

    /// `N`.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.states.nrows() / 4
    }
}

/// A Lagrangian $L(t, x, \dot x)$ and its derivatives at the points of a segment.
#[derive(Clone, Debug)]
pub struct LagrangianDerivatives<S: Scalar> {
    /// $L$, `M` entries.
    pub values: Vec<S>,
    /// $\partial L / \partial x$ of each point, a column each, then $\partial L / \partial \dot x$: `2 N` by `2 M`.
    pub gradients: DMatrix<S>,
    /// Second derivatives, a column a block of `2 N` by `2 N` column by column: those in $x\\, x$ of each point, then those in
    /// $x\\, \dot x$, $\dot x\\, x$ and $\dot x\\, \dot x$; $4 N^2$ by `4 M`.
    pub hessians: DMatrix<S>,
    /// True if second derivatives are to be those of Gauss and Newton: what makes them indefinite is left out.
    pub convex: bool,
}

impl<S: Scalar> LagrangianDerivatives<S> {
    /// Room for `points` points of a model with `n` joints.
    #[must_use]
    pub fn new(n: usize, points: usize) -> Self {
        Self {
            values: vec![S::zero(); points],
            gradients: DMatrix::zeros(2 * n, 2 * points),
            hessians: DMatrix::zeros(4 * n * n, 4 * points),
            convex: false,
        }
    }

    /// The second derivatives of one kind at point `g`, `2 N` by `2 N` column by column: 0 for those in $x\\, x$, 1 in $x\\, \dot x$, 2 in
    /// $\dot x\\, x$, 3 in $\dot x\\, \dot x$.
    pub fn block_mut(&mut self, g: usize, kind: usize) -> &mut [S] {
        let column = kind * self.values.len() + g;
        self.hessians.column_mut(column).data.into_slice_mut()
    }

    /// Adds `value` to the second derivative in the entries `row` and `column` of $[x; \dot x]$ at point `g`. Entries that are not on the
    /// diagonal come once for each of their two places.
    pub fn add(&mut self, g: usize, row: usize, column: usize, value: S) {
        let (points, size) = (self.values.len(), self.gradients.nrows());
        let kind = 2 * (row / size) + column / size;
        self.hessians[(column % size * size + row % size, kind * points + g)] += value;
    }
}

/// A Lagrangian with the metric in which its flow goes down, at the points of a quadrature: what the weak form of the flow integrates.
///
/// [`AnalyticLagrangian`](super::AnalyticLagrangian) has the analytic one of inverse dynamics; [`DualLagrangian`](super::DualLagrangian) has any
/// [`Lagrangian`](crate::flow::Lagrangian), differentiated by dual numbers.
pub trait PointLagrangian<S: Scalar> {
    /// $L$ at all points into `values`, `M` entries.
    ///
    /// # Errors
    /// The points are those of another robot.
    fn values(&mut self, at: StatePoints<'_, S>, values: &mut [S]) -> Result<()>;

    /// $L$ and its derivatives into `out`, which may hold anything.
    ///
    /// # Errors
    /// As [`values`](Self::values).
    fn derivatives(
        &mut self,
        at: StatePoints<'_, S>,
        out: &mut LagrangianDerivatives<S>,
    ) -> Result<()>;

    /// The metric $G(t, x)$ into `out`, a column a point, `2 N` by `2 N` column by column.
    ///
    /// # Errors
    /// As [`values`](Self::values).
    fn metrics(&mut self, at: StatePoints<'_, S>, out: &mut DMatrix<S>) -> Result<()>;
}
