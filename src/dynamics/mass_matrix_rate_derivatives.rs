//! The derivative of the rate of the mass matrix (get_Hdot_D in the supplement).

use crate::error::Result;
use crate::linalg::{Tensor3, Tensor4};
use crate::scalar::Scalar;

/// Computes the derivative of $\dot H = \sum_l \partial H / \partial q_l\\, \dot q_l$ in `q`,
///
/// $$ \frac{\partial \dot H_{ij}}{\partial q_k} =
///    \sum_l \frac{\partial^2 H_{ij}}{\partial q_k\\, \partial q_l} \dot q_l . $$
///
/// * `d2h`: $\partial^2 H / \partial q^2$, `N` by `N` by `N` by `N`
/// * `qdot`: `N` entries, per s
/// * `out`: `N` by `N` by `N`, overwritten
///
/// # Errors
/// `d2h` or `out` has another size than `qdot`.
///
/// # Cost
/// O(N^4).
///
/// # Source
/// Line 6 of Algorithm B2.
pub fn mass_matrix_rate_derivatives<S: Scalar>(d2h: &Tensor4<S>, qdot: &[S], out: &mut Tensor3<S>) -> Result<()> {
    d2h.check("d2h", qdot.len())?;
    out.check("out", qdot.len())?;
    d2h.times_fourth(qdot, out);
    Ok(())
}
