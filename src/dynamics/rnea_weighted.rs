//! Derivatives of inverse dynamics contracted with a vector: of the scalar $\varphi = w^T ID(q, v, a)$ for fixed
//! weights `w`.
//!
//! The weights act like joint velocities: with $\mu_b = \sum_{i \preceq b} S_i w_i$ the virtual velocity of body `b`,
//! $\varphi = \sum_b \mu_b \cdot (I_b a_b + v_b \times^* I_b v_b)$ is the power of the forces on it. No third-order
//! tensor appears. With $\dot\Psi_k = v_{\lambda(k)} \times S_k$,
//! $\ddot\Psi_k = a_{\lambda(k)} \times S_k + v_{\lambda(k)} \times \dot\Psi_k$,
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
//! Moving a joint `k` at or beyond `j` changes only the sums in the gradient at `j`. It carries the subtree along and
//! adds $\dot\Psi_k$, $\ddot\Psi_k - v_b \times \dot\Psi_k$ and $\eta_k$ to the velocities, accelerations and virtual
//! velocities there. As $B(I, m)^T \mu = -B(I, \mu)^T m$, the changes of the sums are sums of the same kind, with
//! $D_k = \sum B(I_b, \mu_b)$:
//!
//! $$ \partial_{q_k} F = S_k \times^* F_k + 2 B_k \dot\Psi_k + I_k \ddot\Psi_k, \quad
//!    \partial_{q_k} L = S_k \times^* L_k + I_k \eta_k, \quad
//!    \partial_{q_k} P = S_k \times^* P_k + 2 B_k^T \eta_k - 2 D_k^T \dot\Psi_k, $$
//! $$ \partial_{v_k} F = 2 (B_k S_k + I_k \dot\Psi_k), \quad \partial_{v_k} P = -2 D_k^T S_k, \quad
//!    \partial_{a_k} F = I_k S_k, $$
//!
//! and the other half of each block follows from the symmetry of second derivatives.

use super::rnea::add_drives;
use super::rnea_derivatives::SubtreeForceDerivatives;
use super::{Data, InverseDynamicsDerivatives, clear_square, path_to_base};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Coriolis, Motion, cross, dot};
use nalgebra::{DMatrix, DVector};

/// The gradient of $w^T ID(q, v, a)$.
#[derive(Clone, Debug, PartialEq)]
pub struct RneaVjp<S: Scalar> {
    /// $(\partial ID / \partial q)^T w$, `N` entries.
    pub q: DVector<S>,
    /// $(\partial ID / \partial v)^T w$, `N` entries.
    pub v: DVector<S>,
    /// $H w$, `N` entries.
    pub a: DVector<S>,
}

impl<S: Scalar> RneaVjp<S> {
    /// Allocates the results for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { q: DVector::zeros(n), v: DVector::zeros(n), a: DVector::zeros(n) }
    }
}

/// The blocks of the Hessian of $w^T ID(q, v, a)$, `N` by `N` each; those in `(a, a)` and in `(v, a)` are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct RneaWeightedHessian<S: Scalar> {
    /// $\partial^2 (w^T ID) / \partial q_i \partial q_j$.
    pub qq: DMatrix<S>,
    /// $\partial^2 (w^T ID) / \partial q_i \partial v_j$.
    pub qv: DMatrix<S>,
    /// $\partial^2 (w^T ID) / \partial v_i \partial v_j$.
    pub vv: DMatrix<S>,
    /// $\partial^2 (w^T ID) / \partial q_i \partial a_j$, the transpose of $\partial (H w) / \partial q$.
    pub qa: DMatrix<S>,
}

impl<S: Scalar> RneaWeightedHessian<S> {
    /// Allocates the results for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zeros = || DMatrix::zeros(n, n);
        Self { qq: zeros(), qv: zeros(), vv: zeros(), qa: zeros() }
    }

    /// Sets the blocks to zero, after a check of their sizes.
    pub(super) fn clear<C: Scalar>(&mut self, model: &Model<C>) -> Result<()> {
        let blocks = [("qq", &mut self.qq), ("qv", &mut self.qv), ("vv", &mut self.vv), ("qa", &mut self.qa)];
        for (what, matrix) in blocks {
            clear_square(what, model.dof(), matrix)?;
        }
        Ok(())
    }

    /// Adds the curvature of the losses of the drives.
    fn add_drives<C: Scalar>(&mut self, model: &Model<C>, v: &[S], w: &[S])
    where
        S: AlgebraOver<C>,
    {
        for (i, drive) in model.drives().iter().enumerate() {
            let [_, _, curvature] = drive.losses(v[i]);
            self.vv[(i, i)] += curvature * w[i];
        }
    }
}

/// Computes the gradient of $w^T ID(q, v, a)$ for a constant `w`, by the adjoint of [`rnea`](super::rnea()).
///
/// * `q`, `v`, `a`, `w`: `N` entries
/// * `out`: made for `N` joints, overwritten
///
/// # Errors
/// A slice does not have `N` entries, or `out` or `data` was made for another number of joints.
///
/// # Cost
/// O(N).
pub fn rnea_vjp<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    w: &[S],
    out: &mut RneaVjp<S>,
) -> Result<()> {
    for (what, vector) in [("out.q", &out.q), ("out.v", &out.v), ("out.a", &out.a)] {
        model.check(what, vector.len())?;
    }
    data.prepare_derivatives(model, q, v, a)?;
    data.contract(model, w, Motion::zero())?;
    data.sum_forces(model);
    let two = S::from_f64(2.0);
    for (i, joint) in model.joints().iter().enumerate().rev() {
        let (axis, rate, psi_ddot) = (data.axes[i], data.axis_rates[i], data.psi_ddot[i]);
        let (force, momentum, p) = (data.forces[i], data.virtual_momenta[i], data.virtual_couples[i]);
        out.q[i] = dot(&rate.angular, &p) + psi_ddot.dot(&momentum) + data.virtual_axis_rates[i].dot(&force);
        out.v[i] = dot(&axis.angular, &p) + rate.dot(&momentum) * two;
        out.a[i] = axis.dot(&momentum);
        if let Some(parent) = joint.parent() {
            data.virtual_momenta[parent] += momentum;
            data.virtual_couples[parent] += p;
        }
    }
    for (i, drive) in model.drives().iter().enumerate() {
        let [_, slope, _] = drive.losses(v[i]);
        out.v[i] += slope * w[i];
        out.a[i] += w[i].scale(drive.armature);
    }
    Ok(())
}

/// Computes the Hessian of $w^T ID(q, v, a)$ for a constant `w`.
///
/// * `q`, `v`, `a`, `w`: `N` entries
/// * `out`: made for `N` joints, overwritten
///
/// # Errors
/// A slice does not have `N` entries, or `out` or `data` was made for another number of joints.
///
/// # Cost
/// O(N d), with d the depth of the tree, and O(N^2) to clear the blocks.
pub fn rnea_weighted_hessian<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    w: &[S],
    out: &mut RneaWeightedHessian<S>,
) -> Result<()> {
    out.clear(model)?;
    data.prepare_derivatives(model, q, v, a)?;
    data.contract(model, w, Motion::zero())?;
    data.sum_forces(model);
    data.sweep(model, out, |_, _, _| ());
    out.add_drives(model, v, w);
    Ok(())
}

/// Computes inverse dynamics with its first derivatives, and the Hessian of $w^T ID$ for weights that depend on $\tau$:
/// as [`rnea_derivatives`](super::rnea_derivatives()) and [`rnea_weighted_hessian`], which share most of their work.
///
/// * `q`, `v`, `a`: `N` entries; rad or m, per s, per s^2
/// * `weigh`: computes the weights `w`, `N` entries, from $\tau$
/// * `first`, `second`: made for `N` joints, overwritten
///
/// # Errors
/// A slice does not have `N` entries, or `first`, `second` or `data` was made for another number of joints.
///
/// # Cost
/// O(N d), with d the depth of the tree, and O(N^2) to clear the matrices.
pub fn rnea_second_order<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    [q, v, a]: [&[S]; 3],
    weigh: impl FnOnce(&DVector<S>, &mut [S]),
    first: &mut InverseDynamicsDerivatives<S>,
    second: &mut RneaWeightedHessian<S>,
) -> Result<()> {
    first.clear(model)?;
    second.clear(model)?;
    data.prepare_derivatives(model, q, v, a)?;
    data.sum_forces(model);
    data.read_torques(&mut first.tau);
    add_drives(model, v, a, first.tau.as_mut_slice());
    let mut w = std::mem::take(&mut data.scalar_scratch);
    weigh(&first.tau, &mut w);
    let contracted = data.contract(model, &w, Motion::zero());
    if contracted.is_ok() {
        data.sweep(model, second, |k, load, data| {
            load.fill_row_and_column(model, data, k, first);
        });
        first.add_drive_derivatives(model, v);
        second.add_drives(model, v, &w);
    }
    data.scalar_scratch = w;
    contracted
}

impl<S: Scalar> Data<S> {
    /// Computes the virtual quantities of the bodies for a contraction with the weights `w` of the joints and the
    /// virtual velocity of the base, after [`prepare_derivatives`](Self::prepare_derivatives).
    pub(super) fn contract<C: Scalar>(&mut self, model: &Model<C>, w: &[S], base: Motion<S>) -> Result<()> {
        self.add_virtual_velocities(model, w, base)?;
        let two = S::from_f64(2.0);
        for i in 0..model.dof() {
            let mu = &self.virtual_velocities[i];
            self.virtual_couples[i] = self.coriolis[i].apply_transpose(mu) * two;
        }
        Ok(())
    }

    /// The Hessian, after [`contract`](Self::contract) and [`sum_forces`](Self::sum_forces): from the tips to the base,
    /// with sums over subtrees. `visit` takes the load on each joint.
    pub(super) fn sweep<C: Scalar>(
        &mut self,
        model: &Model<C>,
        out: &mut RneaWeightedHessian<S>,
        mut visit: impl FnMut(usize, &SubtreeForceDerivatives<S>, &Self),
    ) {
        for i in 0..model.dof() {
            let mu = &self.virtual_velocities[i];
            self.virtual_coriolis[i] = Coriolis::new(&self.inertias[i], mu);
        }
        let two = S::from_f64(2.0);
        for (k, joint) in model.joints().iter().enumerate().rev() {
            // The derivatives of the force F on the subtree of k in the coordinates of joint k.
            let f = self.push(k);
            visit(k, &f, self);
            let (axis, rate, gained) = (&self.axes[k], &self.axis_rates[k], &self.virtual_axis_rates[k]);
            let (inertia, b, d) = (&self.inertias[k], &self.coriolis[k], &self.virtual_coriolis[k]);
            let (momentum, p) = (&self.virtual_momenta[k], &self.virtual_couples[k]);
            let l_by_q = axis.cross_force(momentum) + inertia.apply(gained);
            let p_by_q = cross(&axis.angular, p) + (b.apply_transpose(gained) - d.apply_transpose(rate)) * two;
            let p_by_v = -d.apply_transpose(axis) * two;

            for j in path_to_base(model, k) {
                let (axis_j, rate_j) = (&self.axes[j], &self.axis_rates[j]);
                let (psi_ddot_j, gained_j) = (&self.psi_ddot[j], &self.virtual_axis_rates[j]);
                out.qq[(j, k)] = dot(&rate_j.angular, &p_by_q) + psi_ddot_j.dot(&l_by_q) + gained_j.dot(&f.by_q);
                out.qq[(k, j)] = out.qq[(j, k)];
                out.vv[(j, k)] = dot(&axis_j.angular, &p_by_v);
                out.vv[(k, j)] = out.vv[(j, k)];
                out.qv[(j, k)] = dot(&rate_j.angular, &p_by_v) + gained_j.dot(&f.by_v);
                out.qv[(k, j)] = dot(&axis_j.angular, &p_by_q) + rate_j.dot(&l_by_q) * two;
                out.qa[(j, k)] = gained_j.dot(&f.by_a);
                out.qa[(k, j)] = axis_j.dot(&l_by_q);
            }
            if let Some(parent) = joint.parent() {
                let (d, momentum, p) = (*d, *momentum, *p);
                self.add_to_subtree(k, parent);
                self.virtual_coriolis[parent] += d;
                self.virtual_momenta[parent] += momentum;
                self.virtual_couples[parent] += p;
            }
        }
    }
}
