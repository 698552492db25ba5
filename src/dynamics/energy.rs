//! Kinetic and potential energy.

use super::{Data, forward_kinematics};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};

/// Computes the kinetic energy $\tfrac12 v^T H v$ of the moving bodies and the rotors of the drives, in J.
///
/// * `q`, `v`: `N` entries; rad or m, per s
///
/// # Errors
/// `q` or `v` does not have `N` entries, or `data` was made for another number of joints.
///
/// # Cost
/// O(N).
pub fn kinetic_energy<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
) -> Result<S> {
    data.place(model, q)?;
    data.add_velocities(model, v)?;
    let bodies = (data.inertias.iter().zip(&data.velocities)).fold(S::zero(), |sum, (i, v)| sum + v.dot(&i.apply(v)));
    let twice = (model.drives().iter().zip(v)).fold(bodies, |sum, (drive, v)| sum + (*v * *v).scale(drive.armature));
    Ok(twice * S::from_f64(0.5))
}

/// Computes the potential energy $-\sum m\\, g \cdot c$ of the moving bodies, in J, zero where the centres of mass are
/// at the height of the base.
///
/// * `q`: `N` entries, rad or m
///
/// # Errors
/// `q` does not have `N` entries, or `data` was made for another number of joints.
///
/// # Cost
/// O(N).
pub fn potential_energy<C: Scalar, S: AlgebraOver<C>>(model: &Model<C>, data: &mut Data<S>, q: &[S]) -> Result<S> {
    data.check(model)?;
    forward_kinematics(model, q, &mut data.placements)?;
    let mut energy = S::zero();
    for (inertia, placement) in model.inertias().iter().zip(&data.placements) {
        let moment = inertia.placed(placement).first_moment;
        for axis in 0..3 {
            energy -= moment[axis].scale(model.gravity()[axis]);
        }
    }
    Ok(energy)
}
