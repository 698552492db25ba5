//! The derivatives of the rate of the bias force (get_Cdot_D in the supplement).

use super::{InverseDynamicsSecondDerivatives, check_square};
use crate::error::{Result, check_length};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

/// The derivatives of $\dot C$ in the state.
#[derive(Clone, Debug, PartialEq)]
pub struct BiasRateDerivatives<S: Scalar> {
    /// $\partial \dot C_i / \partial q_j$, `N` by `N`.
    pub dq: DMatrix<S>,
    /// $\partial \dot C_i / \partial v_j$, `N` by `N`.
    pub dv: DMatrix<S>,
}

impl<S: Scalar> BiasRateDerivatives<S> {
    /// Allocates the results for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { dq: DMatrix::zeros(n, n), dv: DMatrix::zeros(n, n) }
    }
}

/// Computes the derivatives in `q` and `v` of $\dot C = \frac{\partial C}{\partial q} \dot q + \frac{\partial
/// C}{\partial v} \dot v$ (B72), at constant rates $\dot q$ and $\dot v$:
///
/// $$ \frac{\partial \dot C_i}{\partial q_k} = \sum_j
///    \left( \frac{\partial^2 C_i}{\partial q_j \partial q_k} \dot q_j +
///    \frac{\partial^2 C_i}{\partial q_k \partial v_j} \dot v_j \right), \qquad
///    \frac{\partial \dot C_i}{\partial v_k} = \sum_j
///    \left( \frac{\partial^2 C_i}{\partial q_j \partial v_k} \dot q_j +
///    \frac{\partial^2 C_i}{\partial v_j \partial v_k} \dot v_j \right). $$
///
/// * `d2c`: second derivatives of inverse dynamics at zero acceleration
/// * `qdot`, `vdot`: `N` entries
/// * `out`: overwritten
///
/// # Errors
/// `vdot`, `d2c` or `out` has another size than `qdot`.
///
/// # Cost
/// O(N^3); it allocates.
///
/// # Source
/// Line 10 of Algorithm B2.
pub fn bias_rate_derivatives<S: Scalar>(
    d2c: &InverseDynamicsSecondDerivatives<S>,
    qdot: &DVector<S>,
    vdot: &DVector<S>,
    out: &mut BiasRateDerivatives<S>,
) -> Result<()> {
    let n = qdot.len();
    check_length("vdot", n, vdot.len())?;
    d2c.dqdq.check("second derivatives of the bias", n)?;
    check_square("dq", n, &out.dq)?;
    check_square("dv", n, &out.dv)?;
    out.dq = d2c.dqdq.times_second(qdot) + d2c.dqdv.times_third(vdot);
    out.dv = d2c.dqdv.times_second(qdot) + d2c.dvdv.times_second(vdot);
    Ok(())
}
