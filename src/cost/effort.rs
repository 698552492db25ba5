//! The control effort as a running cost.

use super::{
    ControlDerivatives, ControlTerm, CostWithControl, Point, PointCost, PointDerivatives, Points, PointsDerivatives,
    WeightedSquares,
};
use crate::constraint::MAX_ORDER;
use crate::dynamics::{Data, InverseDynamicsDerivatives, RneaWeightedHessian, rnea, rnea_second_order};
use crate::error::{Result, check_count, check_length};
use crate::linalg::{ROWS, weighted_gram};
use crate::model::Model;
use crate::scalar::{AlgebraOver, LANES, Scalar, Wide};
use nalgebra::{DMatrix, DVector};

/// The control effort $l = |u|^2$ with $u = ID(q, v, a)$, by analytic derivatives:
///
/// $$ \frac{\partial l}{\partial z} = 2 J^T u, \qquad \frac{\partial^2 l}{\partial z^2} = 2 J^T J + \Phi(2 u), \qquad
///    J = \left[ \frac{\partial ID}{\partial q}\ \frac{\partial ID}{\partial v}\ H \right], $$
///
/// where $\Phi(w)$ is the Hessian of $w^T ID$. The metric is $2 J^T J$. Four points at a time go through the dynamics
/// side by side.
#[derive(Clone, Debug)]
pub struct ControlEffort<'m, C: Scalar = f64, S: Scalar = C> {
    model: &'m Model<C>,
    data: Data<Wide<S>>,
    id: InverseDynamicsDerivatives<Wide<S>>,
    second: RneaWeightedHessian<Wide<S>>,
    /// $[q; v; a]$.
    state: Vec<Wide<S>>,
    /// Half the second derivatives in `u`, `v` and `a`.
    squares_of: [DVector<Wide<S>>; 3],
    /// True unless those in `v` and `a` are all zero.
    with_motion: bool,
    /// The weights of the squares of the derivatives of each higher order, from three on.
    higher: Vec<Vec<S>>,
    /// $\partial l / \partial u$, that is $w$ of the gradient.
    slopes: DVector<Wide<S>>,
    /// $w$ of $\Phi(w)$.
    weights: DVector<Wide<S>>,
    /// The second derivatives of another term in `u`.
    stiffness: DVector<Wide<S>>,
    /// $2 J^T J$, and with the stiffness instead of 2; lower halves.
    squares: DMatrix<Wide<S>>,
    stiff: DMatrix<Wide<S>>,
    /// The weights of these products, and columns of $J$ with their weights.
    doubled: DVector<Wide<S>>,
    scaled: [Vec<Wide<S>>; ROWS],
    /// The control at one point.
    u: DVector<S>,
    by_term: ControlDerivatives<S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C>> ControlEffort<'m, C, S> {
    /// The control effort $|u|^2$ of `model`.
    #[must_use]
    pub fn new(model: &'m Model<C>) -> Self {
        let n = model.dof();
        let zero = DVector::from_element(n, Wide::splat(S::zero()));
        Self {
            model,
            with_motion: false,
            higher: Vec::new(),
            slopes: zero.clone(),
            data: Data::new(model),
            id: InverseDynamicsDerivatives::new(n),
            second: RneaWeightedHessian::new(n),
            state: vec![Wide::splat(S::zero()); 3 * n],
            weights: zero.clone(),
            stiffness: zero.clone(),
            squares: DMatrix::zeros(3 * n, 3 * n),
            stiff: DMatrix::zeros(3 * n, 3 * n),
            doubled: zero.clone(),
            squares_of: [zero.map(|_| Wide::splat(S::one())), zero.clone(), zero],
            scaled: Default::default(),
            u: DVector::zeros(n),
            by_term: ControlDerivatives::new(n),
        }
    }

    /// Weighted squares of `u`, `v` and `a` in place of $|u|^2$: with their doubled weights as diagonal matrices `W`,
    ///
    /// $$ \frac{\partial l}{\partial z} = J^T W_u u + W_{va} z, \qquad
    ///    \frac{\partial^2 l}{\partial z^2} = J^T W_u J + W_{va} + \Phi(W_u u) . $$
    ///
    /// # Errors
    /// The number of weights is not the number of joints.
    pub fn weighted(model: &'m Model<C>, weights: &WeightedSquares) -> Result<Self> {
        let all = [weights.torque(), weights.velocity(), weights.acceleration()];
        let all = all.map(|w| DVector::from_iterator(w.len(), w.iter().map(|w| S::from_f64(*w))));
        Self::with_weights(model, &all)
    }

    /// Computes [`weighted`](Self::weighted) for the weights of `u`, `v` and `a` in any scalar.
    ///
    /// # Errors
    /// The number of weights is not the number of joints.
    pub(crate) fn with_weights(model: &'m Model<C>, weights: &[DVector<S>; 3]) -> Result<Self> {
        let mut effort = Self::new(model);
        for (to, from) in effort.squares_of.iter_mut().zip(weights) {
            check_length("weights", model.dof(), from.len())?;
            *to = from.map(Wide::splat);
        }
        effort.with_motion = weights[1..].iter().any(|w| w.iter().any(|w| !w.is_zero()));
        Ok(effort)
    }

    /// Adds weighted squares of the derivatives of higher orders, from the jerk on, at most up to [`MAX_ORDER`], with
    /// one weight per joint each.
    ///
    /// # Errors
    /// The number of weights of an order is not the number of joints, or there are more orders.
    pub fn with_higher(mut self, weights: &[&[S]]) -> Result<Self> {
        check_count("orders of the cost", 2 + weights.len(), 2..=MAX_ORDER)?;
        for weights in weights {
            check_length("weights", self.model.dof(), weights.len())?;
        }
        let is_used = |weights: &&[S]| weights.iter().any(|w| !w.is_zero());
        let used = weights.iter().rposition(is_used).map_or(0, |last| last + 1);
        self.higher = weights[..used].iter().map(|weights| weights.to_vec()).collect();
        Ok(self)
    }

    /// Adds the costs of the derivatives of higher orders at all points.
    fn add_higher(&self, points: Points<'_, S>, costs: &mut [S]) {
        for (weights, rates) in self.higher.iter().zip(points.higher) {
            for (cost, rates) in costs.iter_mut().zip(rates.column_iter()) {
                for (w, x) in weights.iter().zip(&rates) {
                    *cost += *w * *x * *x;
                }
            }
        }
    }

    /// Adds the derivatives of these costs at all points.
    fn add_higher_derivatives(&self, points: Points<'_, S>, out: &mut PointsDerivatives<S>) {
        let two = S::from_f64(2.0);
        for ((weights, rates), [slopes, curvatures]) in self.higher.iter().zip(points.higher).zip(&mut out.higher) {
            for (g, rates) in rates.column_iter().enumerate() {
                for (i, (w, x)) in weights.iter().zip(&rates).enumerate() {
                    slopes[(i, g)] += two * *w * *x;
                    curvatures[(i, g)] += two * *w;
                }
            }
        }
    }

    /// The cost of four points side by side.
    fn cost_of(&self, tau: &DVector<Wide<S>>) -> Wide<S> {
        let n = tau.len();
        let [torque, velocity, acceleration] = &self.squares_of;
        let mut cost = Wide::splat(S::zero());
        for (w, u) in torque.iter().zip(tau) {
            cost += *w * *u * *u;
        }
        if self.with_motion {
            let moving = velocity.iter().chain(acceleration);
            for (w, x) in moving.zip(&self.state[n..]) {
                cost += *w * *x * *x;
            }
        }
        cost
    }

    /// The derivatives of the effort plus another term in the control. The metrics and the costs are those of the
    /// effort.
    fn with_term(
        &mut self,
        points: Points<'_, S>,
        out: &mut PointsDerivatives<S>,
        term: &mut impl ControlTerm<S>,
    ) -> Result<()> {
        let n = self.model.dof();
        check_length("states", n, points.states.nrows())?;
        let two = Wide::from_f64(2.0);
        for start in (0..points.count()).step_by(LANES) {
            let count = points.gather(start, &mut self.state);
            self.stiffness.fill(Wide::splat(S::zero()));
            let (u, by_term) = (&mut self.u, &mut self.by_term);
            let (slopes, weights, stiffness) = (&mut self.slopes, &mut self.weights, &mut self.stiffness);
            let torque = &self.squares_of[0];
            let mut stiff = false;
            let weigh = |tau: &DVector<Wide<S>>, w: &mut [Wide<S>]| {
                slopes.zip_zip_apply(torque, tau, |to, w, tau| *to = two * w * tau);
                weights.copy_from(slopes);
                for lane in 0..count {
                    u.zip_apply(tau, |u, tau| *u = tau.0[lane]);
                    by_term.clear();
                    stiff |= term(points.first + start + lane, u.as_slice(), by_term);
                    for i in 0..n {
                        slopes[i].0[lane] += by_term.gradient[i];
                        weights[i].0[lane] += by_term.curvature_weights[i];
                        stiffness[i].0[lane] = by_term.hessian[i];
                    }
                }
                w.copy_from_slice(weights.as_slice());
            };
            let z = split(&self.state);
            let (id, second) = (&mut self.id, &mut self.second);
            rnea_second_order(self.model, &mut self.data, z, weigh, id, second)?;
            self.file(start, count, stiff, out);
        }
        self.add_higher(points, &mut out.costs);
        self.add_higher_derivatives(points, out);
        Ok(())
    }

    /// Stores the contents of the lanes for `count` points from `start` on.
    fn file(&mut self, start: usize, count: usize, stiff: bool, out: &mut PointsDerivatives<S>) {
        let n = self.model.dof();
        let two = Wide::from_f64(2.0);
        let cost = self.cost_of(&self.id.tau);
        out.costs[start..start + count].copy_from_slice(&cost.0[..count]);
        let InverseDynamicsDerivatives { dq, dv, h, .. } = &self.id;
        let RneaWeightedHessian { qq, qv, vv, qa } = &self.second;
        let jacobian = [dq, dv, h];
        for (x, block) in jacobian.into_iter().enumerate() {
            for (i, column) in block.column_iter().enumerate() {
                let mut slope = column.dot(&self.slopes);
                if self.with_motion && x > 0 {
                    slope += two * self.squares_of[x][i] * self.state[x * n + i];
                }
                for lane in 0..count {
                    out.gradients[(i, 3 * (start + lane) + x)] = slope.0[lane];
                }
            }
        }
        let column = |c: usize| &jacobian[c / n].as_slice()[c % n * n..(c % n + 1) * n];
        self.doubled.zip_apply(&self.squares_of[0], |to, w| *to = w * two);
        weighted_gram(column, &self.doubled, &mut self.scaled, &mut self.squares);
        if self.with_motion {
            for x in 1..3 {
                for i in 0..n {
                    self.squares[(x * n + i, x * n + i)] += two * self.squares_of[x][i];
                }
            }
        }
        if stiff {
            weighted_gram(column, &self.stiffness, &mut self.scaled, &mut self.stiff);
        }
        for (x, y, phi) in
            [(0, 0, Some(qq)), (0, 1, Some(qv)), (0, 2, Some(qa)), (1, 1, Some(vv)), (1, 2, None), (2, 2, None)]
        {
            let squares = |i: usize, j: usize| {
                let (row, column) = (x * n + i, y * n + j);
                (row.max(column), row.min(column))
            };
            let metric = |i, j| self.squares[squares(i, j)];
            let stiffness = |i, j| self.stiff[squares(i, j)];
            let hessians = &mut out.hessians;
            match (phi, stiff) {
                (None, false) => hessians.put([x, y], start, metric),
                (Some(phi), false) => {
                    let entry = |i, j| metric(i, j) + phi[(i, j)];
                    hessians.put([x, y], start, entry);
                }
                (phi, true) => {
                    let zero = Wide::splat(S::zero());
                    let entry = |i, j| {
                        let phi = phi.map_or(zero, |phi| phi[(i, j)]);
                        metric(i, j) + stiffness(i, j) + phi
                    };
                    hessians.put([x, y], start, entry);
                }
            }
            if out.with_metrics {
                out.metrics.put([x, y], start, metric);
            }
        }
    }

    /// The costs and, if requested, the controls at all points, `N` by `M`.
    fn values_and_controls(
        &mut self,
        points: Points<'_, S>,
        costs: &mut [S],
        mut controls: Option<&mut DMatrix<S>>,
    ) -> Result<()> {
        check_length("states", self.model.dof(), points.states.nrows())?;
        let mut tau = std::mem::replace(&mut self.slopes, DVector::zeros(0));
        for start in (0..points.count()).step_by(LANES) {
            let count = points.gather(start, &mut self.state);
            let [q, v, a] = split(&self.state);
            rnea(self.model, &mut self.data, q, v, a, tau.as_mut_slice())?;
            let cost = self.cost_of(&tau);
            costs[start..start + count].copy_from_slice(&cost.0[..count]);
            if let Some(controls) = &mut controls {
                for lane in 0..count {
                    let mut u = controls.column_mut(start + lane);
                    u.zip_apply(&tau, |u, tau| *u = tau.0[lane]);
                }
            }
        }
        self.slopes = tau;
        self.add_higher(points, costs);
        Ok(())
    }
}

/// $q, v, a$ of $[q; v; a]$.
fn split<T>(z: &[T]) -> [&[T]; 3] {
    let n = z.len() / 3;
    [&z[..n], &z[n..2 * n], &z[2 * n..]]
}

impl<C: Scalar, S: AlgebraOver<C>> PointCost<S> for ControlEffort<'_, C, S> {
    fn value(&mut self, point: Point<'_, S>) -> Result<S> {
        let (states, mut cost) = (point.states(), [S::zero()]);
        self.values(point.points(&states), &mut cost)?;
        Ok(cost[0])
    }

    fn derivatives(&mut self, point: Point<'_, S>, out: &mut PointDerivatives<S>) -> Result<S> {
        alone(point, out, |points, all| self.all_derivatives(points, all))
    }

    fn order(&self) -> usize {
        2 + self.higher.len()
    }

    fn values(&mut self, points: Points<'_, S>, costs: &mut [S]) -> Result<()> {
        self.values_and_controls(points, costs, None)
    }

    fn all_derivatives(&mut self, points: Points<'_, S>, out: &mut PointsDerivatives<S>) -> Result<()> {
        self.with_term(points, out, &mut |_, _, _| false)
    }
}

impl CostWithControl for ControlEffort<'_, f64, f64> {
    fn values_with_control(
        &mut self,
        points: Points<'_, f64>,
        costs: &mut [f64],
        controls: &mut DMatrix<f64>,
    ) -> Result<()> {
        self.values_and_controls(points, costs, Some(controls))
    }

    fn all_derivatives_with(
        &mut self,
        points: Points<'_, f64>,
        out: &mut PointsDerivatives<f64>,
        term: &mut impl ControlTerm<f64>,
    ) -> Result<()> {
        self.with_term(points, out, term)
    }
}

/// The derivatives at a single point, from the function for many points.
pub(crate) fn alone<S: Scalar>(
    point: Point<'_, S>,
    out: &mut PointDerivatives<S>,
    derivatives: impl FnOnce(Points<'_, S>, &mut PointsDerivatives<S>) -> Result<()>,
) -> Result<S> {
    let (states, mut all) = (point.states(), PointsDerivatives::new(point.q.len(), 1));
    derivatives(point.points(&states), &mut all)?;
    out.hessian = all.hessians.get(0);
    out.metric = all.metrics.get(0);
    out.gradient.copy_from_slice(all.gradients.as_slice());
    Ok(all.costs[0])
}
