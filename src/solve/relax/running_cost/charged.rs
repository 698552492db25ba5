//! Costs to which limits of the control can be added.

use crate::error::Result;
use crate::solve::relax::{Point, PointCost, PointDerivatives, SquaredControl};

/// A running cost that knows the control, so that [`relax_constrained_with`](crate::solve::relax::relax_constrained_with) can
/// charge for torques above their limits as well.
pub trait ChargedCost: PointCost<f64> + Clone {
    /// The cost, and the control into `u`.
    ///
    /// # Errors
    /// The point is for another robot.
    fn value_with_control(&mut self, point: Point<'_, f64>, u: &mut [f64]) -> Result<f64>;

    /// The cost, and the derivatives of it and of another cost of the control alone. `charge` is handed `u` and adds what the other
    /// cost has as first and second derivatives, the latter with their own joint only; it says whether it has any of the second.
    /// The metric is that of the first cost.
    ///
    /// # Errors
    /// The point is for another robot.
    fn derivatives_charging(
        &mut self,
        point: Point<'_, f64>,
        out: &mut PointDerivatives<f64>,
        charge: impl FnOnce(&[f64], &mut [f64], &mut [f64]) -> bool,
    ) -> Result<f64>;
}

impl ChargedCost for SquaredControl<'_, f64, f64> {
    fn value_with_control(&mut self, point: Point<'_, f64>, u: &mut [f64]) -> Result<f64> {
        let control = self.control(point)?;
        u.copy_from_slice(control.as_slice());
        Ok(control.dot(control))
    }

    fn derivatives_charging(
        &mut self,
        point: Point<'_, f64>,
        out: &mut PointDerivatives<f64>,
        charge: impl FnOnce(&[f64], &mut [f64], &mut [f64]) -> bool,
    ) -> Result<f64> {
        SquaredControl::derivatives_charging(self, point, out, charge)
    }
}
