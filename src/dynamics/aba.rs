//! Forward dynamics by the articulated-body algorithm (Featherstone, 7.3, in base coordinates).

use super::{Data, kinematics};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::ArticulatedInertia;

/// Computes forward dynamics $a = H^{-1} (\tau - C(q, v))$.
///
/// * `q`, `v`, `tau`: `N` entries; rad or m, per s; N m or N
/// * the accelerations: `N` entries, overwritten; rad or m, per s^2
///
/// # Errors
/// A slice does not have `N` entries, or `data` was made for another number of joints.
///
/// # Cost
/// O(N), no allocation.
///
/// # Source
/// The articulated-body algorithm, Featherstone, *Rigid Body Dynamics Algorithms*, 7.3.
pub fn aba<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    a: &mut [S],
) -> Result<()> {
    model.check("tau", tau.len())?;
    model.check("a", a.len())?;
    data.place(model, q)?;
    data.add_velocities(model, v)?;
    data.accelerate(model, v, tau, a);
    Ok(())
}

impl<S: Scalar> Data<S> {
    /// Accelerations `a` of the joints under the forces `tau`, and those of the bodies, after
    /// [`add_velocities`](Self::add_velocities). Leaves $U_i$ in `articulated_axes` and $D_i$ in `scalar_scratch`.
    pub(super) fn accelerate<C: Scalar>(&mut self, model: &Model<C>, v: &[S], tau: &[S], a: &mut [S])
    where
        S: AlgebraOver<C>,
    {
        for i in 0..model.dof() {
            let (inertia, velocity) = (&self.inertias[i], &self.velocities[i]);
            self.articulated[i] = ArticulatedInertia::new(inertia);
            self.forces[i] = velocity.cross_force(&inertia.apply(velocity));
        }
        // (7.19) to (7.24): U = I^A S, D = S^T U + I_a, u = tau - S^T p^A, less the losses of the drive.
        for (i, joint) in model.joints().iter().enumerate().rev() {
            let (axis, articulated, force) = (&self.axes[i], &self.articulated[i], self.forces[i]);
            let u_vector = articulated.apply(axis);
            let (mut d, mut u) = (axis.dot(&u_vector), tau[i] - axis.dot(&force));
            if let Some(drive) = model.drives().get(i) {
                let [losses, ..] = drive.losses(v[i]);
                d += S::lift(drive.armature);
                u -= losses;
            }
            if let Some(parent) = joint.parent() {
                let ratio = S::one() / d;
                let apparent = articulated.without(&u_vector, ratio);
                let velocity_product = apparent.apply(&(self.axis_rates[i] * v[i]));
                self.forces[parent] += force + velocity_product + u_vector * (u * ratio);
                self.articulated[parent] += apparent;
            }
            self.articulated_axes[i] = u_vector;
            self.scalar_scratch[i] = d;
            a[i] = u;
        }
        let base = kinematics::base_acceleration(model);
        for (i, joint) in model.joints().iter().enumerate() {
            let before = joint.parent().map_or(base, |p| self.accelerations[p]);
            let drifting = before + self.axis_rates[i] * v[i];
            a[i] = (a[i] - drifting.dot(&self.articulated_axes[i])) / self.scalar_scratch[i];
            self.accelerations[i] = drifting + self.axes[i] * a[i];
        }
    }
}
