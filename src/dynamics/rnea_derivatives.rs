//! Analytic first derivatives of inverse dynamics (RNEA_D in the supplement).
//!
//! The formulas are those of Singh, Russell and Wensing, "Efficient analytical derivatives of rigid-body dynamics using
//! spatial vector algebra" (IEEE RA-L 2022). Joints have one degree of freedom here, so $S_j \times S_j = 0$ and the paper's
//! $\dot\Psi_j = v_{\lambda(j)} \times S_j$ and $\dot S_j = v_j \times S_j$ are the same.

use super::{Data, check_square, kinematics};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::Coriolis;
use nalgebra::{DMatrix, DVector};

/// Inverse dynamics and its first derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseDynamicsDerivatives<S: Scalar> {
    /// $\tau = ID(q, v, a)$, `N` entries.
    pub tau: DVector<S>,
    /// $\partial ID_i / \partial q_j$, `N` by `N`.
    pub dq: DMatrix<S>,
    /// $\partial ID_i / \partial v_j$, `N` by `N`.
    pub dv: DMatrix<S>,
    /// $\partial ID_i / \partial a_j = H_{ij}$, `N` by `N`.
    pub h: DMatrix<S>,
}

impl<S: Scalar> InverseDynamicsDerivatives<S> {
    /// Room for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            tau: DVector::zeros(n),
            dq: DMatrix::zeros(n, n),
            dv: DMatrix::zeros(n, n),
            h: DMatrix::zeros(n, n),
        }
    }
}

/// Inverse dynamics at `(q, v, a)`, `N` entries each, and its derivatives in all three, into `out`. Cost O(N d) with d the
/// depth of the tree.
///
/// # Errors
/// An argument does not have one entry a joint, or `out` was made for another size.
pub fn rnea_derivatives<C: Scalar, S: Over<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    out: &mut InverseDynamicsDerivatives<S>,
) -> Result<()> {
    let n = model.dof();
    model.check("tau", out.tau.len())?;
    for (what, matrix) in [("dq", &mut out.dq), ("dv", &mut out.dv), ("h", &mut out.h)] {
        check_square(what, n, matrix)?;
        matrix.fill(S::zero());
    }
    data.prepare_derivatives(model, q, v, a)?;
    let two = S::from_f64(2.0);
    for (i, joint) in model.joints().iter().enumerate().rev() {
        let (axis, rate, rate2) = (data.axes[i], data.axis_rates[i], data.accelerations[i]);
        let (inertia, coriolis, force) = (data.inertias[i], data.coriolis[i], data.forces[i]);
        out.tau[i] = axis.dot(&force);
        // Forces that moving joint i makes on its subtree, to be met by the joints before it.
        let by_a = inertia.apply(&axis);
        let by_v = (coriolis.apply(&axis) + inertia.apply(&rate)) * two;
        let by_q = coriolis.apply(&rate) * two + inertia.apply(&rate2) + axis.cross_force(&force);
        // How joint i feels the joints before it.
        let felt = coriolis.apply_transpose(&axis) * two;
        let mut ancestor = Some(i);
        while let Some(j) = ancestor {
            let (axis_j, rate_j) = (data.axes[j], data.axis_rates[j]);
            out.h[(j, i)] = axis_j.dot(&by_a);
            out.h[(i, j)] = out.h[(j, i)];
            out.dv[(j, i)] = axis_j.dot(&by_v);
            out.dv[(i, j)] = axis_j.dot(&felt) + rate_j.dot(&by_a) * two;
            out.dq[(j, i)] = axis_j.dot(&by_q);
            out.dq[(i, j)] = rate_j.dot(&felt) + data.accelerations[j].dot(&by_a);
            ancestor = model.joints()[j].parent();
        }
        if let Some(parent) = joint.parent() {
            data.inertias[parent] += inertia;
            data.coriolis[parent] += coriolis;
            data.forces[parent] += force;
        }
    }
    Ok(())
}

impl<S: Scalar> Data<S> {
    /// What the derivatives of inverse dynamics are sums of: the axes $S$ and their rates, the inertias, Coriolis matrices
    /// and forces of the bodies, and in `accelerations` $\ddot\Psi_i = a_{\lambda(i)} \times S_i + v_{\lambda(i)} \times \dot
    /// \Psi_i$ for each joint.
    pub(super) fn prepare_derivatives<C: Scalar>(
        &mut self,
        model: &Model<C>,
        q: &[S],
        v: &[S],
        a: &[S],
    ) -> Result<()>
    where
        S: Over<C>,
    {
        self.place(model, q)?;
        self.add_velocities(model, v)?;
        self.add_accelerations(model, v, a)?;
        for i in 0..model.dof() {
            let (inertia, velocity) = (self.inertias[i], &self.velocities[i]);
            let coriolis = Coriolis::new(&inertia, velocity);
            // B v is the velocity product force.
            self.forces[i] = inertia.apply(&self.accelerations[i]) + coriolis.apply(velocity);
            self.coriolis[i] = coriolis;
        }
        // From here on the accelerations become Psi''.
        let base = kinematics::base_acceleration(model);
        for (i, joint) in model.joints().iter().enumerate().rev() {
            let (axis, rate) = (self.axes[i], self.axis_rates[i]);
            self.accelerations[i] = match joint.parent() {
                Some(p) => self.accelerations[p].cross(&axis) + self.velocities[p].cross(&rate),
                None => base.cross(&axis),
            };
        }
        Ok(())
    }
}
