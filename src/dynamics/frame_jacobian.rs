//! The geometric Jacobian of a frame.

use super::{Data, forward_kinematics, frame_placement, path_to_base};
use crate::error::{Result, check_length};
use crate::model::{Frame, Model};
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::DMatrix;

/// Computes the geometric Jacobian $J(q)$ of a frame: rows 0 to 2 of $J v$ are its angular velocity, rows 3 to 5 the
/// velocity of its origin, both along the axes of the base.
///
/// Column $j$ is $[\omega_j;\\; v_j + \omega_j \times p]$ with $S_j = [\omega_j; v_j]$ the axis of a joint that carries
/// the frame and $p$ the origin of the frame, otherwise zero. The frame of the body of joint `i` is
/// `Frame::new("", Some(i), Placement::identity())`.
///
/// Pinocchio computes it as `LOCAL_WORLD_ALIGNED`, with the linear rows first. Both parts rotated by the transpose of
/// the rotation of [`frame_placement`] give `LOCAL`; the columns $S_j$ themselves, from
/// [`Joint::motion_subspace`](crate::model::Joint::motion_subspace), are those of `WORLD`.
///
/// * `q`: `N` entries, rad or m
/// * `jacobian`: 6 by `N`, overwritten
///
/// # Errors
/// `q` does not have `N` entries, `jacobian` is not 6 by `N`, `data` was made for another number of joints, or the
/// model has no body of the frame.
///
/// # Cost
/// O(N).
pub fn frame_jacobian<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    data: &mut Data<S>,
    q: &[S],
    frame: &Frame<C>,
    jacobian: &mut DMatrix<S>,
) -> Result<()> {
    data.check(model)?;
    check_length("rows of jacobian", 6, jacobian.nrows())?;
    model.check("columns of jacobian", jacobian.ncols())?;
    forward_kinematics(model, q, &mut data.placements)?;
    let origin = frame_placement(frame, &data.placements)?.translation;
    jacobian.fill(S::zero());
    for j in frame.body.into_iter().flat_map(|i| path_to_base(model, i)) {
        let axis = model.joints()[j].motion_subspace(&data.placements[j]);
        let linear = axis.linear + axis.angular.cross(&origin);
        jacobian.fixed_view_mut::<3, 1>(0, j).copy_from(&axis.angular);
        jacobian.fixed_view_mut::<3, 1>(3, j).copy_from(&linear);
    }
    Ok(())
}
