//! The mass matrix and its rate (CRBA_D in the supplement).

use super::crba::add_armature;
use super::{Data, clear_square, path_to_base};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Coriolis, Force};
use nalgebra::DMatrix;

/// Computes the mass matrix $H(q)$ and its rate $\dot H = \sum_k \partial H / \partial q_k\\, v_k$ along the velocity
/// `v`.
///
/// For `j` an ancestor of `i`, $H_{ij} = S_j^T I_i^C S_i$ with $I_i^C$ the inertia of the subtree of `i`; its rate
/// follows from $\dot S = v \times S$ and $\dot I = B + B^T$.
///
/// * `q`, `v`: `N` entries; rad or m, per s
/// * the results: `N` by `N`, overwritten
///
/// # Errors
/// `q` or `v` does not have `N` entries, a result is not `N` by `N`, or `data` was made for another number of joints.
///
/// # Cost
/// O(N d), with d the depth of the tree, and O(N^2) to clear the results.
///
/// # Source
/// Line 1 of Algorithm B1.
pub fn mass_matrix_and_rate<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    h: &mut DMatrix<S>,
    hdot: &mut DMatrix<S>,
) -> Result<()> {
    clear_square("h", model.dof(), h)?;
    clear_square("hdot", model.dof(), hdot)?;
    data.place(model, q)?;
    data.add_velocities(model, v)?;
    for i in 0..model.dof() {
        data.coriolis[i] = Coriolis::new(&data.inertias[i], &data.velocities[i]);
    }
    for (i, joint) in model.joints().iter().enumerate().rev() {
        let (axis, rate) = (data.axes[i], data.axis_rates[i]);
        let (inertia, coriolis) = (data.inertias[i], data.coriolis[i]);
        let momentum = inertia.apply(&axis);
        let momentum_rate =
            inertia.apply(&rate) + coriolis.apply(&axis) + Force::couple(coriolis.apply_transpose(&axis));
        for j in path_to_base(model, i) {
            h[(i, j)] = data.axes[j].dot(&momentum);
            h[(j, i)] = h[(i, j)];
            hdot[(i, j)] = data.axis_rates[j].dot(&momentum) + data.axes[j].dot(&momentum_rate);
            hdot[(j, i)] = hdot[(i, j)];
        }
        if let Some(parent) = joint.parent() {
            data.inertias[parent] += inertia;
            data.coriolis[parent] += coriolis;
        }
    }
    add_armature(model, h);
    Ok(())
}
