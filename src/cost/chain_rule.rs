//! The chain rule from derivatives with respect to the control to derivatives along the motion.

use crate::cost::Point;
use crate::dynamics::{
    Data, InverseDynamicsDerivatives, RneaWeightedHessian, rnea, rnea_derivatives, rnea_weighted_hessian,
};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{DMatrix, DVector};

/// The chain rule for $l(z, u)$ with $u = ID(z)$, $z = [q; v; a]$. With $y = [z; u]$ and
/// $J = \left[ \frac{\partial ID}{\partial q}\ \frac{\partial ID}{\partial v}\ H \right]$,
///
/// $$ \frac{d l}{d z} = l_z + J^T l_u, \qquad
///    \frac{d^2 l}{d z^2} = \begin{bmatrix} I \\ J \end{bmatrix}^T l_{yy} \begin{bmatrix} I \\ J \end{bmatrix} +
///    \Phi(l_u), $$
///
/// where $\Phi(w)$ is the Hessian of $w^T ID$ (`proofs/direct.md`).
#[derive(Clone, Debug)]
pub struct ChainRule<'m, C: Scalar = f64, S: Scalar = C> {
    model: &'m Model<C>,
    data: Data<S>,
    id: InverseDynamicsDerivatives<S>,
    second: RneaWeightedHessian<S>,
    /// $J$ at the last linearised point.
    jacobian: DMatrix<S>,
    transposed: DMatrix<S>,
    /// $M_{uz} + M_{uu} J / 2$ of the matrix in [`pull_back`](Self::pull_back).
    mixed: DMatrix<S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C>> ChainRule<'m, C, S> {
    /// The chain rule for the inverse dynamics of `model`.
    #[must_use]
    pub fn new(model: &'m Model<C>) -> Self {
        let n = model.dof();
        Self {
            model,
            data: Data::new(model),
            id: InverseDynamicsDerivatives::new(n),
            second: RneaWeightedHessian::new(n),
            jacobian: DMatrix::zeros(n, 3 * n),
            transposed: DMatrix::zeros(3 * n, n),
            mixed: DMatrix::zeros(n, 3 * n),
        }
    }

    /// Computes $u$ at a point.
    ///
    /// # Errors
    /// A slice of `point` does not have `N` entries.
    pub fn control(&mut self, point: Point<'_, S>) -> Result<&[S]> {
        let Point { q, v, a, .. } = point;
        rnea(self.model, &mut self.data, q, v, a, self.id.tau.as_mut_slice())?;
        Ok(self.id.tau.as_slice())
    }

    /// Computes $u$ at a point, and stores $J$ for the other functions.
    ///
    /// # Errors
    /// A slice of `point` does not have `N` entries.
    pub fn linearise(&mut self, point: Point<'_, S>) -> Result<&[S]> {
        let (n, Point { q, v, a, .. }) = (self.model.dof(), point);
        rnea_derivatives(self.model, &mut self.data, q, v, a, &mut self.id)?;
        let InverseDynamicsDerivatives { dq, dv, h, .. } = &self.id;
        for (i, block) in [dq, dv, h].into_iter().enumerate() {
            self.jacobian.columns_mut(i * n, n).copy_from(block);
        }
        self.jacobian.transpose_to(&mut self.transposed);
        Ok(self.id.tau.as_slice())
    }

    /// Computes $l_z + J^T l_u$ from the gradient in $y$.
    pub fn gradient(&self, by_y: &DVector<S>, out: &mut DVector<S>) {
        let n = self.model.dof();
        out.copy_from(&by_y.rows(0, 3 * n));
        out.gemv(S::one(), &self.transposed, &by_y.rows(3 * n, n), S::one());
    }

    /// Computes $[I; J]^T M [I; J]$ of a symmetric matrix in $y$.
    pub fn pull_back(&mut self, m: &DMatrix<S>, out: &mut DMatrix<S>) {
        let n = self.model.dof();
        let (one, half) = (S::one(), S::one() / S::from_f64(2.0));
        out.copy_from(&m.view((0, 0), (3 * n, 3 * n)));
        // The halves of M_zu J + J^T M_uz + J^T M_uu J are transposes of each other.
        self.mixed.copy_from(&m.view((3 * n, 0), (n, 3 * n)));
        let uu = m.view((3 * n, 3 * n), (n, n));
        self.mixed.gemm(half, &uu, &self.jacobian, one);
        out.gemm(one, &self.transposed, &self.mixed, one);
        out.gemm_tr(one, &self.mixed, &self.jacobian, one);
    }

    /// Adds $\Phi(l_u)$ to a matrix in $z$, `3 N` by `3 N`.
    ///
    /// # Errors
    /// A slice of `point` does not have `N` entries.
    pub fn add_curvature(&mut self, point: Point<'_, S>, by_u: &[S], out: &mut DMatrix<S>) -> Result<()> {
        let (n, Point { q, v, a, .. }) = (self.model.dof(), point);
        let second = &mut self.second;
        rnea_weighted_hessian(self.model, &mut self.data, q, v, a, by_u, second)?;
        let RneaWeightedHessian { qq, qv, vv, qa } = second;
        let mut add = |row: usize, column: usize, block: &DMatrix<S>| {
            let mut target = out.view_mut((row * n, column * n), (n, n));
            target += block;
        };
        add(0, 0, qq);
        add(1, 1, vv);
        for (column, block) in [(1, qv), (2, qa)] {
            add(0, column, block);
            add(column, 0, &block.transpose());
        }
        Ok(())
    }
}
