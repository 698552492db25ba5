//! The Jacobian of the control form, by contracted second derivatives of inverse dynamics.

use super::{NodeBlocks, NodeJacobian};
use crate::dynamics::{
    Data, InverseDynamicsDerivatives, RneaWeightedHessian, mass_matrix_product_derivative, rnea_derivatives,
    rnea_weighted_hessian,
};
use crate::error::Result;
use crate::flow::{ControlCost, ControlLagrangian, Node, Sum};
use crate::linalg::Ldlt;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Jet, Scalar, Tanh};
use nalgebra::{DMatrix, DVector};

/// The Jacobian of [`ControlForm`](crate::flow::ControlForm), analytic and without third-order tensors. The default.
///
/// Write $r = \dot H u + H \dot u + k (\dot x_{P1} - x_{P2}) - J_v^T u$, so that $\Omega_{P2} = 2 (H H)^{-1} r$, with
/// $J_q, J_v$ the derivatives of $u = ID(x_{P1}, x_{P2}, \dot x_{P2})$; let $z = H^{-1} r$, $y = H^{-1} z$,
/// $K_w = \partial (H w) / \partial q$, and $\Phi$ the Hessian of $u^T ID$ for fixed `u`. A dot is the rate along
/// $(\dot x_{P1}, \dot x_{P2}, \ddot x_{P2})$, one tangent of a [`Jet`] through `rnea_derivatives`. Then
///
/// | block | value |
/// | --- | --- |
/// | $\partial \Omega_{P1} / \partial x_{P1}$ | $-\tfrac2k (\Phi_{qq} + J_q^T J_q)$ |
/// | $\partial \Omega_{P1} / \partial x_{P2}$ | $-\tfrac2k (\Phi_{qv} + J_q^T J_v)$ |
/// | $\partial \Omega_{P1} / \partial \dot x_{P2}$ | $-2 I - \tfrac2k (\Phi_{qa} + J_q^T H)$ |
/// | $\partial \Omega_{P2} / \partial x_{P1}$ | $2 H^{-1} [\dot J_q - K_y + H^{-1} (A J_q + \dot K_u + K_{\dot u - z} - \Phi_{vq})]$ |
/// | $\partial \Omega_{P2} / \partial x_{P2}$ | $2 H^{-1} [\dot J_v + H^{-1} (A J_v - \Phi_{vv} - k I)]$ |
/// | $\partial \Omega_{P2} / \partial \dot x_{P1}$ | $2 H^{-1} [J_q + H^{-1} (K_u + k I)]$ |
/// | $\partial \Omega_{P2} / \partial \dot x_{P2}$ | $2 H^{-1} [J_v + \dot H + H^{-1} A H]$ |
///
/// with $A = \dot H - J_v^T$; $\partial \Omega_{P1} / \partial \dot x_{P1} = 0$ and
/// $\partial \Omega / \partial \ddot x = 2 I$ (B80). Cost O(N d) for the dynamics, d the depth of the tree, and O(N^3)
/// for dense products and solves.
///
/// A [`ControlLagrangian`] also has weights $W$, a dual trajectory $\lambda_e$ of the slip and a cost $\ell(t, u)$.
/// They replace `u` by $\mu = W u + \tfrac12 \ell^{\prime}$ and $\dot u$ by
/// $\dot \mu = V \dot u + \tfrac12 \partial_t \ell^{\prime}$ with
/// $V = W + \tfrac12 \ell^{\prime\prime}$, and add $\tfrac12 \lambda_e$ to `r`. The metric replaces $y = H^{-1} z$ by
/// $H^{-1} W^{-1} z$. Because $d\mu = V du$ and $d \dot \mu = V d\dot u + Y du$ with
/// $Y = \tfrac12 \mathrm{diag} (\ell^{\prime\prime\prime} \dot u + \partial_t \ell^{\prime\prime})$, the table holds
/// with $[J_q, J_v, H]$ replaced by $V [J_q, J_v, H]$ and their rates by
/// $V [\dot J_q, \dot J_v, \dot H] + Y [J_q, J_v, H]$, except in $A$ and in $J_q^T$; with $W^{-1}$ in front of
/// everything in the outer brackets except $K_y$; and
/// $\partial \Omega_{P2} / \partial \ddot x_{P2} = 2 H^{-1} W^{-1} V H$.
#[derive(Clone, Debug)]
pub struct ControlFormJacobian<'m, C: Scalar = f64, S: Scalar = C, L = ()> {
    model: &'m Model<C>,
    lagrangian: ControlLagrangian<C, L>,
    /// The diagonals of `V` and `Y`.
    diagonals: [DVector<S>; 2],
    data: Data<S>,
    jet_data: Data<Jet<S, 1>>,
    jet_id: InverseDynamicsDerivatives<Jet<S, 1>>,
    jet_k: DMatrix<Jet<S, 1>>,
    /// The arguments of the passes with a tangent: `q`, `v`, `a` and the weights `u`.
    jet_arguments: [Vec<Jet<S, 1>>; 4],
    hessian: RneaWeightedHessian<S>,
    /// $[J_q, J_v, H]$, `N` by `3 N`, and its rate; then with `V` and `Y`, and last divided by `W`.
    derivatives: DMatrix<S>,
    rates: DMatrix<S>,
    /// $\mu$ and $\dot \mu$, which are $u$ and $\dot u$ without a cost.
    mu: DVector<S>,
    mudot: DVector<S>,
    z: DVector<S>,
    y: DVector<S>,
    /// $K_y$ and $K_{\dot u - z}$.
    k_y: DMatrix<S>,
    k_rest: DMatrix<S>,
    a: DMatrix<S>,
    ldlt: Ldlt<S>,
    h_inverse: DMatrix<S>,
    jq_transposed: DMatrix<S>,
    /// The innermost brackets of the rows of $\Omega_{P2}$, then the full ones, `N` by `4 N`.
    brackets: DMatrix<S>,
    /// The rows of $\Omega_{P2}$, `N` by `4 N`: derivatives in $x_{P1}, x_{P2}, \dot x_{P1}, \dot x_{P2}$.
    lower: DMatrix<S>,
    /// $J_q^T [J_q, J_v, H]$, `N` by `3 N`.
    upper: DMatrix<S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C> + Tanh> ControlFormJacobian<'m, C, S> {
    /// The Jacobian for `model`.
    #[must_use]
    pub fn new(model: &'m Model<C>) -> Self {
        Self::with_cost(model, ())
    }
}

impl<'m, C: Scalar, S: AlgebraOver<C> + Tanh, L: ControlCost<C>> ControlFormJacobian<'m, C, S, L> {
    /// The Jacobian of the term that `cost` adds to the flow of the paper's Lagrangian: the Jacobian with `cost` minus
    /// the one without.
    #[must_use]
    pub fn of_cost(model: &'m Model<C>, cost: L) -> Sum<Self, ControlFormJacobian<'m, C, S>, S> {
        Sum::difference(Self::with_cost(model, cost), ControlFormJacobian::new(model))
    }

    /// The Jacobian for `model` and the paper's Lagrangian plus `cost`.
    #[must_use]
    pub fn with_cost(model: &'m Model<C>, cost: L) -> Self {
        Self::of(model, ControlLagrangian::with_cost(cost))
    }

    /// The Jacobian for `model` and `lagrangian` in the metric of `lagrangian`.
    #[must_use]
    pub fn of(model: &'m Model<C>, lagrangian: ControlLagrangian<C, L>) -> Self {
        let n = model.dof();
        let jets = || vec![Jet::constant(S::zero()); n];
        Self {
            model,
            lagrangian,
            diagonals: [DVector::zeros(n), DVector::zeros(n)],
            data: Data::new(model),
            jet_data: Data::new(model),
            jet_id: InverseDynamicsDerivatives::new(n),
            jet_k: DMatrix::zeros(n, n),
            jet_arguments: [jets(), jets(), jets(), jets()],
            hessian: RneaWeightedHessian::new(n),
            derivatives: DMatrix::zeros(n, 3 * n),
            rates: DMatrix::zeros(n, 3 * n),
            mu: DVector::zeros(n),
            mudot: DVector::zeros(n),
            z: DVector::zeros(n),
            y: DVector::zeros(n),
            k_y: DMatrix::zeros(n, n),
            k_rest: DMatrix::zeros(n, n),
            a: DMatrix::zeros(n, n),
            ldlt: Ldlt::new(n),
            h_inverse: DMatrix::zeros(n, n),
            jq_transposed: DMatrix::zeros(n, n),
            brackets: DMatrix::zeros(n, 4 * n),
            lower: DMatrix::zeros(n, 4 * n),
            upper: DMatrix::zeros(n, 3 * n),
        }
    }

    /// Computes the three blocks at `node` with penalty `k` into `out`.
    ///
    /// # Errors
    /// A slice of `node` does not have `2 N` entries, or a block of `out` is not `2 N` by `2 N`.
    ///
    /// # Cost
    /// O(N d) for the derivatives of the dynamics, with d the depth of the tree, and O(N^3) for the dense products.
    pub fn blocks(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()> {
        out.check(self.model.dof())?;
        node.check(self.model.dof(), out.dx.nrows())?;
        let n = self.model.dof();
        self.lagrangian.check(n)?;
        self.differentiate_inverse_dynamics(node)?;
        self.weigh(node.t);
        self.solve_for_y(node, k);
        self.contract(node)?;
        self.derivatives.columns(0, n).transpose_to(&mut self.jq_transposed);
        self.scale_rows();
        let (one, zero) = (S::one(), S::zero());
        self.upper.gemm(one, &self.jq_transposed, &self.derivatives, zero);
        self.fill_lower(k);
        self.compose(k, out);
        Ok(())
    }

    /// Computes `u`, $J_q$, $J_v$, `H` and their rates in one pass.
    fn differentiate_inverse_dynamics(&mut self, node: Node<'_, S>) -> Result<()> {
        let n = self.model.dof();
        let [q, v, a, _] = &mut self.jet_arguments;
        for i in 0..n {
            q[i] = Jet::new(node.x_p1()[i], [node.xdot_p1()[i]]);
            v[i] = Jet::new(node.x_p2()[i], [node.xdot_p2()[i]]);
            a[i] = Jet::new(node.xdot_p2()[i], [node.xddot_p2()[i]]);
        }
        rnea_derivatives(self.model, &mut self.jet_data, q, v, a, &mut self.jet_id)?;
        let id = &self.jet_id;
        let columns = id.dq.iter().chain(&id.dv).chain(&id.h);
        let split = self.derivatives.iter_mut().zip(self.rates.iter_mut());
        for (jet, (value, rate)) in columns.zip(split) {
            *value = jet.re;
            *rate = jet.eps[0];
        }
        for (i, jet) in id.tau.iter().enumerate() {
            self.mu[i] = jet.re;
            self.mudot[i] = jet.eps[0];
        }
        Ok(())
    }

    /// Returns true if $\mu$ is `u`.
    fn is_plain(&self) -> bool {
        self.lagrangian.weights.is_one() && self.lagrangian.cost.is_zero()
    }

    /// Computes $\mu$ and $\dot \mu$ from `u` and its rate, and the diagonals of `V` and `Y`; without weights and cost,
    /// $\mu = u$.
    fn weigh(&mut self, t: S) {
        if self.is_plain() {
            return;
        }
        let half = S::from_f64(0.5);
        let ControlLagrangian { weights, cost, .. } = &self.lagrangian;
        let [v, y] = &mut self.diagonals;
        for i in 0..self.mu.len() {
            let (u, udot) = (self.mu[i], self.mudot[i]);
            let [first, second, third] = cost.derivatives(t, i, u);
            let [rate, second_rate] = cost.rates(t, i, u);
            v[i] = S::lift(weights.of(i)) + half * second;
            y[i] = half * (third * udot + second_rate);
            self.mu[i] = u.scale(weights.of(i)) + half * first;
            self.mudot[i] = v[i] * udot + half * rate;
        }
    }

    /// Computes $V [J_q, J_v, H]$ and the terms of its rate.
    fn scale_rows(&mut self) {
        if self.is_plain() {
            return;
        }
        let [v, y] = &self.diagonals;
        for j in 0..self.derivatives.ncols() {
            for i in 0..self.derivatives.nrows() {
                let entry = self.derivatives[(i, j)];
                self.rates[(i, j)] = v[i] * self.rates[(i, j)] + y[i] * entry;
                self.derivatives[(i, j)] = v[i] * entry;
            }
        }
    }

    /// Computes `z` and `y` by the two solves of $\Omega_{P2} = 2 y$, and $A = \dot H - J_v^T$.
    fn solve_for_y(&mut self, node: Node<'_, S>, k: C) {
        let n = self.model.dof();
        let (one, zero) = (S::one(), S::zero());
        let h = self.derivatives.columns(2 * n, n);
        self.a.copy_from(&self.rates.columns(2 * n, n));
        for i in 0..n {
            for j in 0..n {
                self.a[(i, j)] -= self.derivatives[(j, n + i)];
            }
        }
        self.z.gemv(one, &h, &self.mudot, zero);
        self.z.gemv(one, &self.a, &self.mu, one);
        for i in 0..n {
            self.z[i] += (node.xdot_p1()[i] - node.x_p2()[i]).scale(k);
        }
        if let Some(dual) = &self.lagrangian.slip_dual {
            for i in 0..n {
                self.z[i] += S::from_f64(0.5) * dual.value(i, node.t);
            }
        }
        self.ldlt.factorise(&h);
        self.ldlt.solve(self.z.as_mut_slice());
        self.y.copy_from(&self.z);
        self.lagrangian.weights.divide(self.y.as_mut_slice());
        self.ldlt.solve(self.y.as_mut_slice());
    }

    /// Computes the contracted second derivatives: $\Phi$, $K_\mu$ with its rate, $K_y$ and $K_{\dot \mu - z}$.
    fn contract(&mut self, node: Node<'_, S>) -> Result<()> {
        let (q, v, a) = (node.x_p1(), node.x_p2(), node.xdot_p2());
        let (model, data) = (self.model, &mut self.data);
        rnea_weighted_hessian(model, data, q, v, a, self.mu.as_slice(), &mut self.hessian)?;
        mass_matrix_product_derivative(model, data, q, self.y.as_slice(), &mut self.k_y)?;
        // z is no longer needed, so its storage is reused.
        self.z.zip_apply(&self.mudot, |z, mudot| *z = mudot - *z);
        mass_matrix_product_derivative(model, data, q, self.z.as_slice(), &mut self.k_rest)?;
        let [q, _, _, u] = &mut self.jet_arguments;
        for (jet, u) in u.iter_mut().zip(&self.mu) {
            *jet = Jet::constant(*u);
        }
        mass_matrix_product_derivative(model, &mut self.jet_data, q, u, &mut self.jet_k)
    }

    /// Computes the rows of $\Omega_{P2}$ without their factor of two.
    fn fill_lower(&mut self, k: C) {
        let n = self.model.dof();
        let k = S::lift(k);
        let phi = &self.hessian;
        let (one, zero) = (S::one(), S::zero());
        // A J_q, A J_v, then a gap for the derivative in xdot_P1, then A H.
        let (jacobians, h) = self.derivatives.columns_range_pair(..2 * n, 2 * n..);
        let (mut left, mut right) = self.brackets.columns_range_pair_mut(..2 * n, 3 * n..);
        left.gemm(one, &self.a, &jacobians, zero);
        right.gemm(one, &self.a, &h, zero);
        for j in 0..n {
            for i in 0..n {
                let k_u = self.jet_k[(i, j)];
                self.brackets[(i, j)] += k_u.eps[0] + self.k_rest[(i, j)] - phi.qv[(j, i)];
                self.brackets[(i, n + j)] -= phi.vv[(i, j)];
                self.brackets[(i, 2 * n + j)] = k_u.re;
            }
            self.brackets[(j, n + j)] -= k;
            self.brackets[(j, 2 * n + j)] += k;
        }
        // Products with the inverse are several times faster than the same number of solves.
        self.h_inverse.fill_with_identity();
        self.ldlt.solve_columns(&mut self.h_inverse);
        self.lower.gemm(one, &self.h_inverse, &self.brackets, zero);
        for part in [&mut self.lower, &mut self.rates, &mut self.derivatives] {
            self.lagrangian.weights.divide(part.as_mut_slice());
        }
        for j in 0..n {
            for i in 0..n {
                self.lower[(i, j)] += self.rates[(i, j)] - self.k_y[(i, j)];
                self.lower[(i, n + j)] += self.rates[(i, n + j)];
                self.lower[(i, 2 * n + j)] += self.derivatives[(i, j)];
                self.lower[(i, 3 * n + j)] += self.derivatives[(i, n + j)] + self.rates[(i, 2 * n + j)];
            }
        }
        self.brackets.copy_from(&self.lower);
        self.lower.gemm(one, &self.h_inverse, &self.brackets, zero);
    }

    /// Assembles all blocks from the rows of $\Omega_{P1}$ and $\Omega_{P2}$.
    fn compose(&mut self, k: C, out: &mut NodeBlocks<S>) {
        let n = self.model.dof();
        let (zero, two) = (S::zero(), S::from_f64(2.0));
        let per_k = -C::from_f64(2.0) / k;
        let phi = &self.hessian;
        for j in 0..n {
            for i in 0..n {
                out.dx[(i, j)] = (phi.qq[(i, j)] + self.upper[(i, j)]).scale(per_k);
                out.dx[(i, n + j)] = (phi.qv[(i, j)] + self.upper[(i, n + j)]).scale(per_k);
                out.dxdot[(i, j)] = zero;
                out.dxdot[(i, n + j)] = (phi.qa[(i, j)] + self.upper[(i, 2 * n + j)]).scale(per_k);
                out.dx[(n + i, j)] = two * self.lower[(i, j)];
                out.dx[(n + i, n + j)] = two * self.lower[(i, n + j)];
                out.dxdot[(n + i, j)] = two * self.lower[(i, 2 * n + j)];
                out.dxdot[(n + i, n + j)] = two * self.lower[(i, 3 * n + j)];
            }
        }
        out.dxddot.fill(zero);
        for j in 0..n {
            out.dxdot[(j, n + j)] -= two;
        }
        out.dxddot.fill_diagonal(two);
        if !self.lagrangian.cost.is_zero() {
            let h = self.derivatives.columns(2 * n, n);
            let mut block = out.dxddot.view_mut((n, n), (n, n));
            block.gemm(two, &self.h_inverse, &h, zero);
        }
    }
}

impl<C: Scalar, S: AlgebraOver<C> + Tanh, L: ControlCost<C>> NodeJacobian<C, S> for ControlFormJacobian<'_, C, S, L> {
    fn evaluate(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()> {
        self.blocks(node, k, out)
    }
}
