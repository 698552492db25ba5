//! Inverse dynamics by the recursive Newton-Euler algorithm (Featherstone, 5.3, in base coordinates).

use super::Data;
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};

/// Computes inverse dynamics $\tau = H(q)\\, a + C(q, v)$, equation (1) of the paper: the forces that make the joints
/// accelerate by `a`. `C` holds Coriolis, centrifugal and gravity forces and the losses of the
/// [drives](crate::model::Drive), and `H` the inertia of their rotors.
///
/// * `q`, `v`, `a`: `N` entries; rad or m, per s, per s^2
/// * `tau`: `N` entries, overwritten; N m or N
///
/// # Errors
/// A slice does not have `N` entries, or `data` was made for another number of joints.
///
/// # Cost
/// O(N), no allocation.
///
/// # Source
/// Featherstone, *Rigid Body Dynamics Algorithms*, 5.3.
pub fn rnea<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    tau: &mut [S],
) -> Result<()> {
    model.check("tau", tau.len())?;
    data.place(model, q)?;
    data.add_velocities(model, v)?;
    data.add_accelerations(model, v, a)?;
    for i in 0..model.dof() {
        let (inertia, velocity) = (&data.inertias[i], &data.velocities[i]);
        data.forces[i] = inertia.apply(&data.accelerations[i]) + velocity.cross_force(&inertia.apply(velocity));
    }
    for (i, joint) in model.joints().iter().enumerate().rev() {
        tau[i] = data.axes[i].dot(&data.forces[i]);
        if let Some(parent) = joint.parent() {
            let force = data.forces[i];
            data.forces[parent] += force;
        }
    }
    add_drives(model, v, a, tau);
    Ok(())
}

/// Adds the forces for the drives of the joints to `tau`.
pub(super) fn add_drives<C: Scalar, S: AlgebraOver<C>>(model: &Model<C>, v: &[S], a: &[S], tau: &mut [S]) {
    for (i, drive) in model.drives().iter().enumerate() {
        let [losses, ..] = drive.losses(v[i]);
        tau[i] += losses + a[i].scale(drive.armature);
    }
}

/// Computes the bias force $C(q, v)$, inverse dynamics at zero acceleration; line 2 of Algorithm B1.
///
/// * `q`, `v`: `N` entries; rad or m, per s
/// * the result: `N` entries, overwritten; N m or N
///
/// # Errors
/// A slice does not have `N` entries, or `data` was made for another number of joints.
///
/// # Cost
/// O(N), no allocation.
pub fn bias<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    c: &mut [S],
) -> Result<()> {
    data.check(model)?;
    // The zeros are borrowed from the scratch, which `rnea` does not read.
    let mut zeros = std::mem::take(&mut data.scalar_scratch);
    zeros.fill(S::zero());
    let result = rnea(model, data, q, v, &zeros, c);
    data.scalar_scratch = zeros;
    result
}
