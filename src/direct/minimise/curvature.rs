//! The gradient of the Lagrangian and the smallest curvature at the end of a search.

use super::program::Program;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::error::Result;
use crate::linalg::BlockTridiagonal;
use crate::nlp::{Bordered, Iterate, Kkt, Nlp};
use nalgebra::DVector;

/// The first shift of the curvature, and the change of its distance from the shift that counts as none.
const FIRST_SHIFT: f64 = 0.1;
const SETTLED: f64 = 1e-3;

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// The norm of the gradient of the Lagrangian relative to the cost, dual to the norm of steps: the residual of the
    /// first of the optimality conditions (NW 19.2a).
    pub fn stationarity(&mut self, x: &DVector<f64>, iterate: &Iterate) -> Result<f64> {
        let Some(mut kkt) = self.kkt() else {
            return Ok(f64::INFINITY);
        };
        let mut iterate = iterate.clone();
        iterate.is_lagrangian = true;
        self.derivatives(x, &iterate, &mut kkt)?;
        Ok(kkt.dual_length() / self.finer.cost[0].abs())
    }

    /// The smallest curvature at the unknowns of an iterate.
    pub fn smallest_curvature(&mut self, x: &DVector<f64>, iterate: &Iterate) -> Result<f64> {
        self.place(x);
        let Self { unknowns, grid_rows, points, derivatives, .. } = self;
        grid_rows.set_terms(iterate);
        grid_rows.objective.derivatives(&unknowns.coefficients, derivatives)?;
        points.add_hessian(unknowns, iterate, &mut derivatives.hessian)?;
        let of_unknowns = |matrix: &BlockTridiagonal<f64>| {
            let full = Bordered::with_border(matrix.clone(), 0);
            match &unknowns.period {
                None => full,
                Some(period) => period.reduced(&full),
            }
        };
        let mut kkt = Kkt::with_norm(of_unknowns(&derivatives.metric));
        kkt.hessian = of_unknowns(&derivatives.hessian);
        let (own, border) = (unknowns.own(), unknowns.border());
        let Kkt { hessian, equalities, .. } = &mut kkt;
        self.equality_gradients(&mut |segment, gradient| {
            // The curvature is that with this horizon and these times.
            equalities.push(hessian, segment, &gradient.clone().remove_rows(own, border));
        })?;
        kkt.equalities.values = DVector::zeros(iterate.equalities.len());
        Ok(kkt.smallest_curvature(FIRST_SHIFT, SETTLED).0)
    }
}
