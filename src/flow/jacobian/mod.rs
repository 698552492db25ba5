//! The Jacobian of the right-hand side at one node: one file per method, all behind one trait.

mod central_difference;
mod control_form;
mod forward_dual;
mod registry;
pub mod theorem_b4;

pub use central_difference::CentralDifference;
pub use control_form::ControlFormJacobian;
pub use forward_dual::ForwardDual;
pub use registry::{JacobianKind, Jacobians};
pub use theorem_b4::TheoremB4;

use super::Node;
use crate::dynamics::check_square;
use crate::error::Result;
use crate::scalar::Scalar;
use nalgebra::DMatrix;

/// The three blocks of the Jacobian of $\Omega(t, x, \dot x, \ddot x, k)$ in its three states, `2 N` by `2 N` each;
/// rows are those of $\Omega$.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeBlocks<S: Scalar = f64> {
    /// $d\Omega / dx$, (B38).
    pub dx: DMatrix<S>,
    /// $d\Omega / d\dot x$, (B39).
    pub dxdot: DMatrix<S>,
    /// $d\Omega / d\ddot x$, (B40).
    pub dxddot: DMatrix<S>,
}

impl<S: Scalar> NodeBlocks<S> {
    /// Zeros for a model with `n` joints.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zeros = || DMatrix::zeros(2 * n, 2 * n);
        Self { dx: zeros(), dxdot: zeros(), dxddot: zeros() }
    }

    /// The blocks in this order.
    #[must_use]
    pub fn all(&self) -> [&DMatrix<S>; 3] {
        [&self.dx, &self.dxdot, &self.dxddot]
    }

    /// Checks that the blocks have the sizes of a model with `n` joints.
    pub(crate) fn check(&self, n: usize) -> Result<()> {
        for (what, block) in [("dx", &self.dx), ("dxdot", &self.dxdot), ("dxddot", &self.dxddot)] {
            check_square(what, 2 * n, block)?;
        }
        Ok(())
    }
}

/// A method of computing the Jacobian of the right-hand side at one node, over the scalar `S` for a model with
/// constants `C`.
pub trait NodeJacobian<C = f64, S: Scalar = f64> {
    /// Computes the three blocks at `node` with penalty `k` into `out`.
    ///
    /// # Errors
    /// A slice of `node` does not have `2 N` entries, or a block of `out` is not `2 N` by `2 N`.
    fn evaluate(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()>;
}

impl<C, S: Scalar, J: NodeJacobian<C, S> + ?Sized> NodeJacobian<C, S> for Box<J> {
    fn evaluate(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()> {
        (**self).evaluate(node, k, out)
    }
}
