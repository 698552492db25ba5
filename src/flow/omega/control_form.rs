//! The control form of Theorem B3: no forward dynamics and no third-order tensor.

use crate::dynamics::{Data, InverseDynamicsDerivatives, mass_matrix_and_rate, rnea_derivatives};
use crate::error::Result;
use crate::flow::{ControlCost, ControlLagrangian, Node, RightHandSide, Sum};
use crate::linalg::Ldlt;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar, Tanh};
use nalgebra::{DMatrix, DVector, DVectorView};

/// The right-hand side of the flow written in the control $u = ID(x_{P1}, x_{P2}, \dot x_{P2})$ of (13).
///
/// With $L = k |\dot x_{P1} - x_{P2}|^2 + |u|^2$ the heat flow (7) is
///
/// $$ \Omega_{P1} = 2 (\ddot x_{P1} - \dot x_{P2}) - \tfrac2k \left( \tfrac{\partial ID}{\partial q} \right)^T u, $$
/// $$ \Omega_{P2} = 2 (H H)^{-1} \left[ \dot H u + H \dot u + k (\dot x_{P1} - x_{P2}) -
///    \left( \tfrac{\partial ID}{\partial v}
///    \right)^T u \right] $$
/// $$ = 2 \ddot x_{P2} + 2 H^{-1} \left[
///    \tfrac{\partial ID}{\partial q} \dot x_{P1} + \tfrac{\partial ID}{\partial v} \dot x_{P2} +
///    H^{-1} \left( \dot H u + k (\dot x_{P1} - x_{P2}) - \left( \tfrac{\partial ID}{\partial v} \right)^T u \right)
///    \right], $$
///
/// since $\dot u = \frac{\partial ID}{\partial q} \dot x_{P1} + \frac{\partial ID}{\partial v} \dot x_{P2} + H \ddot
/// x_{P2}$. The last form is the one that is evaluated, because it never multiplies a term by `H` and then divides it
/// by `H`. All derivatives are at $(x_{P1}, x_{P2}, \dot x_{P2})$ and $\dot H$ along $\dot x_{P1}$. The result equals
/// that of Theorem B3. Cost O(N d) for the dynamics and O(N^3) for the factors of `H`.
///
/// A [`ControlLagrangian`] also has weights $W$, a dual trajectory $\lambda_e$ of the slip and a cost $\ell(t, u)$. In
/// the first form, $\mu = W u + \tfrac12 \ell^{\prime}$ then replaces `u` and
/// $\dot \mu = V \dot u + \tfrac12 \partial_t \ell^{\prime}$ with $V = W + \tfrac12 \ell^{\prime\prime}$ replaces
/// $\dot u$, the metric is $\mathrm{blockdiag}(k I, H W H)$, and
///
/// $$ \Omega_{P1} = 2 (\ddot x_{P1} - \dot x_{P2}) + \tfrac1k (\dot \lambda_e - 2 J_q^T \mu), $$
/// $$ \Omega_{P2} = (H W H)^{-1} \left[
///    2 \dot H \mu + 2 H \dot \mu + 2 k (\dot x_{P1} - x_{P2}) + \lambda_e - 2 J_v^T \mu \right] . $$
#[derive(Clone, Debug)]
pub struct ControlForm<'m, C: Scalar = f64, S: Scalar = C, L = ()> {
    model: &'m Model<C>,
    lagrangian: ControlLagrangian<C, L>,
    mu: DVector<S>,
    /// $\tfrac12 \ell^{\prime\prime}$.
    slope: DVector<S>,
    /// $\tfrac12 \partial_t \ell^{\prime}$.
    aging: DVector<S>,
    data: Data<S>,
    id: InverseDynamicsDerivatives<S>,
    hdot: DMatrix<S>,
    ldlt: Ldlt<S>,
    rate: DVector<S>,
    sum: DVector<S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C> + Tanh> ControlForm<'m, C, S> {
    /// The right-hand side for `model`.
    #[must_use]
    pub fn new(model: &'m Model<C>) -> Self {
        Self::with_cost(model, ())
    }
}

impl<'m, C: Scalar, S: AlgebraOver<C> + Tanh, L: ControlCost<C>> ControlForm<'m, C, S, L> {
    /// The right-hand side for `model` and the paper's Lagrangian plus `cost`.
    #[must_use]
    pub fn with_cost(model: &'m Model<C>, cost: L) -> Self {
        Self::of(model, ControlLagrangian::with_cost(cost))
    }

    /// The right-hand side for `model` and `lagrangian` in the metric of `lagrangian`.
    #[must_use]
    pub fn of(model: &'m Model<C>, lagrangian: ControlLagrangian<C, L>) -> Self {
        let n = model.dof();
        Self {
            model,
            lagrangian,
            mu: DVector::zeros(n),
            slope: DVector::zeros(n),
            aging: DVector::zeros(n),
            data: Data::new(model),
            id: InverseDynamicsDerivatives::new(n),
            hdot: DMatrix::zeros(n, n),
            ldlt: Ldlt::new(n),
            rate: DVector::zeros(n),
            sum: DVector::zeros(n),
        }
    }

    /// The term that `cost` adds to the flow of the paper's Lagrangian, for use with any form of the latter: the
    /// control form with `cost` minus the one without.
    #[must_use]
    pub fn of_cost(model: &'m Model<C>, cost: L) -> Sum<Self, ControlForm<'m, C, S>, S> {
        Sum::difference(Self::with_cost(model, cost), ControlForm::new(model))
    }

    /// Computes $\mu$, $\tfrac12 \ell^{\prime\prime}$ and $\tfrac12 \partial_t \ell^{\prime}$ from the control.
    fn weigh(&mut self, t: S) {
        let (u, half) = (&self.id.tau, S::from_f64(0.5));
        let ControlLagrangian { weights, cost, .. } = &self.lagrangian;
        self.mu.copy_from(u);
        weights.multiply(self.mu.as_mut_slice());
        if !cost.is_zero() {
            for i in 0..u.len() {
                let [first, second, _] = cost.derivatives(t, i, u[i]);
                let [rate, _] = cost.rates(t, i, u[i]);
                self.mu[i] += half * first;
                self.slope[i] = half * second;
                self.aging[i] = half * rate;
            }
        }
    }
}

impl<C: Scalar, S: AlgebraOver<C> + Tanh, L: ControlCost<C>> RightHandSide<C, S> for ControlForm<'_, C, S, L> {
    fn omega(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()> {
        let (n, one, zero, two) = (self.model.dof(), S::one(), S::zero(), S::from_f64(2.0));
        node.check(n, omega.len())?;
        self.lagrangian.check(n)?;
        let (q, v, a) = (node.x_p1(), node.x_p2(), node.xdot_p2());
        mass_matrix_and_rate(self.model, &mut self.data, q, node.xdot_p1(), &mut self.id.h, &mut self.hdot)?;
        rnea_derivatives(self.model, &mut self.data, q, v, a, &mut self.id)?;
        self.weigh(node.t);
        let ControlLagrangian { weights, slip_dual, cost } = &self.lagrangian;
        let mu = &self.mu;
        let InverseDynamicsDerivatives { dq, dv, h, .. } = &self.id;

        let view = |x| DVectorView::from_slice(x, n);
        // The rate of u without its inertia term H xddot_P2.
        self.rate.gemv(one, dq, &view(node.xdot_p1()), zero);
        self.rate.gemv(one, dv, &view(a), one);

        self.sum.gemv_tr(one, dq, mu, zero);
        let per_k = C::one() / k;
        for i in 0..n {
            let slip_rate = node.xddot_p1()[i] - a[i];
            omega[i] = two * (slip_rate - self.sum[i].scale(per_k));
        }

        self.sum.gemv_tr(-one, dv, mu, zero);
        self.sum.gemv(one, &self.hdot, mu, one);
        for i in 0..n {
            self.sum[i] += (node.xdot_p1()[i] - v[i]).scale(k);
        }
        if let Some(dual) = slip_dual {
            for i in 0..n {
                let [lambda, lambda_rate] = dual.value_and_rate(i, node.t);
                self.sum[i] += S::from_f64(0.5) * lambda;
                omega[i] += lambda_rate.scale(per_k);
            }
        }
        self.ldlt.factorise(h);
        self.ldlt.solve(self.sum.as_mut_slice());
        if !cost.is_zero() {
            self.sum += &self.aging;
        }
        weights.divide(self.sum.as_mut_slice());
        self.sum += &self.rate;
        if !cost.is_zero() {
            self.rate.gemv(one, h, &view(node.xddot_p2()), one);
            self.rate.component_mul_assign(&self.slope);
            weights.divide(self.rate.as_mut_slice());
            self.sum += &self.rate;
        }
        self.ldlt.solve(self.sum.as_mut_slice());
        for i in 0..n {
            omega[n + i] = two * (node.xddot_p2()[i] + self.sum[i]);
        }
        Ok(())
    }
}
