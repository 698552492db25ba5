//! The derivatives in the state, (B45) to (B48) and (B53) to (B60).
//!
//! Rows are those of the differentiated quantity, columns those of the state. For each product with a tensor in the
//! supplement, the docstring gives the index of the sum.

use super::{Quantities, of_blocks, scaled};
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::DMatrix;

/// The four blocks of $\Omega_i$ in the state, (B45) to (B48), `2 N` by `2 N`.
impl<S: Scalar> Quantities<S> {
    /// (B45): $\frac{d\Omega_1}{dx} = 2 \begin{bmatrix} 0 & 0 \\\\ \frac{\partial (H^T H)^{-1}}{\partial x_{P1}}
    /// \gamma + (H^T H)^{-1} \frac{\partial \gamma}{\partial x_{P1}} & (H^T H)^{-1} \frac{\partial \gamma}{\partial
    /// x_{P2}} \end{bmatrix}$.
    #[must_use]
    pub fn domega_1_dx(&self) -> DMatrix<S> {
        let by_p1 = self.dhth_inverse_dx_p1(&self.gamma()) + self.solve_hth(self.dgamma_dx_p1());
        let by_p2 = self.solve_hth(self.dgamma_dx_p2());
        of_blocks([[self.zero(), self.zero()], [by_p1, by_p2]]) * S::from_f64(2.0)
    }

    /// (B46): $\frac{d\Omega_2}{dx} = \begin{bmatrix} \frac1k \frac{\partial \alpha_1}{\partial x_{P1}} & \frac1k
    /// \frac{\partial \alpha_1}{\partial x_{P2}} \\\\ \frac{\partial (H^T H)^{-1}}{\partial x_{P1}} \alpha_2 + (H^T
    /// H)^{-1} \frac{\partial \alpha_2}{\partial x_{P1}} & (H^T H)^{-1} \frac{\partial \alpha_2}{\partial x_{P2}}
    /// \end{bmatrix}$.
    #[must_use]
    pub fn domega_2_dx<C: Scalar>(&self, k: C) -> DMatrix<S>
    where
        S: AlgebraOver<C>,
    {
        let per_k = C::one() / k;
        let by_p1 = self.dhth_inverse_dx_p1(&self.alpha_2()) + self.solve_hth(self.dalpha_2_dx_p1());
        let by_p2 = self.solve_hth(self.dalpha_2_dx_p2());
        let (alpha_1_p1, alpha_1_p2) = (self.dalpha_1_dx_p1(), self.dalpha_1_dx_p2());
        of_blocks([[scaled(alpha_1_p1, per_k), scaled(alpha_1_p2, per_k)], [by_p1, by_p2]])
    }

    /// (B47): $\frac{d\Omega_3}{dx} = 2 k \begin{bmatrix} 0 & 0 \\\\ \frac{\partial (H^T H)^{-1}}{\partial x_{P1}}
    /// (\dot x_{P1} - x_{P2}) & -(H^T H)^{-1} \end{bmatrix}$.
    #[must_use]
    pub fn domega_3_dx<C: Scalar>(&self, k: C) -> DMatrix<S>
    where
        S: AlgebraOver<C>,
    {
        let by_p1 = self.dhth_inverse_dx_p1(&self.slip());
        let by_p2 = -self.solve_hth(self.identity());
        let half = of_blocks([[self.zero(), self.zero()], [by_p1, by_p2]]);
        scaled(half, k) * S::from_f64(2.0)
    }

    /// (B48): $\frac{d\Omega_4}{dx} = \begin{bmatrix} \frac2k \frac{\partial \Gamma}{\partial x_{P1}} & \frac2k
    /// \frac{\partial \Gamma}{\partial x_{P2}} \\\\ 0 & 0 \end{bmatrix}$.
    #[must_use]
    pub fn domega_4_dx<C: Scalar>(&self, k: C) -> DMatrix<S>
    where
        S: AlgebraOver<C>,
    {
        let (by_p1, by_p2) = (self.dcapital_gamma_dx_p1(), self.dcapital_gamma_dx_p2());
        let half = of_blocks([[by_p1, by_p2], [self.zero(), self.zero()]]);
        scaled(half, C::one() / k) * S::from_f64(2.0)
    }
}

/// The parts of those blocks, (B53) to (B60), `N` by `N`.
impl<S: Scalar> Quantities<S> {
    /// (B53): $\frac{\partial \gamma}{\partial x_{P1}} = \frac{\partial \dot H^T}{\partial x_{P1}} (H \dot x_{P2} +
    /// C) + \dot H^T \left( \frac{\partial H}{\partial x_{P1}} \dot x_{P2} + \frac{\partial C}{\partial x_{P1}}
    /// \right) + \frac{\partial H^T}{\partial x_{P1}} (\dot H \dot x_{P2} + H \ddot x_{P2} + \dot C) + H^T \left(
    /// \frac{\partial \dot H}{\partial x_{P1}} \dot x_{P2} + \frac{\partial H}{\partial x_{P1}} \ddot x_{P2} +
    /// \frac{\partial \dot C}{\partial x_{P1}} \right)$.
    ///
    /// Products sum over the second index of a tensor, over the first where the matrix in it is transposed.
    #[must_use]
    pub fn dgamma_dx_p1(&self) -> DMatrix<S> {
        let (h, hdot, dh, dhdot) = (&self.mass.h, &self.mass.hdot, &self.mass.dq, &self.dhdot);
        let (vdot, vddot) = (&self.xdot_p2, &self.xddot_p2);
        dhdot.times_first(&self.force())
            + hdot.tr_mul(&(dh.times_second(vdot) + &self.dc.dq))
            + dh.times_first(&self.force_rate())
            + h.tr_mul(&(dhdot.times_second(vdot) + dh.times_second(vddot) + &self.dcdot.dq))
    }

    /// (B54): $\frac{\partial \gamma}{\partial x_{P2}} = \dot H^T \frac{\partial C}{\partial x_{P2}} + H^T
    /// \frac{\partial \dot C}{\partial x_{P2}}$.
    #[must_use]
    pub fn dgamma_dx_p2(&self) -> DMatrix<S> {
        self.mass.hdot.tr_mul(&self.dc.dv) + self.mass.h.tr_mul(&self.dcdot.dv)
    }

    /// (B55): $\frac{\partial \alpha_1}{\partial x_{P1}} = \frac{d}{dx_{P1}} \left( -\frac{\partial FD_0}{\partial
    /// x_{P1}}^T \right) H^T (2 C + 2 H \dot x_{P2}) - \frac{\partial FD_0}{\partial x_{P1}}^T \left( \frac{\partial
    /// H^T}{\partial x_{P1}} (2 C + 2 H \dot x_{P2}) + H \left( 2 \frac{\partial C}{\partial x_{P1}} + 2 \frac{\partial
    /// H}{\partial x_{P1}} \dot x_{P2} \right) \right)$.
    ///
    /// The product with the second derivative sums over the index of $FD_0$, its first.
    #[must_use]
    pub fn dalpha_1_dx_p1(&self) -> DMatrix<S> {
        let first = self.d2fd0.dqdq.times_first(&self.twice_ht_force());
        -first - self.fd0.dq.tr_mul(&self.dtwice_ht_force_dx_p1())
    }

    /// (B56): $\frac{\partial \alpha_2}{\partial x_{P1}}$, as (B55) with $\frac{\partial FD_0}{\partial x_{P2}}$ for
    /// $\frac{\partial FD_0}{\partial x_{P1}}$.
    ///
    /// Rows belong to $x_{P2}$ and columns to $x_{P1}$, so the mixed derivative of $FD_0$, whose second index is that
    /// of $x_{P1}$, enters transposed.
    #[must_use]
    pub fn dalpha_2_dx_p1(&self) -> DMatrix<S> {
        let first = self.d2fd0.dqdv.times_first(&self.twice_ht_force());
        -first.transpose() - self.fd0.dv.tr_mul(&self.dtwice_ht_force_dx_p1())
    }

    /// (B57): $\frac{\partial \alpha_1}{\partial x_{P2}} = \frac{d}{dx_{P2}} \left( -\frac{\partial FD_0}{\partial
    /// x_{P1}}^T \right) H^T (2 C + 2 H \dot x_{P2}) - \frac{\partial FD_0}{\partial x_{P1}}^T 2 H \frac{\partial
    /// C}{\partial x_{P2}}$.
    #[must_use]
    pub fn dalpha_1_dx_p2(&self) -> DMatrix<S> {
        let first = self.d2fd0.dqdv.times_first(&self.twice_ht_force());
        -first - self.fd0.dq.tr_mul(&self.dtwice_ht_force_dx_p2())
    }

    /// (B58): $\frac{\partial \alpha_2}{\partial x_{P2}}$, as (B57) with $\frac{\partial FD_0}{\partial x_{P2}}$ for
    /// $\frac{\partial FD_0}{\partial x_{P1}}$.
    #[must_use]
    pub fn dalpha_2_dx_p2(&self) -> DMatrix<S> {
        let first = self.d2fd0.dvdv.times_first(&self.twice_ht_force());
        -first - self.fd0.dv.tr_mul(&self.dtwice_ht_force_dx_p2())
    }

    /// (B59): $\frac{\partial \Gamma}{\partial x_{P1}} = \left( -\frac{\partial FD_0}{\partial x_{P1}}^T \frac{\partial
    /// H}{\partial x_{P1}} + w^T \frac{\partial^2 H}{\partial x_{P1}^2} \right) H w + w^T \frac{\partial H}{\partial
    /// x_{P1}} \left( \frac{\partial H}{\partial x_{P1}} w - H \frac{\partial FD_0}{\partial x_{P1}} \right)$ with $w =
    /// \dot x_{P2} - FD_0$.
    ///
    /// `H w` sums over the first index, `w` and $FD_0$ over the second. Rows are the derivative index of the tensor on
    /// the left and columns those of $FD_0$, so the first product is
    /// $-(\ldots)^T \frac{\partial FD_0}{\partial x_{P1}}$.
    #[must_use]
    pub fn dcapital_gamma_dx_p1(&self) -> DMatrix<S> {
        let (h, dh, d2h, dfd0) = (&self.mass.h, &self.mass.dq, &self.mass.dqdq, &self.fd0.dq);
        let w = self.w();
        let (hw, dh_w) = (h * &w, dh.times_second(&w));
        -dh.times_first(&hw).tr_mul(dfd0) + d2h.times_first_and_second(&hw, &w) + dh_w.tr_mul(&(&dh_w - h * dfd0))
    }

    /// (B60): $\frac{\partial \Gamma}{\partial x_{P2}} = -\frac{\partial FD_0}{\partial x_{P2}}^T \frac{\partial
    /// H}{\partial x_{P1}} H w + w^T \frac{\partial H}{\partial x_{P1}} \left( -H \frac{\partial FD_0}{\partial x_{P2}}
    /// \right)$; indices as in (B59).
    #[must_use]
    pub fn dcapital_gamma_dx_p2(&self) -> DMatrix<S> {
        let (h, dh, dfd0) = (&self.mass.h, &self.mass.dq, &self.fd0.dv);
        let w = self.w();
        let (hw, dh_w) = (h * &w, dh.times_second(&w));
        -dh.times_first(&hw).tr_mul(dfd0) - dh_w.tr_mul(&(h * dfd0))
    }

    /// $\frac{\partial H^T}{\partial x_{P1}} (2 C + 2 H \dot x_{P2}) + H (2 \frac{\partial C}{\partial x_{P1}} + 2
    /// \frac{\partial H}{\partial x_{P1}} \dot x_{P2})$, which (B55) and (B56) share.
    fn dtwice_ht_force_dx_p1(&self) -> DMatrix<S> {
        let (h, dh) = (&self.mass.h, &self.mass.dq);
        let half = dh.times_first(&self.force()) + h.tr_mul(&(dh.times_second(&self.xdot_p2) + &self.dc.dq));
        half * S::from_f64(2.0)
    }

    /// $2 H \frac{\partial C}{\partial x_{P2}}$, which (B57) and (B58) share.
    fn dtwice_ht_force_dx_p2(&self) -> DMatrix<S> {
        self.mass.h.tr_mul(&self.dc.dv) * S::from_f64(2.0)
    }

    /// `N` by `N` zeros.
    pub(super) fn zero(&self) -> DMatrix<S> {
        DMatrix::zeros(self.c.len(), self.c.len())
    }

    /// $I_{N \times N}$.
    pub(super) fn identity(&self) -> DMatrix<S> {
        DMatrix::identity(self.c.len(), self.c.len())
    }
}
