//! The gradient of the Lagrangian and the smallest curvature at the end of a search.

use super::program::Program;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::error::Result;
use crate::linalg::BlockTridiagonal;
use crate::nlp::{Bordered, Iterate, Memory, Nlp};
use crate::transcription::Derivatives;
use nalgebra::DVector;

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
        let Derivatives { hessian, metric, .. } = &*derivatives;
        Ok(smallest(&of_unknowns(hessian), &of_unknowns(metric)))
    }
}

/// The smallest eigenvalue of the Hessian relative to the Gauss-Newton metric, by inverse iteration.
fn smallest(hessian: &Bordered, metric: &Bordered) -> f64 {
    let (mut factor, mut memory) = (hessian.clone(), Memory::new(hessian));
    let mut shift: f64 = 0.0;
    loop {
        factor.set_sum(hessian, shift, metric);
        if factor.factorise(&mut memory) || shift > 1e12 {
            break;
        }
        shift = (4.0 * shift).max(0.1);
    }
    let mut x = DVector::from_fn(hessian.order(), |i, _| (1.0 + i as f64).sin());
    let mut curvature = f64::INFINITY;
    for _ in 0..100 {
        let mut y = metric.product(&x);
        factor.solve(&mut y);
        let norm = y.dot(&metric.product(&y)).sqrt();
        x = y / norm;
        let now = x.dot(&hessian.product(&x));
        let settled = (curvature - now).abs() <= 1e-3 * (now + shift).abs();
        curvature = now;
        if settled {
            break;
        }
    }
    curvature
}
