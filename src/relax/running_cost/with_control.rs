//! Costs to which limits of the control can be added.

use crate::error::Result;
use crate::relax::{ControlEffort, Point, PointCost, Points, PointsDerivatives};

/// A running cost that knows the control, so that [`relax_constrained_with`](crate::relax::relax_constrained_with) can
/// charge for torques above their limits as well.
pub trait CostWithControl: PointCost<f64> + Clone {
    /// The cost, and the control into `u`.
    ///
    /// # Errors
    /// The point is for another robot.
    fn value_with_control(&mut self, point: Point<'_, f64>, u: &mut [f64]) -> Result<f64>;

    /// All of `out`, of the cost and of another cost of the control alone that is charged; costs and metrics are those of the first.
    ///
    /// # Errors
    /// The points are for another robot.
    fn derivatives_with(
        &mut self,
        points: Points<'_, f64>,
        out: &mut PointsDerivatives<f64>,
        charge: &mut impl ControlTerm<f64>,
    ) -> Result<()>;
}

/// What is charged for the control at a point: it is handed the index of the point and `u`, and adds what it has as first and second
/// derivatives, the latter with their own joint only. It says whether it has any of the second.
pub trait ControlTerm<S>: FnMut(usize, &[S], &mut [S], &mut [S]) -> bool {}
impl<S, F: FnMut(usize, &[S], &mut [S], &mut [S]) -> bool> ControlTerm<S> for F {}

impl CostWithControl for ControlEffort<'_, f64, f64> {
    fn value_with_control(&mut self, point: Point<'_, f64>, u: &mut [f64]) -> Result<f64> {
        let control = self.control(point)?;
        u.copy_from_slice(control.as_slice());
        Ok(control.dot(control))
    }

    fn derivatives_with(
        &mut self,
        points: Points<'_, f64>,
        out: &mut PointsDerivatives<f64>,
        charge: &mut impl ControlTerm<f64>,
    ) -> Result<()> {
        ControlEffort::derivatives_with(self, points, out, charge)
    }
}
