//! Analytic first derivatives of forward dynamics (ABA_D in the supplement).

use super::{Data, InverseDynamicsDerivatives, check_square};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{DMatrix, DVector};

/// Forward dynamics and its first derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct ForwardDynamicsDerivatives<S: Scalar> {
    /// $FD(q, v, \tau)$, `N` entries.
    pub a: DVector<S>,
    /// $\partial FD_i / \partial q_j$, `N` by `N`.
    pub dq: DMatrix<S>,
    /// $\partial FD_i / \partial v_j$, `N` by `N`.
    pub dv: DMatrix<S>,
    /// $\partial FD_i / \partial \tau_j = (H^{-1})_{ij}$, `N` by `N`.
    pub h_inverse: DMatrix<S>,
    inverse_dynamics: InverseDynamicsDerivatives<S>,
}

impl<S: Scalar> ForwardDynamicsDerivatives<S> {
    /// Allocates the results for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            a: DVector::zeros(n),
            dq: DMatrix::zeros(n, n),
            dv: DMatrix::zeros(n, n),
            h_inverse: DMatrix::zeros(n, n),
            inverse_dynamics: InverseDynamicsDerivatives::new(n),
        }
    }
}

/// Computes forward dynamics and its derivatives in all three arguments.
///
/// Differentiating $ID(q, v, FD(q, v, \tau)) = \tau$ gives $\partial FD / \partial q = -H^{-1}\\, \partial ID /
/// \partial q$ at $a = FD$, and likewise for `v`.
///
/// * `q`, `v`, `tau`: `N` entries; rad or m, per s; N m or N
/// * `out`: made for `N` joints, overwritten
///
/// # Errors
/// A slice does not have `N` entries, or `out` or `data` was made for another number of joints.
///
/// # Cost
/// O(N^2 d), with d the depth of the tree.
///
/// # Source
/// Carpentier and Mansard, "Analytical derivatives of rigid body dynamics algorithms", RSS 2018; line 5 of Algorithm B1
/// with `tau` zero.
pub fn aba_derivatives<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    out: &mut ForwardDynamicsDerivatives<S>,
) -> Result<()> {
    let n = model.dof();
    for (what, matrix) in [("dq", &out.dq), ("dv", &out.dv), ("h_inverse", &out.h_inverse)] {
        check_square(what, n, matrix)?;
    }
    model.check("tau", tau.len())?;
    model.check("a", out.a.len())?;
    let id = &mut out.inverse_dynamics;
    id.clear(model)?;
    data.place(model, q)?;
    data.add_velocities(model, v)?;
    data.accelerate(model, v, tau, out.a.as_mut_slice());
    data.invert_mass_matrix(model);
    let columns = out.h_inverse.as_mut_slice().chunks_exact_mut(n);
    for (column, tiles) in columns.zip(data.h_inverse.columns()) {
        column.copy_from_slice(&tiles.as_flattened()[..n]);
    }
    // Placements, velocities and accelerations are already those of inverse dynamics at `a`.
    data.differentiate_bodies(model);
    data.fill_derivatives(model, id);
    id.add_drive_derivatives(model, v);
    data.minus_h_inverse_times(model, [&id.dq, &id.dv], [&mut out.dq, &mut out.dv]);
    Ok(())
}
