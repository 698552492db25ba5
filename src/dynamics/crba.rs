//! The mass matrix by the composite rigid body algorithm (Featherstone, 6.2, in base coordinates).

use super::{Data, clear_square, path_to_base};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::DMatrix;

/// Computes the mass matrix $H(q)$, with both its halves.
///
/// * `q`: `N` entries, rad or m
/// * `h`: `N` by `N`, overwritten
///
/// # Errors
/// `q` does not have `N` entries, `h` is not `N` by `N`, or `data` was made for another number of joints.
///
/// # Cost
/// O(N d), with d the depth of the tree, and O(N^2) to clear `h`; no allocation.
///
/// # Source
/// The composite rigid body algorithm, Featherstone, *Rigid Body Dynamics Algorithms*, 6.2.
pub fn crba<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    h: &mut DMatrix<S>,
) -> Result<()> {
    clear_square("h", model.dof(), h)?;
    data.place(model, q)?;
    for (i, joint) in model.joints().iter().enumerate().rev() {
        let momentum = data.inertias[i].apply(&data.axes[i]);
        for j in path_to_base(model, i) {
            h[(i, j)] = data.axes[j].dot(&momentum);
            h[(j, i)] = h[(i, j)];
        }
        if let Some(parent) = joint.parent() {
            let composite = data.inertias[i];
            data.inertias[parent] += composite;
        }
    }
    add_armature(model, h);
    Ok(())
}

/// Adds the rotor inertia of the joints to the diagonal of the mass matrix.
pub(super) fn add_armature<C: Scalar, S: AlgebraOver<C>>(model: &Model<C>, h: &mut DMatrix<S>) {
    for (i, drive) in model.drives().iter().enumerate() {
        h[(i, i)] += S::lift(drive.armature);
    }
}
