//! Forward dynamics by the articulated-body algorithm (Featherstone, 7.3, in base coordinates).

use super::{Data, kinematics};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Force, Motion};
use nalgebra::Vector6;

/// Forward dynamics $a = H^{-1} (\tau - C(q, v))$; arguments as in [`rnea`](super::rnea). Cost O(N).
///
/// # Errors
/// An argument does not have one entry a joint.
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
    for i in 0..model.dof() {
        let (inertia, velocity) = (&data.inertias[i], &data.velocities[i]);
        data.articulated[i] = inertia.to_matrix();
        data.forces[i] = velocity.cross_force(&inertia.apply(velocity));
    }
    // (7.19) to (7.24): U = I^A S, D = S^T U, u = tau - S^T p^A.
    for (i, joint) in model.joints().iter().enumerate().rev() {
        let axis = stack(&data.axes[i]);
        let u_vector = data.articulated[i] * axis;
        let d = axis.dot(&u_vector);
        let u = tau[i] - data.axes[i].dot(&data.forces[i]);
        if let Some(parent) = joint.parent() {
            let ratio = S::one() / d;
            let apparent = data.articulated[i] - u_vector * u_vector.transpose() * ratio;
            let velocity_product = stack(&data.axis_rates[i]) * v[i];
            let force = apparent * velocity_product + u_vector * (u * ratio);
            let force = data.forces[i]
                + Force::new(
                    force.fixed_rows::<3>(0).into_owned(),
                    force.fixed_rows::<3>(3).into_owned(),
                );
            data.forces[parent] += force;
            data.articulated[parent] += apparent;
        }
        data.articulated_axes[i] = u_vector;
        data.scalar_scratch[i] = d;
        a[i] = u;
    }
    let base = kinematics::base_acceleration(model);
    for (i, joint) in model.joints().iter().enumerate() {
        let before = joint.parent().map_or(base, |p| data.accelerations[p]);
        let drifting = before + data.axis_rates[i] * v[i];
        a[i] = (a[i] - data.articulated_axes[i].dot(&stack(&drifting))) / data.scalar_scratch[i];
        data.accelerations[i] = drifting + data.axes[i] * a[i];
    }
    Ok(())
}

/// The six coordinates of a motion.
fn stack<S: Scalar>(m: &Motion<S>) -> Vector6<S> {
    Vector6::new(
        m.angular.x,
        m.angular.y,
        m.angular.z,
        m.linear.x,
        m.linear.y,
        m.linear.z,
    )
}
