//! Analytic first derivatives of inverse dynamics (RNEA_D in the supplement).
//!
//! The formulas are those of Singh, Russell and Wensing, "Efficient analytical derivatives of rigid-body dynamics using
//! spatial vector algebra" (IEEE RA-L 2022). Joints have one degree of freedom here, so $S_j \times S_j = 0$ and the
//! paper's $\dot\Psi_j = v_{\lambda(j)} \times S_j$ and $\dot S_j = v_j \times S_j$ are the same.

use super::crba::add_armature;
use super::{Data, clear_square, kinematics, path_to_base, rnea};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Coriolis, Force, dot};
use nalgebra::{DMatrix, DVector};

/// Inverse dynamics and its first derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseDynamicsDerivatives<S: Scalar = f64> {
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
    /// Allocates the results for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { tau: DVector::zeros(n), dq: DMatrix::zeros(n, n), dv: DMatrix::zeros(n, n), h: DMatrix::zeros(n, n) }
    }

    /// Sets the matrices to zero, after a check of their sizes.
    pub(super) fn clear<C: Scalar>(&mut self, model: &Model<C>) -> Result<()> {
        model.check("tau", self.tau.len())?;
        for (what, matrix) in [("dq", &mut self.dq), ("dv", &mut self.dv), ("h", &mut self.h)] {
            clear_square(what, model.dof(), matrix)?;
        }
        Ok(())
    }

    /// Adds the derivatives of the forces for the drives of the joints, which are diagonal, to those of rigid bodies.
    pub(super) fn add_drive_derivatives<C: Scalar>(&mut self, model: &Model<C>, v: &[S])
    where
        S: AlgebraOver<C>,
    {
        for (i, drive) in model.drives().iter().enumerate() {
            let [_, slope, _] = drive.losses(v[i]);
            self.dv[(i, i)] += slope;
        }
        add_armature(model, &mut self.h);
    }
}

/// Computes inverse dynamics and its derivatives in all three arguments.
///
/// * `q`, `v`, `a`: `N` entries; rad or m, per s, per s^2
/// * `out`: made for `N` joints, overwritten
///
/// # Errors
/// A slice does not have `N` entries, or `out` or `data` was made for another number of joints.
///
/// # Cost
/// O(N d), with d the depth of the tree, and O(N^2) to clear the matrices.
///
/// # Source
/// Singh, Russell and Wensing, "Efficient analytical derivatives of rigid-body dynamics using spatial vector algebra",
/// IEEE RA-L 2022; line 3 of Algorithm B1 with `a` zero.
pub fn rnea_derivatives<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    out: &mut InverseDynamicsDerivatives<S>,
) -> Result<()> {
    out.clear(model)?;
    data.prepare_derivatives(model, q, v, a)?;
    data.fill_derivatives(model, out);
    rnea::add_drives(model, v, a, out.tau.as_mut_slice());
    out.add_drive_derivatives(model, v);
    Ok(())
}

/// Derivatives of the subtree force in joint `i`, projected on each ancestor's axis to fill row and column `i`.
pub(super) struct SubtreeForceDerivatives<S: Scalar> {
    pub by_q: Force<S>,
    pub by_v: Force<S>,
    pub by_a: Force<S>,
}

impl<S: Scalar> SubtreeForceDerivatives<S> {
    /// Fills the entries of the derivatives for joint `i` and its ancestors; `self` is the load on joint `i`.
    pub fn fill_row_and_column<C: Scalar>(
        &self,
        model: &Model<C>,
        data: &Data<S>,
        i: usize,
        out: &mut InverseDynamicsDerivatives<S>,
    ) {
        let two = S::from_f64(2.0);
        // The derivatives of the torque of joint i in the coordinates of the joints before it.
        let eta = data.coriolis[i].apply_transpose(&data.axes[i]) * two;
        for j in path_to_base(model, i) {
            let (axis_j, rate_j) = (&data.axes[j], &data.axis_rates[j]);
            out.h[(j, i)] = axis_j.dot(&self.by_a);
            out.h[(i, j)] = out.h[(j, i)];
            out.dv[(j, i)] = axis_j.dot(&self.by_v);
            out.dv[(i, j)] = dot(&axis_j.angular, &eta) + rate_j.dot(&self.by_a) * two;
            out.dq[(j, i)] = axis_j.dot(&self.by_q);
            out.dq[(i, j)] = dot(&rate_j.angular, &eta) + data.psi_ddot[j].dot(&self.by_a);
        }
    }
}

impl<S: Scalar> Data<S> {
    /// The terms of the derivatives of inverse dynamics: the axes $S$ and their rates, the inertias, Coriolis matrices
    /// and forces of the bodies, and in `psi_ddot`
    /// $\ddot\Psi_i = a_{\lambda(i)} \times S_i + v_{\lambda(i)} \times \dot \Psi_i$ for each joint.
    pub(super) fn prepare_derivatives<C: Scalar>(&mut self, model: &Model<C>, q: &[S], v: &[S], a: &[S]) -> Result<()>
    where
        S: AlgebraOver<C>,
    {
        self.place(model, q)?;
        self.add_velocities(model, v)?;
        self.add_accelerations(model, v, a)?;
        self.differentiate_bodies(model);
        Ok(())
    }

    /// Performs [`prepare_derivatives`](Self::prepare_derivatives) for known placements, velocities and accelerations.
    pub(super) fn differentiate_bodies<C: Scalar>(&mut self, model: &Model<C>)
    where
        S: AlgebraOver<C>,
    {
        for i in 0..model.dof() {
            let (inertia, velocity) = (self.inertias[i], &self.velocities[i]);
            let coriolis = Coriolis::new(&inertia, velocity);
            // B v is the velocity product force.
            self.forces[i] = inertia.apply(&self.accelerations[i]) + coriolis.apply(velocity);
            self.coriolis[i] = coriolis;
        }
        let base = kinematics::base_acceleration(model);
        for (i, joint) in model.joints().iter().enumerate() {
            let (axis, rate) = (self.axes[i], self.axis_rates[i]);
            self.psi_ddot[i] = match joint.parent() {
                Some(p) => self.accelerations[p].cross(&axis) + self.velocities[p].cross(&rate),
                None => base.cross(&axis),
            };
        }
    }

    /// Inverse dynamics and its derivatives, after [`prepare_derivatives`](Self::prepare_derivatives), into matrices
    /// that are zero; without the drives.
    pub(super) fn fill_derivatives<C: Scalar>(&mut self, model: &Model<C>, out: &mut InverseDynamicsDerivatives<S>) {
        self.sum_forces(model);
        self.read_torques(&mut out.tau);
        for (i, joint) in model.joints().iter().enumerate().rev() {
            self.push(i).fill_row_and_column(model, self, i, out);
            if let Some(parent) = joint.parent() {
                self.add_to_subtree(i, parent);
            }
        }
    }

    /// Sums the forces on the bodies over their subtrees.
    pub(super) fn sum_forces<C: Scalar>(&mut self, model: &Model<C>) {
        for (i, joint) in model.joints().iter().enumerate().rev() {
            if let Some(parent) = joint.parent() {
                let force = self.forces[i];
                self.forces[parent] += force;
            }
        }
    }

    /// $\tau_i = S_i \cdot F_i$ with the force `F_i` on the subtree of joint `i`.
    pub(super) fn read_torques(&self, tau: &mut DVector<S>) {
        for ((tau, axis), force) in tau.iter_mut().zip(&self.axes).zip(&self.forces) {
            *tau = axis.dot(force);
        }
    }

    /// Adds inertia and Coriolis matrix of the subtree of joint `i` to those of its parent.
    pub(super) fn add_to_subtree(&mut self, i: usize, parent: usize) {
        let (inertia, coriolis) = (self.inertias[i], self.coriolis[i]);
        self.inertias[parent] += inertia;
        self.coriolis[parent] += coriolis;
    }

    /// The load on joint `i`: inertias, Coriolis matrices and forces of the subtree of `i`.
    #[inline]
    pub(super) fn push(&self, i: usize) -> SubtreeForceDerivatives<S> {
        let (axis, rate, psi_ddot) = (&self.axes[i], &self.axis_rates[i], &self.psi_ddot[i]);
        let (inertia, coriolis, force) = (&self.inertias[i], &self.coriolis[i], &self.forces[i]);
        let two = S::from_f64(2.0);
        SubtreeForceDerivatives {
            by_q: coriolis.apply(rate) * two + inertia.apply(psi_ddot) + axis.cross_force(force),
            by_v: (coriolis.apply(axis) + inertia.apply(rate)) * two,
            by_a: inertia.apply(axis),
        }
    }
}
