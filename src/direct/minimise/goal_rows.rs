//! The rows of a goal on the final configuration.

use super::program::Program;
use crate::constraint::{AnyConstraint, Constraint, Evaluator, Weights};
use crate::cost::CostWithControl;
use crate::error::Result;
use crate::linalg::BlockTridiagonal;
use crate::model::Model;
use crate::nlp::{Iterate, Kkt, Term};
use crate::transcription::Grid;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The rows of a goal on the final configuration, divided by their scales. They follow those of the points of the
/// quadrature.
pub(super) struct GoalRows<'g> {
    constraints: &'g [AnyConstraint],
    evaluator: Evaluator<'g>,
    scales: Vec<f64>,
    /// True for each equality.
    pub equalities: Vec<bool>,
    /// The values at the last evaluation.
    pub h: Vec<f64>,
    /// The final state, at rest.
    state: Vec<f64>,
    /// The index of the first row among all.
    pub first: usize,
}

/// The weighted rows of a goal with their derivatives in the final configuration, without the measure.
pub(super) struct OfGoal {
    /// The index of the final configuration among the unknown functions.
    pub unknown: usize,
    pub cost: f64,
    pub gradient: DVector<f64>,
    pub hessian: DMatrix<f64>,
}

impl OfGoal {
    /// Adds the Hessian times the measure to the block of the last segment.
    pub fn add_hessian(&self, measure: f64, grid: &Grid<f64>, out: &mut BlockTridiagonal<f64>) {
        let (n, e) = (self.gradient.len(), grid.segments - 1);
        let own = (self.unknown - grid.block(e).start) * n;
        let mut block = out.diagonal[e].view_mut((own, own), (n, n));
        block += measure * &self.hessian;
    }
}

impl<'g> GoalRows<'g> {
    /// The rows of `constraints`, without any if there is no goal; `first` rows come before.
    pub fn new(model: &'g Model, constraints: &'g [AnyConstraint], first: usize) -> Self {
        let rows = constraints.dim();
        let mut scales = vec![1.0; rows];
        constraints.row_scales(&mut scales);
        Self {
            equalities: (0..rows).map(|row| constraints.is_equality(row)).collect(),
            scales: scales.into_iter().map(f64::recip).collect(),
            evaluator: Evaluator::new(model),
            h: vec![0.0; rows],
            state: vec![0.0; 2 * model.dof()],
            constraints,
            first,
        }
    }

    /// The indices of the rows among all.
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.h.len()
    }

    /// Computes the rows at a final configuration.
    pub fn evaluate(&mut self, q: &[f64]) -> Result<()> {
        if self.h.is_empty() {
            return Ok(());
        }
        self.state[..q.len()].copy_from_slice(q);
        let placed = self.evaluator.at(&self.state)?;
        placed.value(self.constraints, &mut self.h)?;
        for (h, scale) in self.h.iter_mut().zip(&self.scales) {
            *h *= scale;
        }
        Ok(())
    }

    /// The largest violation, in m or rad.
    pub fn violation(&self) -> f64 {
        let rows = self.h.iter().zip(&self.equalities);
        let violations = rows.map(|(h, equality)| if *equality { h.abs() } else { *h });
        violations.fold(0.0, f64::max)
    }

    /// The gradient and the Hessian of the weighted rows in the final configuration of the last evaluation, `N` entries
    /// and `N` by `N`.
    pub fn derivatives(
        &mut self,
        terms: impl Iterator<Item = (usize, Term)>,
    ) -> Result<(DVector<f64>, DMatrix<f64>)> {
        let rows = self.h.len();
        let [mut slopes, mut multipliers, mut curvatures] = [(); 3].map(|()| vec![0.0; rows]);
        for (at, term) in terms {
            let row = at - self.first;
            let scale = self.scales[row];
            slopes[row] = scale * term.slope;
            multipliers[row] = scale * term.multiplier;
            curvatures[row] = scale * scale * term.curvature;
        }
        let n = self.state.len() / 2;
        let mut placed = self.evaluator.at(&self.state)?;
        let first = Weights {
            first_order: &slopes,
            gauss_newton: None,
        };
        let gradient = placed.weighted_derivatives(self.constraints, first)?;
        let gradient = gradient.gradient().rows(0, n).into_owned();
        let second = Weights {
            first_order: &multipliers,
            gauss_newton: Some(&curvatures),
        };
        let hessian = placed.weighted_derivatives(self.constraints, second)?;
        Ok((
            gradient,
            hessian.hessian().view((0, 0), (n, n)).into_owned(),
        ))
    }
}

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// Evaluates the rows of a goal at the current coefficients.
    pub(super) fn evaluate_goal(&mut self) -> Result<()> {
        let last = self.basis.value(self.basis.segments());
        let q = self.coefficients.column(last);
        self.goal.evaluate(q.as_slice())
    }

    /// The unknown that is the final configuration, with the derivatives in it of the rows of a goal, without the
    /// measure, and their terms; `None` if the final configuration is fixed.
    pub(super) fn of_goal(&mut self, iterate: &Iterate) -> Result<Option<OfGoal>> {
        let last = self.basis.value(self.basis.segments());
        let Some(unknown) = self.grid.unknown[last] else {
            return Ok(None);
        };
        self.evaluate_goal()?;
        let (goal, margins) = (&self.goal, &self.margins);
        let held = iterate.equalities.iter().filter_map(|equality| {
            let at = equality.row.at.checked_sub(goal.first)?;
            let term = iterate.equality_term(equality, *goal.h.get(at)?);
            Some((equality.row, term))
        });
        let near = iterate.working.iter().filter_map(|of| {
            let row = of.row;
            let h = goal.h.get(row.at.checked_sub(goal.first)?)?;
            Some((row, self.term(iterate, of, h + margins[row.at])))
        });
        let terms = held.chain(near);
        let terms: Vec<_> = terms
            .map(|(row, term)| (row.at, term.times(row.weight)))
            .collect();
        let cost = terms.iter().map(|(_, term)| term.cost).sum();
        let (gradient, hessian) = self.goal.derivatives(terms.into_iter())?;
        Ok(Some(OfGoal {
            unknown,
            cost,
            gradient,
            hessian,
        }))
    }

    /// Adds the derivatives of the rows of a goal, which depend on the final configuration alone: one coefficient per
    /// joint.
    pub(super) fn add_goal(&mut self, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        let Some(of) = self.of_goal(iterate)? else {
            return Ok(());
        };
        of.add_hessian(self.horizon, self.grid, &mut out.hessian.matrix);
        let own = of.unknown * of.gradient.len();
        let mut target = out.gradient.rows_mut(own, of.gradient.len());
        target += self.horizon * &of.gradient;
        if let Some((border, _)) = &mut out.hessian.border {
            let mut target = border.rows_mut(own, of.gradient.len());
            target += &of.gradient;
            out.gradient[self.derivatives.gradient.len()] += of.cost;
        }
        Ok(())
    }
}
