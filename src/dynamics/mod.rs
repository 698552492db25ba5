//! Rigid-body dynamics, one algorithm per file, written once for every [`Scalar`].
//!
//! All spatial vectors are in the coordinates of the base frame: a motion or a force keeps its coordinates from body to
//! body, so the recursions only add and subtract where the book transforms between link coordinates. Gravity enters as
//! an acceleration of the base (Featherstone, *Rigid Body Dynamics Algorithms*, 5.3).
//!
//! Every function takes the model, a [`Data`] for scratch, its arguments and its results. The scratch carries no state
//! from one call to the next. Functions allocate only where their documentation says so.
//!
//! Second derivatives come as explicit tensors, whose index convention [`Tensor3`](crate::linalg::Tensor3) and
//! [`Tensor4`](crate::linalg::Tensor4) share: a derivative index comes last.

mod aba;
mod aba_derivatives;
mod aba_second_derivatives;
mod bias_rate_derivatives;
mod crba;
mod crba_second_derivatives;
mod data;
mod energy;
mod frame_jacobian;
mod kinematics;
mod mass_matrix_and_rate;
mod mass_matrix_inverse;
mod mass_matrix_product_derivative;
mod mass_matrix_rate_derivatives;
mod rnea;
mod rnea_derivatives;
mod rnea_second_derivatives;
mod rnea_weighted;
mod root_wrench;

pub use aba::aba;
pub use aba_derivatives::{ForwardDynamicsDerivatives, aba_derivatives};
pub use aba_second_derivatives::{ForwardDynamicsSecondDerivatives, aba_second_derivatives};
pub use bias_rate_derivatives::{BiasRateDerivatives, bias_rate_derivatives};
pub use crba::crba;
pub use crba_second_derivatives::{MassMatrixDerivatives, crba_second_derivatives};
pub use data::Data;
pub use energy::{kinetic_energy, potential_energy};
pub use frame_jacobian::frame_jacobian;
pub use kinematics::{forward_kinematics, frame_placement};
pub use mass_matrix_and_rate::mass_matrix_and_rate;
pub use mass_matrix_product_derivative::mass_matrix_product_derivative;
pub use mass_matrix_rate_derivatives::mass_matrix_rate_derivatives;
pub use rnea::{bias, rnea};
pub use rnea_derivatives::{InverseDynamicsDerivatives, rnea_derivatives};
pub use rnea_second_derivatives::{InverseDynamicsSecondDerivatives, rnea_second_derivatives};
pub use rnea_weighted::{RneaVjp, RneaWeightedHessian, rnea_second_order, rnea_vjp, rnea_weighted_hessian};
pub use root_wrench::{RootWrenchDerivatives, root_wrench, root_wrench_second_order};

use crate::error::{Result, check_length};
use crate::model::Model;
use crate::scalar::Scalar;
use nalgebra::DMatrix;

/// Checks that a result is an `n` by `n` matrix.
pub(crate) fn check_square<S>(what: &'static str, n: usize, matrix: &DMatrix<S>) -> Result<()> {
    check_length(what, n, matrix.nrows())?;
    check_length(what, n, matrix.ncols())
}

/// Sets a result to zero, after a check that it is an `n` by `n` matrix.
fn clear_square<S: Scalar>(what: &'static str, n: usize, matrix: &mut DMatrix<S>) -> Result<()> {
    check_square(what, n, matrix)?;
    // `DMatrix::fill` is slower: it visits the entries one by one.
    matrix.as_mut_slice().fill(S::zero());
    Ok(())
}

/// Joint `from` and its ancestors, up to the base.
#[doc(hidden)]
#[inline]
pub fn path_to_base<C: Scalar>(model: &Model<C>, from: usize) -> impl Iterator<Item = usize> + '_ {
    std::iter::successors(Some(from), |i| model.joints()[*i].parent())
}
