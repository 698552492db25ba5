//! The velocity of a frame per joint velocity.

use super::{Data, forward_kinematics, frame_placement, path_to_base};
use crate::error::{Result, check_length};
use crate::model::{Frame, Model};
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::DMatrix;

/// The geometric Jacobian $J(q)$ of a frame, 6 by `N`: rows 0 to 2 of $J v$ are its angular velocity, rows 3 to 5 the velocity
/// of its origin, both along the axes of the base. Column $j$ is $[\omega_j;\\; v_j + \omega_j \times p]$ with
/// $S_j = [\omega_j; v_j]$ the axis of a joint that carries the frame and $p$ the origin of the frame, else zero. The frame of
/// the body of joint `i` is `Frame::new("", Some(i), Placement::identity())`.
///
/// It is what Pinocchio computes as `LOCAL_WORLD_ALIGNED`, whose rows are the linear ones first. Both parts turned by the
/// transpose of the rotation of [`frame_placement`] give `LOCAL`; the columns $S_j$ themselves, from
/// [`Joint::motion_subspace`](crate::model::Joint::motion_subspace), are those of `WORLD`. Cost O(N).
///
/// # Errors
/// `q` does not have one entry a joint, `jacobian` is not 6 by `N`, or the model has no body of the frame.
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
        jacobian
            .fixed_view_mut::<3, 1>(0, j)
            .copy_from(&axis.angular);
        jacobian.fixed_view_mut::<3, 1>(3, j).copy_from(&linear);
    }
    Ok(())
}
