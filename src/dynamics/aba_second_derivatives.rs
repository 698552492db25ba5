//! Analytic second derivatives of forward dynamics (ABA_2D in the supplement).

use super::{ForwardDynamicsDerivatives, InverseDynamicsSecondDerivatives};
use crate::error::Result;
use crate::linalg::Tensor3;
use crate::scalar::Scalar;

/// The second derivatives of forward dynamics in the state, at constant force.
#[derive(Clone, Debug, PartialEq)]
pub struct ForwardDynamicsSecondDerivatives<S: Scalar> {
    /// $\partial^2 FD_i / (\partial q_j\\, \partial q_k)$.
    pub dqdq: Tensor3<S>,
    /// $\partial^2 FD_i / (\partial v_j\\, \partial v_k)$.
    pub dvdv: Tensor3<S>,
    /// $\partial^2 FD_i / (\partial q_j\\, \partial v_k)$.
    pub dqdv: Tensor3<S>,
}

impl<S: Scalar> ForwardDynamicsSecondDerivatives<S> {
    /// Allocates the results for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { dqdq: Tensor3::new(n), dvdv: Tensor3::new(n), dqdv: Tensor3::new(n) }
    }
}

/// Computes the second derivatives of forward dynamics from its first ones and the second ones of inverse dynamics.
///
/// Differentiating $ID(q, v, FD(q, v, \tau)) = \tau$ twice, with $\partial ID / \partial a = H$, gives
///
/// $$ -H FD_{qq,jk} = ID_{qq,jk} +
///    \frac{\partial H}{\partial q_j} FD_{q,k} + \frac{\partial H}{\partial q_k} FD_{q,j}, \quad
///    -H FD_{qv,jk} = ID_{qv,jk} + \frac{\partial H}{\partial q_j} FD_{v,k}, \quad -H FD_{vv} = ID_{vv}. $$
///
/// * `fd`: first derivatives of forward dynamics at $(q, v, \tau)$
/// * `id`: second derivatives of inverse dynamics at the acceleration $a = FD(q, v, \tau)$
/// * `out`: overwritten
///
/// # Errors
/// `id` or `out` was made for another number of joints than `fd`.
///
/// # Cost
/// O(N^4); it allocates.
///
/// # Source
/// Singh, Russell and Wensing, "On the second-order derivatives of rigid-body dynamics"; line 9 of Algorithm B2.
pub fn aba_second_derivatives<S: Scalar>(
    fd: &ForwardDynamicsDerivatives<S>,
    id: &InverseDynamicsSecondDerivatives<S>,
    out: &mut ForwardDynamicsSecondDerivatives<S>,
) -> Result<()> {
    let n = fd.a.len();
    for (what, tensor) in [
        ("second derivatives of inverse dynamics", &id.dqdq),
        ("dqdq", &out.dqdq),
        ("dvdv", &out.dvdv),
        ("dqdv", &out.dqdv),
    ] {
        tensor.check(what, n)?;
    }
    let minus_h_inverse = -&fd.h_inverse;
    // The second index belongs to FD, the third to the q in which H was differentiated.
    let by_q = id.dadq.map_second(&fd.dq);
    let by_v = id.dadq.map_second(&fd.dv);
    let qq = by_q.swap_last() + &by_q + &id.dqdq;
    out.dqdq = qq.map_first(&minus_h_inverse);
    out.dqdv = (by_v.swap_last() + &id.dqdv).map_first(&minus_h_inverse);
    out.dvdv = id.dvdv.map_first(&minus_h_inverse);
    Ok(())
}
