//! The derivatives of weighted rows in $(t, q, v, a, u)$ along a motion.

use crate::constraint::{Constraint, Constraints, StageDerivatives};
use crate::cost::{ChainRule, Point, Points, PointsDerivatives};
use crate::error::Result;
use crate::model::Model;
use crate::nlp::Term;
use nalgebra::{DMatrix, DVector};

/// A workspace that adds the derivatives of rows in $(t, q, v, a, u)$ with the weights of their terms, by the
/// [chain rule](ChainRule).
#[derive(Clone, Debug)]
pub(super) struct StageTerms<'a> {
    rule: ChainRule<'a>,
    by_y: StageDerivatives<f64>,
    /// The weights of the second derivatives of the control.
    weights: Vec<f64>,
    gradient: DVector<f64>,
    hessian: DMatrix<f64>,
}

impl<'a> StageTerms<'a> {
    pub fn new(model: &'a Model) -> Self {
        let n = model.dof();
        Self {
            rule: ChainRule::new(model),
            by_y: StageDerivatives::new(n),
            weights: vec![0.0; n],
            gradient: DVector::zeros(3 * n),
            hessian: DMatrix::zeros(3 * n, 3 * n),
        }
    }

    /// Adds the derivatives at all points at which rows have terms.
    pub fn add<K: Constraint>(
        &mut self,
        points: Points<'_, f64>,
        constraints: &Constraints<K>,
        terms: &[Vec<(usize, Term)>],
        out: &mut PointsDerivatives<f64>,
    ) -> Result<()> {
        let n = points.states.nrows();
        for g in 0..points.count() {
            if !self.of_point(points, g, constraints, &terms[points.first + g])? {
                continue;
            }
            for (i, slope) in self.gradient.iter().enumerate() {
                out.gradients[(i % n, 3 * g + i / n)] += slope;
            }
            out.hessians.add(g, &self.hessian);
        }
        Ok(())
    }

    /// Computes the derivatives in $[q; v; a]$ at point `g`; returns false if no row has a term.
    fn of_point<K: Constraint>(
        &mut self,
        points: Points<'_, f64>,
        g: usize,
        constraints: &Constraints<K>,
        terms: &[(usize, Term)],
    ) -> Result<bool> {
        let first_of_stage = constraints.first_of_stage();
        if !terms.iter().any(|(row, _)| *row >= first_of_stage) {
            return Ok(false);
        }
        let (n, point) = (points.states.nrows(), points.point(g));
        let u = self.rule.linearise(point)?.to_vec();
        let at = point.with_control(&u);
        self.by_y.gradient.fill(0.0);
        self.by_y.hessian.fill(0.0);
        self.weights.fill(0.0);
        let mut any = false;
        for (first, other) in constraints.stage.custom_rows() {
            let own = first_of_stage + first..first_of_stage + first + other.dim();
            let mut multipliers = vec![0.0; other.dim()];
            let custom_terms = terms.iter().filter(|(row, _)| own.contains(row));
            for (row, term) in custom_terms.clone() {
                let row = row - own.start;
                multipliers[row] = term.multiplier / other.scale(row);
                any = true;
            }
            let mut gradients = DMatrix::zeros(4 * n, other.dim());
            let hessian = &mut self.by_y.hessian;
            other.derivatives(&at, &multipliers, &mut gradients, hessian)?;
            for (row, term) in custom_terms {
                let row = row - own.start;
                let (gradient, scale) = (gradients.column(row), other.scale(row));
                self.by_y.gradient.axpy(term.slope / scale, &gradient, 1.0);
                let curvature = term.curvature / (scale * scale);
                hessian.ger(curvature, &gradient, &gradient, 1.0);
                for (weight, by_u) in self.weights.iter_mut().zip(gradient.iter().skip(3 * n)) {
                    *weight += multipliers[row] * by_u;
                }
            }
        }
        self.rule.gradient(&self.by_y.gradient, &mut self.gradient);
        self.rule.pull_back(&self.by_y.hessian, &mut self.hessian);
        self.rule.add_curvature(point, &self.weights, &mut self.hessian)?;
        Ok(any)
    }

    /// The partial derivative of the weighted rows in time.
    pub fn time_rate<K: Constraint>(
        &mut self,
        point: Point<'_, f64>,
        constraints: &Constraints<K>,
        terms: &[(usize, Term)],
    ) -> Result<f64> {
        let first_of_stage = constraints.first_of_stage();
        let u = self.rule.control(point)?.to_vec();
        let at = point.with_control(&u);
        let mut sum = 0.0;
        for (first, other) in constraints.stage.custom_rows() {
            let mut rates = vec![0.0; other.dim()];
            other.time_rates(&at, &mut rates)?;
            for (row, term) in terms {
                let row = row.checked_sub(first_of_stage + first);
                if let Some(row) = row.filter(|row| *row < other.dim()) {
                    sum += term.slope * rates[row] / other.scale(row);
                }
            }
        }
        Ok(sum)
    }
}
