//! The derivatives in the second rate of the state, (B40) and (B78) to (B80).

use super::{Quantities, of_blocks};
use crate::scalar::Scalar;
use nalgebra::DMatrix;

impl<S: Scalar> Quantities<S> {
    /// (B79): $\frac{\partial \gamma}{\partial \ddot x_{P2}} = H^T H$, `N` by `N`.
    #[must_use]
    pub fn dgamma_dxddot_p2(&self) -> DMatrix<S> {
        self.mass.h.tr_mul(&self.mass.h)
    }

    /// (B78): $\frac{d\Omega}{d\ddot x} = 2 \begin{bmatrix} I & 0 \\\\ 0 & (H^T H)^{-1} \frac{\partial \gamma}{\partial
    /// \ddot x_{P2}} \end{bmatrix}$, `2 N` by `2 N`, not simplified.
    #[must_use]
    pub fn domega_dxddot_unsimplified(&self) -> DMatrix<S> {
        let below = self.solve_hth(self.dgamma_dxddot_p2());
        of_blocks([[self.identity(), self.zero()], [self.zero(), below]]) * S::from_f64(2.0)
    }

    /// (B40) and (B80): $\frac{d\Omega}{d\ddot x} = 2 I$, `2 N` by `2 N`.
    #[must_use]
    pub fn domega_dxddot(&self) -> DMatrix<S> {
        let n = self.c.len();
        DMatrix::identity(2 * n, 2 * n) * S::from_f64(2.0)
    }
}
