//! The integrand along a curve.

use super::PackedHessian;
use crate::constraint::StageInput;
use crate::error::Result;
use crate::scalar::{Lanes, Scalar, Wide};
use nalgebra::{DMatrix, DVector};

/// A curve at one quadrature point.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a, S> {
    /// Index of the point along time.
    pub index: usize,
    /// The phase of the motion.
    pub phase: usize,
    /// Time, s.
    pub time: S,
    /// Configuration, `N` entries.
    pub q: &'a [S],
    /// Velocity, `N` entries.
    pub v: &'a [S],
    /// Acceleration, `N` entries.
    pub a: &'a [S],
}

impl<'a, S: Scalar> Point<'a, S> {
    /// This point with its control.
    pub(crate) fn with_control(self, u: &'a [S]) -> StageInput<'a, S> {
        let Self { time, q, v, a, .. } = self;
        StageInput { t: time, q, v, a, u }
    }

    /// $[q, v, a]$, `N` by 3.
    pub(crate) fn states(&self) -> DMatrix<S> {
        DMatrix::from_fn(self.q.len(), 3, |i, x| [self.q, self.v, self.a][x][i])
    }

    /// This point as a batch of one. `states` is [`Self::states`].
    pub(crate) fn points<'b>(&'b self, states: &'b DMatrix<S>) -> Points<'b, S> {
        Points { first: self.index, phase: self.phase, times: std::slice::from_ref(&self.time), states, higher: &[] }
    }
}

/// A curve at all quadrature points of a segment.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a, S: Scalar> {
    /// Index of the first point along time.
    pub first: usize,
    /// The phase of the motion; zero in a motion without phases.
    pub phase: usize,
    /// Times, s.
    pub times: &'a [S],
    /// $q, v, a$ at each point, one column each: `N` by `3 M`.
    pub states: &'a DMatrix<S>,
    /// The derivatives of higher orders, from three to that of the [cost](PointCost::order), each `N` by `M`.
    pub higher: &'a [DMatrix<S>],
}

impl<'a, S: Scalar> Points<'a, S> {
    /// The number of points, `M`.
    #[must_use]
    pub fn count(&self) -> usize {
        self.times.len()
    }

    /// Point `g` of the segment.
    #[must_use]
    pub fn point(&self, g: usize) -> Point<'a, S> {
        let n = self.states.nrows();
        let state = &self.states.as_slice()[3 * g * n..(3 * g + 3) * n];
        Point {
            index: self.first + g,
            phase: self.phase,
            time: self.times[g],
            q: &state[..n],
            v: &state[n..2 * n],
            a: &state[2 * n..],
        }
    }
}

impl<S: Scalar> Points<'_, S> {
    /// Copies $[q; v; a]$ of the points from `start` on into lanes, and the last point into unused lanes; returns the
    /// number of used lanes.
    pub(crate) fn gather(&self, start: usize, state: &mut [Wide<S>]) -> usize {
        Lanes::gather(self.states.as_slice(), start, state)
    }
}

/// The derivatives of a running cost in $z = [q; v; a]$.
#[derive(Clone, Debug)]
pub struct PointDerivatives<S: Scalar> {
    /// $\partial l / \partial z$, `3 N` entries.
    pub gradient: DVector<S>,
    /// $\partial^2 l / \partial z^2$, `3 N` by `3 N`.
    pub hessian: DMatrix<S>,
    /// A positive semidefinite approximation of the Hessian (Gauss-Newton), by which the steps of the minimiser are
    /// damped.
    pub metric: DMatrix<S>,
}

impl<S: Scalar> PointDerivatives<S> {
    /// Zeros for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            gradient: DVector::zeros(3 * n),
            hessian: DMatrix::zeros(3 * n, 3 * n),
            metric: DMatrix::zeros(3 * n, 3 * n),
        }
    }
}

/// A running cost and its derivatives at all points of a segment.
#[derive(Clone, Debug)]
pub struct PointsDerivatives<S: Scalar> {
    /// The costs, `M` entries.
    pub costs: Vec<S>,
    /// $\partial l / \partial q$, $\partial l / \partial v$ and $\partial l / \partial a$ at each point, one column
    /// each: `N` by `3 M`.
    pub gradients: DMatrix<S>,
    /// The Hessians.
    pub hessians: PackedHessian<S>,
    /// The metrics; see [`PointDerivatives::metric`].
    pub metrics: PackedHessian<S>,
    /// True if the metrics are needed.
    pub with_metrics: bool,
    /// The first derivatives in those of each [higher order](Points::higher) at each point and the second ones, those
    /// of different joints being zero: `N` by `M`.
    pub higher: Vec<[DMatrix<S>; 2]>,
}

impl<S: Scalar> PointsDerivatives<S> {
    /// Zeros for `points` points of a model with `n` joints.
    #[must_use]
    pub fn new(n: usize, points: usize) -> Self {
        let hessians = PackedHessian::new(n, points);
        Self {
            costs: vec![S::zero(); points],
            gradients: DMatrix::zeros(n, 3 * points),
            metrics: hessians.clone(),
            hessians,
            with_metrics: true,
            higher: Vec::new(),
        }
    }

    /// Sets the derivatives in those of this many higher orders to zero, `n` by `points`.
    pub(crate) fn clear_higher(&mut self, orders: usize, n: usize, points: usize) {
        self.higher.resize_with(orders, || [DMatrix::zeros(n, points), DMatrix::zeros(n, points)]);
        for of in self.higher.iter_mut().flatten() {
            if of.shape() == (n, points) { of.fill(S::zero()) } else { *of = DMatrix::zeros(n, points) }
        }
    }

    /// Stores the results of point `g`.
    pub fn set(&mut self, g: usize, cost: S, of: &PointDerivatives<S>) {
        let n = self.gradients.nrows();
        self.costs[g] = cost;
        for x in 0..3 {
            let part = of.gradient.rows(x * n, n);
            self.gradients.set_column(3 * g + x, &part);
        }
        self.hessians.set(g, &of.hessian);
        if self.with_metrics {
            self.metrics.set(g, &of.metric);
        }
    }
}

/// A running cost $l(q, v, a)$ at the points of a quadrature.
///
/// Only the functions of one point are required; a cost that is faster for many points at once overrides the others.
pub trait PointCost<S: Scalar> {
    /// Computes $l$.
    ///
    /// # Errors
    /// `q`, `v` or `a` of `point` does not have `N` entries.
    fn value(&mut self, point: Point<'_, S>) -> Result<S>;

    /// Computes $l$, and overwrites all of `out`.
    ///
    /// # Errors
    /// `q`, `v` or `a` of `point` does not have `N` entries, or `out` was made for another number of joints.
    fn derivatives(&mut self, point: Point<'_, S>, out: &mut PointDerivatives<S>) -> Result<S>;

    /// Computes the partial derivative $\partial l / \partial t$; zero unless `l` depends explicitly on time.
    ///
    /// # Errors
    /// `q`, `v` or `a` of `point` does not have `N` entries.
    fn time_rate(&mut self, point: Point<'_, S>) -> Result<S> {
        let _ = point;
        Ok(S::zero())
    }

    /// The highest order of a derivative on which $l$ depends, at least two, as by default, and at most
    /// [`MAX_ORDER`](crate::constraint::MAX_ORDER).
    fn order(&self) -> usize {
        2
    }

    /// The number of phases of a motion, each of which has as many segments. One by default.
    fn phases(&self) -> usize {
        1
    }

    /// Computes $l$ at all points into `costs`, `M` entries.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    fn values(&mut self, points: Points<'_, S>, costs: &mut [S]) -> Result<()> {
        for (g, cost) in costs.iter_mut().enumerate() {
            *cost = self.value(points.point(g))?;
        }
        Ok(())
    }

    /// Computes all of `out`, except metrics that are not needed.
    ///
    /// # Errors
    /// Those of [`derivatives`](Self::derivatives).
    fn all_derivatives(&mut self, points: Points<'_, S>, out: &mut PointsDerivatives<S>) -> Result<()> {
        let mut single = PointDerivatives::new(points.states.nrows());
        for g in 0..points.count() {
            let cost = self.derivatives(points.point(g), &mut single)?;
            out.set(g, cost, &single);
        }
        Ok(())
    }
}

impl<S: Scalar, P: PointCost<S>> PointCost<S> for &mut P {
    fn value(&mut self, point: Point<'_, S>) -> Result<S> {
        (**self).value(point)
    }

    fn derivatives(&mut self, point: Point<'_, S>, out: &mut PointDerivatives<S>) -> Result<S> {
        (**self).derivatives(point, out)
    }

    fn time_rate(&mut self, point: Point<'_, S>) -> Result<S> {
        (**self).time_rate(point)
    }

    fn order(&self) -> usize {
        (**self).order()
    }

    fn phases(&self) -> usize {
        (**self).phases()
    }

    fn values(&mut self, points: Points<'_, S>, costs: &mut [S]) -> Result<()> {
        (**self).values(points, costs)
    }

    fn all_derivatives(&mut self, points: Points<'_, S>, out: &mut PointsDerivatives<S>) -> Result<()> {
        (**self).all_derivatives(points, out)
    }
}

/// A running cost that computes the control, so that limits of the control can be constraints.
pub trait CostWithControl: PointCost<f64> + Clone + Send + Sync {
    /// Computes the costs at all points, and the controls into the columns of `controls`, `N` by `M`.
    ///
    /// # Errors
    /// The states do not have `N` rows.
    fn values_with_control(
        &mut self,
        points: Points<'_, f64>,
        costs: &mut [f64],
        controls: &mut DMatrix<f64>,
    ) -> Result<()>;

    /// Computes the costs, and into all of `out`, except metrics that are not needed, the derivatives of the cost plus
    /// a `term` in the control alone; costs and metrics are without the term.
    ///
    /// # Errors
    /// The states do not have `N` rows, or `out` was made for another number of joints.
    fn all_derivatives_with(
        &mut self,
        points: Points<'_, f64>,
        out: &mut PointsDerivatives<f64>,
        term: &mut impl ControlTerm<f64>,
    ) -> Result<()>;
}

/// The derivatives of a term in the control alone at a point.
#[derive(Clone, Debug)]
pub struct ControlDerivatives<S> {
    /// The gradient in `u`, `N` entries.
    pub gradient: Vec<S>,
    /// The weights of the second derivatives of $u$ in the motion: at a primal-dual iterate these are the multipliers,
    /// not the gradient.
    pub curvature_weights: Vec<S>,
    /// The diagonal of the Hessian in `u`, whose other entries are zero.
    pub hessian: Vec<S>,
}

impl<S: Scalar> ControlDerivatives<S> {
    /// Zeros for `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zeros = vec![S::zero(); n];
        Self { gradient: zeros.clone(), curvature_weights: zeros.clone(), hessian: zeros }
    }

    /// Sets all entries to zero.
    pub fn clear(&mut self) {
        for part in [&mut self.gradient, &mut self.curvature_weights, &mut self.hessian] {
            part.fill(S::zero());
        }
    }
}

/// A term in the control: a function of the index of a point and `u` that adds its derivatives to zeros. It returns
/// true if its Hessian is not zero.
pub trait ControlTerm<S>: FnMut(usize, &[S], &mut ControlDerivatives<S>) -> bool {}
impl<S, F: FnMut(usize, &[S], &mut ControlDerivatives<S>) -> bool> ControlTerm<S> for F {}
