//! The vectors of the right-hand side, (B49) to (B52). `N` entries each.

use super::Quantities;
use crate::scalar::Scalar;
use nalgebra::DVector;

impl<S: Scalar> Quantities<S> {
    /// (B49): $\gamma = (\dot H^T H + H^T \dot H) \dot x_{P2} + H^T H \ddot x_{P2} + \dot H^T C + H^T \dot C$.
    #[must_use]
    pub fn gamma(&self) -> DVector<S> {
        let (h, hdot) = (&self.mass.h, &self.mass.hdot);
        hdot.tr_mul(&self.force()) + h.tr_mul(&self.force_rate())
    }

    /// (B50): $\alpha_1 = -\frac{\partial FD_0}{\partial x_{P1}}^T H^T (2 C + 2 H \dot x_{P2})$.
    #[must_use]
    pub fn alpha_1(&self) -> DVector<S> {
        -self.fd0.dq.tr_mul(&self.twice_ht_force())
    }

    /// (B51): $\alpha_2 = -\frac{\partial FD_0}{\partial x_{P2}}^T H^T (2 C + 2 H \dot x_{P2})$.
    #[must_use]
    pub fn alpha_2(&self) -> DVector<S> {
        -self.fd0.dv.tr_mul(&self.twice_ht_force())
    }

    /// (B52): $\Gamma = w^T \frac{\partial H^T}{\partial x_{P1}} H w$ with $w = \dot x_{P2} - FD_0$; entry `k` is
    /// $\sum_{ij} w_j\\, \partial H_{ij} / \partial q_k\\, (H w)_i$.
    #[must_use]
    pub fn capital_gamma(&self) -> DVector<S> {
        let w = self.w();
        self.mass.dq.times_second(&w).tr_mul(&(&self.mass.h * w))
    }

    /// $w = \dot x_{P2} - FD_0$.
    pub(super) fn w(&self) -> DVector<S> {
        &self.xdot_p2 - &self.fd0.a
    }

    /// $\dot x_{P1} - x_{P2}$.
    pub(super) fn slip(&self) -> DVector<S> {
        &self.xdot_p1 - &self.x_p2
    }

    /// $H \dot x_{P2} + C$.
    pub(super) fn force(&self) -> DVector<S> {
        &self.mass.h * &self.xdot_p2 + &self.c
    }

    /// $\dot H \dot x_{P2} + H \ddot x_{P2} + \dot C$, the rate of [`force`](Self::force).
    pub(super) fn force_rate(&self) -> DVector<S> {
        &self.mass.hdot * &self.xdot_p2 + &self.mass.h * &self.xddot_p2 + &self.cdot
    }

    /// $H^T (2 C + 2 H \dot x_{P2})$.
    pub(super) fn twice_ht_force(&self) -> DVector<S> {
        let half = self.mass.h.tr_mul(&self.force());
        &half + &half
    }
}
