//! The conversion of a force on the state to a rate of the flow, with its derivative.

use super::ActuationWeights;
use crate::dynamics::{Data, crba, mass_matrix_product_derivative};
use crate::error::Result;
use crate::linalg::Ldlt;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{DMatrix, DVector};

/// The vector $G^{-1} \gamma(x)$ in the metric $G = \mathrm{blockdiag}(k I, H W H)$, and its derivative in `x`.
///
/// With $z = H^{-1} \gamma_{P2}$ and $y = H^{-1} W^{-1} z$, that is $H W H y = \gamma_{P2}$, the rows of its derivative
/// are $\tfrac1k\\, d\gamma_{P1}$ and
///
/// $$ dy = H^{-1} \left[ W^{-1} H^{-1} (d\gamma_{P2} - K_z\\, dx_{P1}) - K_y\\, dx_{P1} \right], \quad
///    K_w = \frac{\partial (H w)}{\partial q} . $$
///
/// Cost O(N^3).
#[derive(Clone, Debug)]
pub(super) struct Raise<'m, C: Scalar, S: Scalar> {
    model: &'m Model<C>,
    weights: ActuationWeights<C>,
    data: Data<S>,
    h: DMatrix<S>,
    ldlt: Ldlt<S>,
    y: DVector<S>,
    z: DVector<S>,
    k_y: DMatrix<S>,
    k_z: DMatrix<S>,
    h_inverse: DMatrix<S>,
    /// The outer bracket, `N` by `2 N`.
    outer: DMatrix<S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C>> Raise<'m, C, S> {
    /// The conversion for `model` in the metric with these weights.
    pub(super) fn new(model: &'m Model<C>, weights: ActuationWeights<C>) -> Self {
        let n = model.dof();
        Self {
            model,
            weights,
            data: Data::new(model),
            h: DMatrix::zeros(n, n),
            ldlt: Ldlt::new(n),
            y: DVector::zeros(n),
            z: DVector::zeros(n),
            k_y: DMatrix::zeros(n, n),
            k_z: DMatrix::zeros(n, n),
            h_inverse: DMatrix::zeros(n, n),
            outer: DMatrix::zeros(n, 2 * n),
        }
    }

    /// Replaces `gamma`, `2 N` entries, by $G^{-1} \gamma$ at `q`, `N` entries.
    pub(super) fn apply(&mut self, q: &[S], k: C, gamma: &mut [S]) -> Result<()> {
        let n = self.model.dof();
        self.weights.check(n)?;
        let (upper, lower) = gamma.split_at_mut(n);
        let per_k = C::one() / k;
        upper.iter_mut().for_each(|g| *g = g.scale(per_k));
        crba(self.model, &mut self.data, q, &mut self.h)?;
        self.ldlt.factorise(&self.h);
        self.ldlt.solve(lower);
        self.weights.divide(lower);
        self.ldlt.solve(lower);
        Ok(())
    }

    /// Replaces $\partial \gamma / \partial x$, `2 N` by `2 N`, by $\partial (G^{-1} \gamma) / \partial x$ at `q`.
    pub(super) fn differentiate(&mut self, q: &[S], k: C, gamma: &DVector<S>, dx: &mut DMatrix<S>) -> Result<()> {
        let n = self.model.dof();
        self.weights.check(n)?;
        crba(self.model, &mut self.data, q, &mut self.h)?;
        self.ldlt.factorise(&self.h);
        self.z.copy_from(&gamma.rows(n, n));
        self.ldlt.solve(self.z.as_mut_slice());
        self.y.copy_from(&self.z);
        self.weights.divide(self.y.as_mut_slice());
        self.ldlt.solve(self.y.as_mut_slice());
        let (model, data) = (self.model, &mut self.data);
        mass_matrix_product_derivative(model, data, q, self.y.as_slice(), &mut self.k_y)?;
        mass_matrix_product_derivative(model, data, q, self.z.as_slice(), &mut self.k_z)?;
        let (one, zero, per_k) = (S::one(), S::zero(), C::one() / k);
        let mut upper = dx.rows_mut(0, n);
        upper.apply(|entry| *entry = entry.scale(per_k));
        // Products with the inverse are several times faster than the same number of solves.
        self.h_inverse.fill_with_identity();
        self.ldlt.solve_columns(&mut self.h_inverse);
        let mut lower = dx.rows_mut(n, n);
        let mut by_q = lower.columns_mut(0, n);
        by_q -= &self.k_z;
        self.outer.gemm(one, &self.h_inverse, &lower, zero);
        self.weights.divide(self.outer.as_mut_slice());
        let mut by_q = self.outer.columns_mut(0, n);
        by_q -= &self.k_y;
        lower.gemm(one, &self.h_inverse, &self.outer, zero);
        Ok(())
    }
}
