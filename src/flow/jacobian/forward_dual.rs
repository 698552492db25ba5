//! The Jacobian by dual numbers, eight tangents at a time.

use super::{NodeBlocks, NodeJacobian};
use crate::error::Result;
use crate::flow::{ControlForm, Node, RightHandSide};
use crate::model::Model;
use nalgebra::SVector;
use num_dual::{Derivative, DualSVec64};

/// The number of tangents per pass.
const CHUNK: usize = 8;

/// A number with [`CHUNK`] tangents.
type Tangents = DualSVec64<CHUNK>;

/// The Jacobian of a [`RightHandSide`] by forward-mode automatic differentiation in chunks.
///
/// Differentiates the control form by default. No structure of the Jacobian is assumed, not even
/// $d\Omega / d\ddot x = 2 I$. Cost: `6 N / 8` evaluations with eight tangents each.
#[derive(Clone, Debug)]
pub struct ForwardDual<R> {
    rhs: R,
    /// `x`, `xdot` and `xddot`, concatenated.
    inputs: Vec<Tangents>,
    omega: Vec<Tangents>,
}

impl<'m> ForwardDual<ControlForm<'m, f64, Tangents>> {
    /// The Jacobian of the control form for `model`.
    #[must_use]
    pub fn new(model: &'m Model) -> Self {
        Self::of(ControlForm::new(model), model.dof())
    }
}

impl<R: RightHandSide<f64, Tangents>> ForwardDual<R> {
    /// The Jacobian of any right-hand side for a model with `n` joints.
    #[must_use]
    pub fn of(rhs: R, n: usize) -> Self {
        Self { rhs, inputs: vec![Tangents::from(0.0); 6 * n], omega: vec![Tangents::from(0.0); 2 * n] }
    }
}

impl<R: RightHandSide<f64, Tangents>> NodeJacobian for ForwardDual<R> {
    fn evaluate(&mut self, node: Node<'_, f64>, k: f64, out: &mut NodeBlocks) -> Result<()> {
        let m = self.omega.len();
        out.check(m / 2)?;
        node.check(m / 2, m)?;
        let values = node.x.iter().chain(node.xdot).chain(node.xddot);
        for (input, value) in self.inputs.iter_mut().zip(values) {
            *input = Tangents::from(*value);
        }
        for start in (0..3 * m).step_by(CHUNK) {
            let chunk = start..(start + CHUNK).min(3 * m);
            for (lane, j) in chunk.clone().enumerate() {
                self.inputs[j].eps = Derivative::some(SVector::ith(lane, 1.0));
            }
            let (x, rest) = self.inputs.split_at(m);
            let (xdot, xddot) = rest.split_at(m);
            let t = Tangents::from(node.t);
            let moved = Node { t, x, xdot, xddot };
            self.rhs.omega(moved, k, &mut self.omega)?;
            for (lane, j) in chunk.enumerate() {
                self.inputs[j].eps = Derivative::none();
                let block = match j / m {
                    0 => &mut out.dx,
                    1 => &mut out.dxdot,
                    _ => &mut out.dxddot,
                };
                for (i, omega) in self.omega.iter().enumerate() {
                    block[(i, j % m)] = omega.eps.0.map_or(0.0, |eps| eps[lane]);
                }
            }
        }
        Ok(())
    }
}
