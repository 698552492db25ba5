//! The Jacobian by central differences, for comparison only.

use super::{NodeBlocks, NodeJacobian};
use crate::error::Result;
use crate::flow::{ControlForm, Node, RightHandSide};
use crate::model::Model;

/// The Jacobian by central differences of order four, of the control form by default: the choice of a user without
/// derivatives.
///
/// The step balances truncation, of order four, against rounding. Cost: `24 N` evaluations of $\Omega$.
#[derive(Clone, Debug)]
pub struct CentralDifference<R> {
    rhs: R,
    /// `x`, `xdot` and `xddot`, concatenated.
    inputs: Vec<f64>,
    omega: Vec<f64>,
    column: Vec<f64>,
}

/// Offsets in steps, with their weights over the step (Fornberg, 1988).
const STENCIL: [(f64, f64); 4] = [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];

impl<'m> CentralDifference<ControlForm<'m, f64, f64>> {
    /// The Jacobian of the control form for `model`.
    #[must_use]
    pub fn new(model: &'m Model) -> Self {
        Self::of(ControlForm::new(model), model.dof())
    }
}

impl<R: RightHandSide<f64, f64>> CentralDifference<R> {
    /// The Jacobian of any right-hand side for a model with `n` joints.
    #[must_use]
    pub fn of(rhs: R, n: usize) -> Self {
        Self { rhs, inputs: vec![0.0; 6 * n], omega: vec![0.0; 2 * n], column: vec![0.0; 2 * n] }
    }
}

impl<R: RightHandSide<f64, f64>> NodeJacobian for CentralDifference<R> {
    fn evaluate(&mut self, node: Node<'_, f64>, k: f64, out: &mut NodeBlocks) -> Result<()> {
        let m = self.omega.len();
        out.check(m / 2)?;
        node.check(m / 2, m)?;
        let values = node.x.iter().chain(node.xdot).chain(node.xddot);
        self.inputs.iter_mut().zip(values).for_each(|(input, value)| *input = *value);
        for j in 0..3 * m {
            let centre = self.inputs[j];
            let step = f64::EPSILON.powf(0.2) * centre.abs().max(1.0);
            self.column.fill(0.0);
            for (offset, weight) in STENCIL {
                self.inputs[j] = centre + offset * step;
                let (x, rest) = self.inputs.split_at(m);
                let (xdot, xddot) = rest.split_at(m);
                let t = node.t;
                let moved = Node { t, x, xdot, xddot };
                self.rhs.omega(moved, k, &mut self.omega)?;
                for (sum, omega) in self.column.iter_mut().zip(&self.omega) {
                    *sum += weight / step * omega;
                }
            }
            self.inputs[j] = centre;
            let block = match j / m {
                0 => &mut out.dx,
                1 => &mut out.dxdot,
                _ => &mut out.dxddot,
            };
            block.column_mut(j % m).copy_from_slice(&self.column);
        }
        Ok(())
    }
}
