//! The Jacobian composed from explicit tensors as in Theorem B4: the reference for faster methods.
//!
//! [`Quantities`] holds the quantities of Algorithm B2; every numbered block of the theorem is one of its methods:
//! (B49) to (B52) in `terms`, (B45) to (B48) and (B53) to (B60) in `by_x`, (B62) to (B77) in `by_xdot`, (B78) to (B80)
//! in `by_xddot`. This file composes them.

mod by_x;
mod by_xddot;
mod by_xdot;
mod quantities;
mod terms;

pub use quantities::Quantities;

use super::{NodeBlocks, NodeJacobian};
use crate::dynamics::Data;
use crate::error::Result;
use crate::flow::Node;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::DMatrix;

/// The Jacobian of the right-hand side by Theorem B4 and Algorithm B2. Cost O(N^4) in time and memory; it allocates.
#[derive(Clone, Debug)]
pub struct TheoremB4<'m, C: Scalar = f64, S: Scalar = C> {
    model: &'m Model<C>,
    data: Data<S>,
    quantities: Quantities<S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C>> TheoremB4<'m, C, S> {
    /// The Jacobian for `model`.
    #[must_use]
    pub fn new(model: &'m Model<C>) -> Self {
        Self { model, data: Data::new(model), quantities: Quantities::new(model.dof()) }
    }

    /// Computes the three blocks (B38), (B39) and (B40) of (B37) at `node` with penalty `k` into `out`.
    ///
    /// # Errors
    /// A slice of `node` does not have `2 N` entries, or a block of `out` is not `2 N` by `2 N`.
    ///
    /// # Cost
    /// O(N^4); it allocates.
    pub fn blocks(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()> {
        out.check(self.model.dof())?;
        self.gather(node)?;
        let t = &self.quantities;
        out.dx.copy_from(&t.domega_dx(k));
        out.dxdot.copy_from(&t.domega_dxdot(k));
        out.dxddot.copy_from(&t.domega_dxddot());
        Ok(())
    }

    /// Computes lines 1 to 10 of Algorithm B2: the quantities at `node`.
    ///
    /// # Errors
    /// A slice of `node` does not have `2 N` entries.
    pub fn gather(&mut self, node: Node<'_, S>) -> Result<&Quantities<S>> {
        self.quantities.gather(self.model, &mut self.data, node)?;
        Ok(&self.quantities)
    }
}

impl<C: Scalar, S: AlgebraOver<C>> NodeJacobian<C, S> for TheoremB4<'_, C, S> {
    fn evaluate(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()> {
        self.blocks(node, k, out)
    }
}

impl<S: Scalar> Quantities<S> {
    /// $d\Omega / dx = d\Omega_1/dx - (d\Omega_2/dx - d\Omega_3/dx + d\Omega_4/dx)$, (B38) and (B44), `2 N` by `2 N`.
    #[must_use]
    pub fn domega_dx<C: Scalar>(&self, k: C) -> DMatrix<S>
    where
        S: AlgebraOver<C>,
    {
        self.domega_1_dx() - (self.domega_2_dx(k) - self.domega_3_dx(k) + self.domega_4_dx(k))
    }

    /// $d\Omega / d\dot x = d\Omega_1/d\dot x - (d\Omega_2/d\dot x - d\Omega_3/d\dot x + d\Omega_4/d\dot x)$, (B39) and
    /// (B61), `2 N` by `2 N`.
    #[must_use]
    pub fn domega_dxdot<C: Scalar>(&self, k: C) -> DMatrix<S>
    where
        S: AlgebraOver<C>,
    {
        self.domega_1_dxdot() - (self.domega_2_dxdot(k) - self.domega_3_dxdot(k) + self.domega_4_dxdot(k))
    }
}

/// The matrix of two by two blocks of size `N` by `N`, by rows.
fn of_blocks<S: Scalar>([[a, b], [c, d]]: [[DMatrix<S>; 2]; 2]) -> DMatrix<S> {
    let n = a.nrows();
    let mut whole = DMatrix::zeros(2 * n, 2 * n);
    for (block, row, column) in [(a, 0, 0), (b, 0, n), (c, n, 0), (d, n, n)] {
        whole.view_mut((row, column), (n, n)).copy_from(&block);
    }
    whole
}

/// The product `c * matrix`, without promoting the constant `c`.
fn scaled<C: Scalar, S: AlgebraOver<C>>(matrix: DMatrix<S>, c: C) -> DMatrix<S> {
    matrix.map(|entry| entry.scale(c))
}
