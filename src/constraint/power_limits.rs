//! Limits on the mechanical power of the motor of each joint.

use super::{Quantity, RowLabel, Side, StageConstraint, StageInput};
use crate::error::{Result, check_length};
use crate::model::Model;
use nalgebra::DMatrix;

/// Limits $|u_i v_i| \le P_i$, in W; `None` for a joint without a limit.
///
/// A limit is two rows, $u_i v_i - P_i$ and $-u_i v_i - P_i$, of scale $P_i$, which are bilinear: the only second
/// derivatives are $\partial^2 g / \partial u_i\\, \partial v_i = \pm 1$.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerLimits(pub Vec<Option<f64>>);

impl PowerLimits {
    /// The joint, the side and the limit of each row.
    fn rows(&self) -> impl Iterator<Item = (usize, Side, f64)> {
        let limited = self.0.iter().enumerate().filter_map(|(i, limit)| limit.map(|limit| (i, limit)));
        limited.flat_map(|(i, limit)| [Side::Upper, Side::Lower].map(|side| (i, side, limit)))
    }
}

impl StageConstraint for PowerLimits {
    fn dim(&self) -> usize {
        self.rows().count()
    }

    fn value(&self, at: &StageInput<'_, f64>, g: &mut [f64]) -> Result<()> {
        check_length("u", self.0.len(), at.u.len())?;
        for ((i, side, limit), g) in self.rows().zip(g) {
            *g = side.sign() * at.u[i] * at.v[i] - limit;
        }
        Ok(())
    }

    fn derivatives(
        &self,
        at: &StageInput<'_, f64>,
        multipliers: &[f64],
        gradients: &mut DMatrix<f64>,
        hessian: &mut DMatrix<f64>,
    ) -> Result<()> {
        let n = at.u.len();
        check_length("u", self.0.len(), n)?;
        for (row, (i, side, _)) in self.rows().enumerate() {
            let (of_v, of_u) = (n + i, 3 * n + i);
            gradients[(of_v, row)] = side.sign() * at.u[i];
            gradients[(of_u, row)] = side.sign() * at.v[i];
            hessian[(of_v, of_u)] += side.sign() * multipliers[row];
            hessian[(of_u, of_v)] += side.sign() * multipliers[row];
        }
        Ok(())
    }

    fn scale(&self, row: usize) -> f64 {
        self.rows().nth(row).map_or(1.0, |(.., limit)| limit)
    }

    fn label(&self, row: usize, model: &Model) -> RowLabel {
        match self.rows().nth(row) {
            Some((joint, side, _)) => RowLabel::limit(Quantity::Power, (joint, Some(side)), row, model),
            None => RowLabel::numbered(row),
        }
    }
}
