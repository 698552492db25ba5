//! Derivatives of inverse dynamics contracted with a vector: of the scalar $\varphi = w^T ID(q, v, a)$ for fixed weights `w`.
//!
//! The weights act like joint velocities: with $\mu_b = \sum_{i \preceq b} S_i w_i$ the virtual velocity of body `b`,
//! $\varphi = \sum_b \mu_b \cdot (I_b a_b + v_b \times^* I_b v_b)$ is the power of the forces on it. No third-order tensor
//! appears. With $\dot\Psi_k = v_{\lambda(k)} \times S_k$, $\ddot\Psi_k = a_{\lambda(k)} \times S_k + v_{\lambda(k)} \times \dot\Psi_k$,
//! $\eta_k = \mu_{\lambda(k)} \times S_k$, and sums over the subtree of `k`
//!
//! $$ F_k = \sum f_b, \quad L_k = \sum I_b \mu_b, \quad P_k = \sum 2 B(I_b, v_b)^T \mu_b, $$
//!
//! the gradient is that of an adjoint of the recursive Newton-Euler algorithm:
//!
//! $$ \partial \varphi / \partial q_k = P_k \cdot \dot\Psi_k + L_k \cdot \ddot\Psi_k + F_k \cdot \eta_k, \quad
//!    \partial \varphi / \partial v_k = P_k \cdot S_k + 2 L_k \cdot \dot\Psi_k, \quad
//!    \partial \varphi / \partial a_k = L_k \cdot S_k. $$
//!
//! Moving a joint `k` at or beyond `j` changes only the sums in the gradient at `j`. It carries the subtree along and adds
//! $\dot\Psi_k$, $\ddot\Psi_k - v_b \times \dot\Psi_k$ and $\eta_k$ to the velocities, accelerations and virtual velocities there.
//! As $B(I, m)^T \mu = -B(I, \mu)^T m$, the changes of the sums need no more than sums again, with
//! $D_k = \sum B(I_b, \mu_b)$:
//!
//! $$ \partial_{q_k} F = S_k \times^* F_k + 2 B_k \dot\Psi_k + I_k \ddot\Psi_k, \quad
//!    \partial_{q_k} L = S_k \times^* L_k + I_k \eta_k, \quad
//!    \partial_{q_k} P = S_k \times^* P_k + 2 B_k^T \eta_k - 2 D_k^T \dot\Psi_k, $$
//! $$ \partial_{v_k} F = 2 (B_k S_k + I_k \dot\Psi_k), \quad \partial_{v_k} P = -2 D_k^T S_k, \quad
//!    \partial_{a_k} F = I_k S_k, $$
//!
//! and the other half of each block follows from the symmetry of second derivatives.

use super::{Data, check_square};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::Coriolis;
use nalgebra::{DMatrix, DVector};

/// The gradient of $w^T ID(q, v, a)$.
#[derive(Clone, Debug, PartialEq)]
pub struct ContractedGradient<S: Scalar> {
    /// $(\partial ID / \partial q)^T w$, `N` entries.
    pub q: DVector<S>,
    /// $(\partial ID / \partial v)^T w$, `N` entries.
    pub v: DVector<S>,
    /// $H w$, `N` entries.
    pub a: DVector<S>,
}

impl<S: Scalar> ContractedGradient<S> {
    /// Room for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            q: DVector::zeros(n),
            v: DVector::zeros(n),
            a: DVector::zeros(n),
        }
    }
}

/// The blocks of the Hessian of $w^T ID(q, v, a)$, `N` by `N` each; that in `a` twice and that in `v` and `a` are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct ContractedHessian<S: Scalar> {
    /// $\partial^2 (w^T ID) / \partial q_i \partial q_j$.
    pub qq: DMatrix<S>,
    /// $\partial^2 (w^T ID) / \partial q_i \partial v_j$.
    pub qv: DMatrix<S>,
    /// $\partial^2 (w^T ID) / \partial v_i \partial v_j$.
    pub vv: DMatrix<S>,
    /// $\partial^2 (w^T ID) / \partial q_i \partial a_j$, the transpose of $\partial (H w) / \partial q$.
    pub qa: DMatrix<S>,
}

impl<S: Scalar> ContractedHessian<S> {
    /// Room for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zeros = || DMatrix::zeros(n, n);
        Self {
            qq: zeros(),
            qv: zeros(),
            vv: zeros(),
            qa: zeros(),
        }
    }
}

/// The gradient of $w^T ID$ at `(q, v, a)`, `N` entries each, by a hand-written adjoint of [`rnea`](super::rnea). Cost O(N).
///
/// # Errors
/// An argument does not have one entry a joint, or `out` was made for another size.
pub fn rnea_contracted_gradient<C: Scalar, S: Over<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    w: &[S],
    out: &mut ContractedGradient<S>,
) -> Result<()> {
    for (what, vector) in [("out.q", &out.q), ("out.v", &out.v), ("out.a", &out.a)] {
        model.check(what, vector.len())?;
    }
    data.contract(model, q, v, a, w)?;
    let two = S::from_f64(2.0);
    for (i, joint) in model.joints().iter().enumerate().rev() {
        let (axis, rate, rate2) = (data.axes[i], data.axis_rates[i], data.accelerations[i]);
        let (force, momentum, p) = (
            data.forces[i],
            data.virtual_momenta[i],
            data.virtual_forces[i],
        );
        out.q[i] = rate.dot(&p) + rate2.dot(&momentum) + data.virtual_axis_rates[i].dot(&force);
        out.v[i] = axis.dot(&p) + rate.dot(&momentum) * two;
        out.a[i] = axis.dot(&momentum);
        if let Some(parent) = joint.parent() {
            data.forces[parent] += force;
            data.virtual_momenta[parent] += momentum;
            data.virtual_forces[parent] += p;
        }
    }
    Ok(())
}

/// The Hessian of $w^T ID$ at `(q, v, a)`, `N` entries each. Cost O(N d) with d the depth of the tree.
///
/// # Errors
/// An argument does not have one entry a joint, or `out` was made for another size.
pub fn rnea_contracted_hessian<C: Scalar, S: Over<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    w: &[S],
    out: &mut ContractedHessian<S>,
) -> Result<()> {
    let blocks = [
        ("qq", &mut out.qq),
        ("qv", &mut out.qv),
        ("vv", &mut out.vv),
        ("qa", &mut out.qa),
    ];
    for (what, matrix) in blocks {
        check_square(what, model.dof(), matrix)?;
        matrix.fill(S::zero());
    }
    data.contract(model, q, v, a, w)?;
    for i in 0..model.dof() {
        data.virtual_coriolis[i] = Coriolis::new(&data.inertias[i], &data.virtual_velocities[i]);
    }
    let two = S::from_f64(2.0);
    for (k, joint) in model.joints().iter().enumerate().rev() {
        let (axis, rate, rate2) = (data.axes[k], data.axis_rates[k], data.accelerations[k]);
        let gained = data.virtual_axis_rates[k];
        let (inertia, b, d) = (data.inertias[k], data.coriolis[k], data.virtual_coriolis[k]);
        let (force, momentum, p) = (
            data.forces[k],
            data.virtual_momenta[k],
            data.virtual_forces[k],
        );

        let f_by_q = axis.cross_force(&force) + b.apply(&rate) * two + inertia.apply(&rate2);
        let l_by_q = axis.cross_force(&momentum) + inertia.apply(&gained);
        let p_by_q =
            axis.cross_force(&p) + (b.apply_transpose(&gained) - d.apply_transpose(&rate)) * two;
        let f_by_a = inertia.apply(&axis);
        let f_by_v = (b.apply(&axis) + inertia.apply(&rate)) * two;
        let p_by_v = -d.apply_transpose(&axis) * two;

        let mut ancestor = Some(k);
        while let Some(j) = ancestor {
            let (axis_j, rate_j) = (&data.axes[j], &data.axis_rates[j]);
            let (rate2_j, gained_j) = (&data.accelerations[j], &data.virtual_axis_rates[j]);
            out.qq[(j, k)] = rate_j.dot(&p_by_q) + rate2_j.dot(&l_by_q) + gained_j.dot(&f_by_q);
            out.qq[(k, j)] = out.qq[(j, k)];
            out.vv[(j, k)] = axis_j.dot(&p_by_v);
            out.vv[(k, j)] = out.vv[(j, k)];
            out.qv[(j, k)] = rate_j.dot(&p_by_v) + gained_j.dot(&f_by_v);
            out.qv[(k, j)] = axis_j.dot(&p_by_q) + rate_j.dot(&l_by_q) * two;
            out.qa[(j, k)] = gained_j.dot(&f_by_a);
            out.qa[(k, j)] = axis_j.dot(&l_by_q);
            ancestor = model.joints()[j].parent();
        }
        if let Some(parent) = joint.parent() {
            data.inertias[parent] += inertia;
            data.coriolis[parent] += b;
            data.virtual_coriolis[parent] += d;
            data.forces[parent] += force;
            data.virtual_momenta[parent] += momentum;
            data.virtual_forces[parent] += p;
        }
    }
    Ok(())
}

impl<S: Scalar> Data<S> {
    /// What both contractions start from: motions, forces and virtual quantities of the bodies. The accelerations end as
    /// $\ddot\Psi$.
    fn contract<C: Scalar>(
        &mut self,
        model: &Model<C>,
        q: &[S],
        v: &[S],
        a: &[S],
        w: &[S],
    ) -> Result<()>
    where
        S: Over<C>,
    {
        self.prepare_derivatives(model, q, v, a)?;
        self.add_virtual_velocities(model, w)?;
        let two = S::from_f64(2.0);
        for i in 0..model.dof() {
            let mu = &self.virtual_velocities[i];
            self.virtual_forces[i] = self.coriolis[i].apply_transpose(mu) * two;
        }
        Ok(())
    }
}
