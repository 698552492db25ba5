//! A running cost along a curve in the state, with the slip between its velocity and the rate of its configuration.

use crate::cost::Point;
use crate::cost::{PointCost, PointDerivatives, Points, PointsDerivatives, alone};
use crate::error::{Result, check_length};
use crate::scalar::Scalar;
use nalgebra::DMatrix;

/// The Lagrangian of a running cost $l(q, v, a)$, a cost of $(x, \dot x)$ with $x = [q; v]$:
///
/// $$ L = l(x_{P1}, x_{P2}, \dot x_{P2}) + k\\, |e|^2 + \lambda^T e, \qquad e = \dot x_{P1} - x_{P2} . $$
///
/// With $l = |u|^2$ and $\lambda = 0$ it is the paper's. Its derivatives are
///
/// $$ L_x = \begin{bmatrix} l_q \\\\ l_v - 2 k e - \lambda \end{bmatrix}, \qquad
///    L_{\dot x} = \begin{bmatrix} 2 k e + \lambda \\\\ l_a \end{bmatrix}, $$
///
/// and the second ones those of `l`, and $\pm 2 k I$ for the terms in `e`. It has no metric of its own; see
/// [`Norm`](super::Norm).
#[derive(Clone, Debug)]
pub struct WithSlip<P, S: Scalar = f64> {
    /// The running cost `l`.
    pub cost: P,
    /// The penalty `k`.
    pub k: S,
    /// The multipliers $\lambda$ at all points, `N` by their number; zero if there are no columns.
    pub multipliers: DMatrix<S>,
    /// The slips `e` at all points at the last evaluation, `N` by their number.
    slips: DMatrix<S>,
    /// $[q, v, a]$ at the points of a segment, and the derivatives of `l` there.
    states: DMatrix<S>,
    derivatives: PointsDerivatives<S>,
}

impl<P, S: Scalar> WithSlip<P, S> {
    /// The Lagrangian of `cost` at `points` points along time, for a robot with `dof` joints.
    #[must_use]
    pub fn new(cost: P, k: S, dof: usize, points: usize) -> Self {
        Self {
            cost,
            k,
            multipliers: DMatrix::zeros(dof, 0),
            slips: DMatrix::zeros(dof, points),
            states: DMatrix::zeros(dof, 0),
            derivatives: PointsDerivatives::new(dof, 0),
        }
    }

    /// The slips $e$ at all points at the last evaluation, `N` by their number.
    #[must_use]
    pub fn slips(&self) -> &DMatrix<S> {
        &self.slips
    }

    /// Splits the states into $[q, v, a]$ and the slips.
    fn place(&mut self, points: Points<'_, S>) -> Result<()> {
        let (n, count) = (self.slips.nrows(), points.count());
        check_length("states", 2 * n, points.states.nrows())?;
        if self.states.ncols() != 3 * count {
            self.states = DMatrix::zeros(n, 3 * count);
            self.derivatives = PointsDerivatives::new(n, count);
            self.derivatives.with_metrics = false;
        }
        for g in 0..count {
            let [x, rate] = [0, 1].map(|d| points.states.column(3 * g + d));
            let parts = [x.rows(0, n), x.rows(n, n), rate.rows(n, n)];
            for (d, part) in parts.into_iter().enumerate() {
                self.states.set_column(3 * g + d, &part);
            }
            let slip = rate.rows(0, n) - x.rows(n, n);
            self.slips.set_column(points.first + g, &slip);
        }
        Ok(())
    }

    /// The terms of the slip at a point along time.
    fn slip_terms(&self, index: usize) -> S {
        let (slip, mut sum) = (self.slips.column(index), S::zero());
        for (i, e) in slip.iter().enumerate() {
            sum += self.k * *e * *e;
            if self.multipliers.ncols() > 0 {
                sum += self.multipliers[(i, index)] * *e;
            }
        }
        sum
    }
}

impl<P: PointCost<S>, S: Scalar> PointCost<S> for WithSlip<P, S> {
    fn value(&mut self, point: Point<'_, S>) -> Result<S> {
        let (states, mut cost) = (point.states(), [S::zero()]);
        self.values(point.points(&states), &mut cost)?;
        Ok(cost[0])
    }

    fn derivatives(&mut self, point: Point<'_, S>, out: &mut PointDerivatives<S>) -> Result<S> {
        alone(point, out, |points, all| self.all_derivatives(points, all))
    }

    fn values(&mut self, points: Points<'_, S>, costs: &mut [S]) -> Result<()> {
        self.place(points)?;
        let own = Points { states: &self.states, ..points };
        self.cost.values(own, costs)?;
        for (g, cost) in costs.iter_mut().enumerate() {
            *cost += self.slip_terms(points.first + g);
        }
        Ok(())
    }

    fn all_derivatives(&mut self, points: Points<'_, S>, out: &mut PointsDerivatives<S>) -> Result<()> {
        self.place(points)?;
        let own = Points { states: &self.states, ..points };
        self.cost.all_derivatives(own, &mut self.derivatives)?;
        let n = self.states.nrows();
        let stiff = self.k + self.k;
        out.gradients.fill(S::zero());
        for g in 0..points.count() {
            let index = points.first + g;
            out.costs[g] = self.derivatives.costs[g] + self.slip_terms(index);
            let mut by_slip = self.slips.column(index) * stiff;
            if self.multipliers.ncols() > 0 {
                by_slip += self.multipliers.column(index);
            }
            // The places of q, v and a among x and its rate.
            for (x, (place, d)) in [(0, 0), (n, 0), (n, 1)].into_iter().enumerate() {
                let from = self.derivatives.gradients.column(3 * g + x);
                out.gradients.view_mut((place, 3 * g + d), (n, 1)).copy_from(&from);
            }
            let mut by_v = out.gradients.view_mut((n, 3 * g), (n, 1));
            by_v -= &by_slip;
            out.gradients.view_mut((0, 3 * g + 1), (n, 1)).copy_from(&by_slip);
        }
        self.derivatives.hessians.in_states(stiff, &mut out.hessians);
        Ok(())
    }
}
