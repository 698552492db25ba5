//! A bound on the speed of a point.

use super::{Constraint, PlacedState, Quantity, RowForm, RowLabel, RowSet};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{cross, dot};
use nalgebra::Vector3;

/// The speed of a point of a body in the base frame, $g = |v_p|^2 - \bar v^2 \le 0$ in m^2/s^2, with
/// $v_p = \sum_i (v_i + \omega_i \times p) \dot q_i$ over the joints that carry the body and their axes in the base
/// frame. The square makes it smooth at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSpeedLimit<C: Scalar = f64> {
    /// The body; a point of the base is always at rest.
    pub body: Option<usize>,
    /// The point in the body, m.
    pub point: Vector3<C>,
    /// The largest speed $\bar v$, m/s.
    pub most: C,
    /// The name of the point, for the label.
    pub name: String,
}

impl<C: Scalar> Constraint<C> for PointSpeedLimit<C> {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        let p = at.point(self.body, &self.point)?;
        let (mut velocity, mut body) = (Vector3::zeros(), self.body);
        while let Some(i) = body {
            let joint = &at.model.joints()[i];
            let axis = joint.motion_subspace(&at.placements[i]);
            velocity += (axis.linear + cross(&axis.angular, &p)) * at.v()[i];
            body = joint.parent();
        }
        g[0] = dot(&velocity, &velocity) - S::lift(self.most * self.most);
        Ok(())
    }

    fn row_set(&self, _: usize) -> RowSet<C> {
        RowSet::at_most_zero().scaled(self.most + self.most)
    }

    fn label(&self, _: usize, _: &Model<C>) -> RowLabel {
        let name = format!("speed of frame '{}'", self.name);
        RowLabel { form: RowForm::Square, ..RowLabel::new(name, "m/s", Quantity::Frame) }
    }
}
