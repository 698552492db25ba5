//! The derivatives in the rate of the state, (B62) to (B70) and (B74) to (B77). Rows are those of the differentiated
//! quantity.

use super::{Quantities, of_blocks, scaled};
use crate::linalg::Tensor3;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::DMatrix;

/// The four blocks of $\Omega_i$ in the rate, (B62) to (B65), `2 N` by `2 N`.
impl<S: Scalar> Quantities<S> {
    /// (B62): $\frac{d\Omega_1}{d\dot x} = 2 \begin{bmatrix} 0 & -I \\\\ (H^T H)^{-1} \frac{\partial \gamma}{\partial
    /// \dot x_{P1}} & (H^T H)^{-1} \frac{\partial \gamma}{\partial \dot x_{P2}} \end{bmatrix}$.
    #[must_use]
    pub fn domega_1_dxdot(&self) -> DMatrix<S> {
        let by_p1 = self.solve_hth(self.dgamma_dxdot_p1());
        let by_p2 = self.solve_hth(self.dgamma_dxdot_p2());
        of_blocks([[self.zero(), -self.identity()], [by_p1, by_p2]]) * S::from_f64(2.0)
    }

    /// (B63): $\frac{d\Omega_2}{d\dot x} = \begin{bmatrix} 0 & \frac1k \frac{\partial \alpha_1}{\partial \dot x_{P2}}
    /// \\\\ 0 & (H^T H)^{-1} \frac{\partial \alpha_2}{\partial \dot x_{P2}} \end{bmatrix}$.
    #[must_use]
    pub fn domega_2_dxdot<C: Scalar>(&self, k: C) -> DMatrix<S>
    where
        S: AlgebraOver<C>,
    {
        let above = scaled(self.dalpha_1_dxdot_p2(), C::one() / k);
        let below = self.solve_hth(self.dalpha_2_dxdot_p2());
        of_blocks([[self.zero(), above], [self.zero(), below]])
    }

    /// (B64): $\frac{d\Omega_3}{d\dot x} = \begin{bmatrix} 0 & 0 \\\\ 2 k (H^T H)^{-1} & 0 \end{bmatrix}$.
    #[must_use]
    pub fn domega_3_dxdot<C: Scalar>(&self, k: C) -> DMatrix<S>
    where
        S: AlgebraOver<C>,
    {
        let below = scaled(self.solve_hth(self.identity()), k) * S::from_f64(2.0);
        of_blocks([[self.zero(), self.zero()], [below, self.zero()]])
    }

    /// (B65): $\frac{d\Omega_4}{d\dot x} = \begin{bmatrix} 0 & \frac2k \frac{\partial \Gamma}{\partial \dot x_{P2}}
    /// \\\\ 0 & 0 \end{bmatrix}$.
    #[must_use]
    pub fn domega_4_dxdot<C: Scalar>(&self, k: C) -> DMatrix<S>
    where
        S: AlgebraOver<C>,
    {
        let half = scaled(self.dcapital_gamma_dxdot_p2(), C::one() / k);
        let above = half * S::from_f64(2.0);
        of_blocks([[self.zero(), above], [self.zero(), self.zero()]])
    }
}

/// The parts of those blocks, (B66) to (B70) and (B74) to (B77).
impl<S: Scalar> Quantities<S> {
    /// (B66): $\frac{\partial \alpha_1}{\partial \dot x_{P2}} = -\frac{\partial FD_0}{\partial x_{P1}}^T 2 H^T H$.
    #[must_use]
    pub fn dalpha_1_dxdot_p2(&self) -> DMatrix<S> {
        -self.fd0.dq.tr_mul(&self.dgamma_dxddot_p2()) * S::from_f64(2.0)
    }

    /// (B67): $\frac{\partial \alpha_2}{\partial \dot x_{P2}} = -\frac{\partial FD_0}{\partial x_{P2}}^T 2 H^T H$.
    #[must_use]
    pub fn dalpha_2_dxdot_p2(&self) -> DMatrix<S> {
        -self.fd0.dv.tr_mul(&self.dgamma_dxddot_p2()) * S::from_f64(2.0)
    }

    /// (B68): $\frac{\partial \gamma}{\partial \dot x_{P1}} = \frac{\partial \dot H^T}{\partial \dot x_{P1}} (H \dot
    /// x_{P2} + C) + H^T \left( \frac{\partial \dot H}{\partial \dot x_{P1}} \dot x_{P2} + \frac{\partial \dot
    /// C}{\partial \dot x_{P1}} \right)$, not simplified.
    #[must_use]
    pub fn dgamma_dxdot_p1_unsimplified(&self) -> DMatrix<S> {
        let dhdot = self.dhdot_dxdot_p1();
        dhdot.times_first(&self.force())
            + (self.mass.h).tr_mul(&(dhdot.times_second(&self.xdot_p2) + self.dcdot_dxdot_p1()))
    }

    /// (B69): $\frac{\partial \gamma}{\partial \dot x_{P2}} = \dot H^T H + H^T \dot H + H^T \frac{\partial \dot
    /// C}{\partial \dot x_{P2}}$, not simplified.
    #[must_use]
    pub fn dgamma_dxdot_p2_unsimplified(&self) -> DMatrix<S> {
        let (h, hdot) = (&self.mass.h, &self.mass.hdot);
        (hdot.tr_mul(h) + h.tr_mul(hdot)) + h.tr_mul(self.dcdot_dxdot_p2())
    }

    /// (B70): $\frac{\partial \Gamma}{\partial \dot x_{P2}} = I \frac{\partial H}{\partial x_{P1}} H w + w^T
    /// \frac{\partial H}{\partial x_{P1}} H$ with $w = \dot x_{P2} - FD_0$; rows are the derivative index of the
    /// tensor, as in (B59).
    #[must_use]
    pub fn dcapital_gamma_dxdot_p2(&self) -> DMatrix<S> {
        let (h, dh, w) = (&self.mass.h, &self.mass.dq, self.w());
        dh.times_first(&(h * &w)).transpose() + dh.times_second(&w).tr_mul(h)
    }

    /// (B74): $\frac{\partial \dot H}{\partial \dot x_{P1}} = \frac{\partial H}{\partial x_{P1}}$, the last index that
    /// of the derivative.
    #[must_use]
    pub fn dhdot_dxdot_p1(&self) -> &Tensor3<S> {
        &self.mass.dq
    }

    /// (B75): $\frac{\partial \dot C}{\partial \dot x_{P1}} = \frac{\partial C}{\partial x_{P1}}$.
    #[must_use]
    pub fn dcdot_dxdot_p1(&self) -> &DMatrix<S> {
        &self.dc.dq
    }

    /// $\frac{\partial \dot C}{\partial \dot x_{P2}} = \frac{\partial C}{\partial x_{P2}}$, which follows from (B72) as
    /// (B75) does.
    #[must_use]
    pub fn dcdot_dxdot_p2(&self) -> &DMatrix<S> {
        &self.dc.dv
    }

    /// (B76): $\frac{\partial \gamma}{\partial \dot x_{P1}} = \frac{\partial H}{\partial x_{P1}} (H \dot x_{P2} + C) +
    /// H \left( \frac{\partial H}{\partial x_{P1}} \dot x_{P2} + \frac{\partial C}{\partial x_{P1}} \right)$; products
    /// with tensors sum over the second index. This is (B68) with (B73) to (B75).
    #[must_use]
    pub fn dgamma_dxdot_p1(&self) -> DMatrix<S> {
        let (h, dh) = (&self.mass.h, &self.mass.dq);
        dh.times_second(&self.force()) + h * (dh.times_second(&self.xdot_p2) + &self.dc.dq)
    }

    /// (B77): $\frac{\partial \gamma}{\partial \dot x_{P2}} = \dot H H + H \left( \dot H + \frac{\partial C}{\partial
    /// x_{P2}} \right)$.
    #[must_use]
    pub fn dgamma_dxdot_p2(&self) -> DMatrix<S> {
        let (h, hdot) = (&self.mass.h, &self.mass.hdot);
        hdot * h + h * (hdot + &self.dc.dv)
    }
}
