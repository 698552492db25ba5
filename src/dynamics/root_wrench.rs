//! The wrench of the root: the force and the moment that hold the base, such as those of the ground on a foot.

use super::{Data, RneaWeightedHessian};
use crate::error::{Result, check_length};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Force, Motion};
use nalgebra::{DMatrix, Vector3};

/// The wrench of the root and its first derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct RootWrenchDerivatives<S: Scalar = f64> {
    /// The wrench `f`.
    pub wrench: Force<S>,
    /// $\left[ \frac{\partial f}{\partial q}\ \frac{\partial f}{\partial v}\ \frac{\partial f}{\partial a} \right]$,
    /// `6` by `3 N`, rows of the moment first.
    pub jacobian: DMatrix<S>,
}

impl<S: Scalar> RootWrenchDerivatives<S> {
    /// Allocates the results for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { wrench: Force::zero(), jacobian: DMatrix::zeros(6, 3 * n) }
    }
}

/// Computes the wrench of the root, in N m about the origin of the base frame and N: the sum of $I_b a_b +
/// v_b \times^* I_b v_b$ over all bodies with the [base](Model::base_inertia), where gravity is an acceleration of the
/// base. It is the force that the ground has to exert on a robot at rest on it, and that of the base row of a
/// floating-base model whose base does not move. The drives do not enter: their torques act between bodies, and a rotor
/// counts with its axis alone.
///
/// * `q`, `v`, `a`: `N` entries; rad or m, per s, per s^2
///
/// # Errors
/// A slice does not have `N` entries, or `data` was made for another number of joints.
///
/// # Cost
/// O(N), no allocation.
///
/// # Source
/// Featherstone, *Rigid Body Dynamics Algorithms*, 5.3: the backward pass, continued to the base.
pub fn root_wrench<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    v: &[S],
    a: &[S],
) -> Result<Force<S>> {
    data.place(model, q)?;
    data.add_velocities(model, v)?;
    data.add_accelerations(model, v, a)?;
    let mut wrench = weight_of_base(model);
    for i in 0..model.dof() {
        let (inertia, velocity) = (&data.inertias[i], &data.velocities[i]);
        wrench += inertia.apply(&data.accelerations[i]) + velocity.cross_force(&inertia.apply(velocity));
    }
    Ok(wrench)
}

/// Computes the wrench of the root with its first derivatives, and the Hessian of $m \cdot f$ for a motion `m` of the
/// base that depends on `f`.
///
/// The motion `m` acts like the velocities of six further joints at the root: it is the virtual velocity of the base in
/// the contraction of [`rnea_weighted_hessian`](super::rnea_weighted_hessian()), all other weights of which are zero.
///
/// * `q`, `v`, `a`: `N` entries; rad or m, per s, per s^2
/// * `weigh`: computes `m` from `f`
/// * `first`, `second`: made for `N` joints, overwritten
///
/// # Errors
/// A slice does not have `N` entries, or `first`, `second` or `data` was made for another number of joints.
///
/// # Cost
/// O(N d), with d the depth of the tree, and O(N^2) to clear the blocks.
pub fn root_wrench_second_order<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    [q, v, a]: [&[S]; 3],
    weigh: impl FnOnce(&Force<S>) -> Motion<S>,
    first: &mut RootWrenchDerivatives<S>,
    second: &mut RneaWeightedHessian<S>,
) -> Result<()> {
    let (n, jacobian) = (model.dof(), &mut first.jacobian);
    check_length("rows of jacobian", 6, jacobian.nrows())?;
    check_length("columns of jacobian", 3 * n, jacobian.ncols())?;
    second.clear(model)?;
    data.prepare_derivatives(model, q, v, a)?;
    data.sum_forces(model);
    first.wrench = weight_of_base(model);
    for (joint, force) in model.joints().iter().zip(&data.forces) {
        if joint.parent().is_none() {
            first.wrench += *force;
        }
    }
    let mut none = std::mem::take(&mut data.scalar_scratch);
    none.fill(S::zero());
    let contracted = data.contract(model, &none, weigh(&first.wrench));
    data.scalar_scratch = none;
    contracted?;
    // A joint moves its subtree alone, so that the change of the load on it is that of the wrench.
    data.sweep(model, second, |k, load, _| {
        for (x, force) in [&load.by_q, &load.by_v, &load.by_a].into_iter().enumerate() {
            let mut column = jacobian.column_mut(x * n + k);
            for (to, from) in column.iter_mut().zip(force.angular.iter().chain(&force.linear)) {
                *to = *from;
            }
        }
    });
    Ok(())
}

/// The force that holds the bodies fixed to the base.
fn weight_of_base<C: Scalar, S: AlgebraOver<C>>(model: &Model<C>) -> Force<S> {
    let lift = Motion::new(Vector3::zeros(), -*model.gravity());
    let weight = model.base_inertia().apply(&lift);
    Force::new(weight.angular.map(S::lift), weight.linear.map(S::lift))
}
