//! The derivative of the mass matrix, contracted with a vector.

use super::{Data, clear_square, path_to_base};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::Motion;
use nalgebra::DMatrix;

/// Computes $K_{ij} = \sum_k \frac{\partial H_{ik}}{\partial q_j} w_k$, the derivative of $H(q)\\, w$ in `q` for a
/// constant `w`.
///
/// With `w` in the place of joint velocities the bodies have virtual velocities $\mu$ and momenta $I \mu$. Joint `k`
/// moves its subtree as one body and adds $\mu_{\lambda(k)} \times S_k$ to the virtual velocities there, the only term
/// to differentiate.
///
/// * `q`, `w`: `N` entries
/// * `k`: `N` by `N`, overwritten
///
/// # Errors
/// `q` or `w` does not have `N` entries, `k` is not `N` by `N`, or `data` was made for another number of joints.
///
/// # Cost
/// O(N d), with d the depth of the tree, and O(N^2) to clear `k`.
///
/// # Source
/// The product of line 8 of Algorithm B1, which the paper computes by RNEA_D.
pub fn mass_matrix_product_derivative<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    w: &[S],
    k: &mut DMatrix<S>,
) -> Result<()> {
    clear_square("k", model.dof(), k)?;
    data.place(model, q)?;
    data.add_virtual_velocities(model, w, Motion::zero())?;
    for (i, joint) in model.joints().iter().enumerate().rev() {
        let (axis, gained) = (data.axes[i], data.virtual_axis_rates[i]);
        let (inertia, momentum) = (data.inertias[i], data.virtual_momenta[i]);
        let by_a = inertia.apply(&axis);
        let momentum_by_q = axis.cross_force(&momentum) + inertia.apply(&gained);
        for j in path_to_base(model, i) {
            k[(i, j)] = data.virtual_axis_rates[j].dot(&by_a);
            k[(j, i)] = data.axes[j].dot(&momentum_by_q);
        }
        if let Some(parent) = joint.parent() {
            data.inertias[parent] += inertia;
            data.virtual_momenta[parent] += momentum;
        }
    }
    Ok(())
}

impl<S: Scalar> Data<S> {
    /// Virtual velocities $\mu$, momenta and the motions $\mu_{\lambda(i)} \times S_i$ for the weights `w` and the
    /// virtual velocity `base` of the base, after [`place`](Self::place).
    pub(super) fn add_virtual_velocities<C: Scalar>(
        &mut self,
        model: &Model<C>,
        w: &[S],
        base: Motion<S>,
    ) -> Result<()> {
        model.check("w", w.len())?;
        for (i, joint) in model.joints().iter().enumerate() {
            let own = self.axes[i] * w[i];
            self.virtual_velocities[i] = match joint.parent() {
                Some(parent) => self.virtual_velocities[parent] + own,
                None => base + own,
            };
            // The joint's own virtual velocity is parallel to its axis and drops out of the product.
            self.virtual_axis_rates[i] = self.virtual_velocities[i].cross(&self.axes[i]);
            self.virtual_momenta[i] = self.inertias[i].apply(&self.virtual_velocities[i]);
        }
        Ok(())
    }
}
