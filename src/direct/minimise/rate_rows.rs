//! The rates of equalities at a point of a curve.

use super::place::Place;
use super::point_rows::PointDerivatives;
use crate::constraint::{AnyConstraint, Constraint, Evaluator, Weights};
use crate::error::Result;
use crate::model::Model;
use crate::nlp::Term;
use nalgebra::DVector;
use num_dual::Dual64;

/// The rates $r_j = \nabla g_j(q) \cdot q'$ of the equalities among the rows of constraints on the configuration, which
/// are zero where a foot lands: then the ground does not strike it.
///
/// A rate is the derivative of $g_j(q + \varepsilon q')$ in $\varepsilon$, so with the dual number $q + \varepsilon q'$
/// the derivatives of $g_j$ have those of $r_j$ as their dual parts:
///
/// $$ \frac{\partial r_j}{\partial q} = \nabla g_j', \qquad \frac{\partial r_j}{\partial q'} = \nabla g_j, \qquad
///    \frac{\partial^2 r_j}{\partial q^2} = \nabla^2 g_j', \qquad
///    \frac{\partial^2 r_j}{\partial q\\, \partial q'} = \nabla^2 g_j, $$
///
/// where a dash is the derivative along $q'$; $r_j$ is linear in $q'$.
pub(super) struct RateRows<'g> {
    constraints: &'g [AnyConstraint],
    evaluator: Evaluator<'g, f64, Dual64>,
    /// The rows of the constraints, and their factors.
    rows: Vec<usize>,
    scales: Vec<f64>,
    /// $q + \varepsilon q'$, at rest.
    state: Vec<Dual64>,
}

impl<'g> RateRows<'g> {
    /// The rates of these rows, whose factors are `scales`.
    pub fn new(model: &'g Model, constraints: &'g [AnyConstraint], (rows, scales): (Vec<usize>, Vec<f64>)) -> Self {
        Self {
            constraints,
            evaluator: Evaluator::new(model),
            rows,
            scales,
            state: vec![Dual64::from(0.0); 2 * model.dof()],
        }
    }

    /// Computes the rates at a place of a curve.
    pub fn evaluate(&mut self, place: &Place, h: &mut [f64]) -> Result<()> {
        if h.is_empty() {
            return Ok(());
        }
        let slopes = place.q.column(1);
        for ((state, q), slope) in self.state.iter_mut().zip(&place.q.column(0)).zip(&slopes) {
            *state = Dual64::new(*q, *slope);
        }
        let mut g = vec![Dual64::from(0.0); self.constraints.dim()];
        let placed = self.evaluator.at(&self.state)?;
        placed.value(self.constraints, &mut g)?;
        for ((h, row), scale) in h.iter_mut().zip(&self.rows).zip(&self.scales) {
            *h = g[*row].eps * scale;
        }
        Ok(())
    }

    /// Adds the derivatives of the rates with these terms at the last evaluation.
    pub fn add(&mut self, terms: &[(usize, Term)], out: &mut PointDerivatives) -> Result<()> {
        if terms.is_empty() {
            return Ok(());
        }
        let (n, zero) = (self.state.len() / 2, Dual64::from(0.0));
        let none = vec![zero; self.constraints.dim()];
        let mut multipliers = none.clone();
        let mut placed = self.evaluator.at(&self.state)?;
        for (k, term) in terms {
            let (row, scale) = (self.rows[*k], self.scales[*k]);
            multipliers[row] += term.multiplier * scale;
            let mut alone = none.clone();
            alone[row] = Dual64::from(scale);
            let weights = Weights { first_order: &alone, gauss_newton: None };
            let found = placed.weighted_derivatives(self.constraints, weights)?;
            let gradient = found.gradient();
            let gradient = DVector::from_fn(2 * n, |i, _| if i < n { gradient[i].eps } else { gradient[i - n].re });
            out.gradient.axpy(term.slope, &gradient, 1.0);
            out.of_multipliers.axpy(term.multiplier, &gradient, 1.0);
            out.hessian.ger(term.curvature, &gradient, &gradient, 1.0);
        }
        let weights = Weights { first_order: &multipliers, gauss_newton: Some(&none) };
        let found = placed.weighted_derivatives(self.constraints, weights)?;
        let hessian = found.hessian();
        for j in 0..n {
            for i in 0..n {
                out.hessian[(i, j)] += hessian[(i, j)].eps;
                out.hessian[(n + i, j)] += hessian[(i, j)].re;
                out.hessian[(i, n + j)] += hessian[(i, j)].re;
            }
        }
        Ok(())
    }
}
