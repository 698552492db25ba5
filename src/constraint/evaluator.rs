//! Evaluation of constraints and their contractions at states.

use super::{
    ActivePair, ActivePairs, Constraint, PlacedState, RowLabel, RowList, RowSet, WeightedDerivatives, Weights,
};
use crate::dynamics::forward_kinematics;
use crate::error::{Result, check_length};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Motion, Placement};

/// A workspace that evaluates constraints at states of a model. It allocates nothing per state unless a constraint
/// does.
#[derive(Clone, Debug)]
pub struct Evaluator<'m, C: Scalar = f64, S: Scalar = C> {
    model: &'m Model<C>,
    placements: Vec<Placement<S>>,
    axes: Vec<Motion<S>>,
    contraction: WeightedDerivatives<S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C>> Evaluator<'m, C, S> {
    /// Allocates the workspace for `model`.
    #[must_use]
    pub fn new(model: &'m Model<C>) -> Self {
        let n = model.dof();
        Self {
            model,
            placements: vec![Placement::identity(); n],
            axes: vec![Motion::zero(); n],
            contraction: WeightedDerivatives::new(n),
        }
    }

    /// Computes the placements of the bodies at the state `x`, `2 N` entries. Cost O(N).
    ///
    /// # Errors
    /// `x` does not have `2 N` entries.
    pub fn at<'a>(&'a mut self, x: &'a [S]) -> Result<Placed<'a, C, S>> {
        check_length("x", 2 * self.model.dof(), x.len())?;
        forward_kinematics(self.model, &x[..self.model.dof()], &mut self.placements)?;
        Ok(Placed {
            state: PlacedState { model: self.model, x, placements: &self.placements, active_pairs: None },
            axes: &mut self.axes,
            contraction: &mut self.contraction,
        })
    }
}

impl<C: Scalar, S: AlgebraOver<C>> Evaluator<'_, C, S> {
    /// Computes [`Placed::weighted_derivatives`] at the state `x`; the result borrows the evaluator.
    ///
    /// # Errors
    /// Those of [`Evaluator::at`] and [`Placed::weighted_derivatives`].
    pub(crate) fn weighted_derivatives_at<K: Constraint<C> + ?Sized>(
        &mut self,
        x: &[S],
        (constraint, active_pairs): (&K, Option<&[ActivePair<S>]>),
        weights: Weights<'_, S>,
    ) -> Result<&WeightedDerivatives<S>> {
        let mut placed = self.at(x)?.with_active_pairs(active_pairs);
        placed.weighted_derivatives(constraint, weights)?;
        Ok(&self.contraction)
    }
}

/// The bodies at a state, for any number of constraints.
#[derive(Debug)]
pub struct Placed<'a, C: Scalar, S: Scalar> {
    state: PlacedState<'a, C, S>,
    axes: &'a mut [Motion<S>],
    contraction: &'a mut WeightedDerivatives<S>,
}

impl<'a, C: Scalar, S: AlgebraOver<C>> Placed<'a, C, S> {
    /// The same with the active pairs of the constraint that is evaluated, if they are known.
    #[must_use]
    pub fn with_active_pairs(mut self, active_pairs: Option<&'a [ActivePair<S>]>) -> Self {
        self.state.active_pairs = active_pairs.map(ActivePairs::new);
        self
    }
}

impl<C: Scalar, S: AlgebraOver<C>> Placed<'_, C, S> {
    /// The state in the form that constraints read.
    #[must_use]
    pub fn state(&self) -> &PlacedState<'_, C, S> {
        &self.state
    }

    /// Computes $g$ into `g`, one entry per row of `constraint`.
    ///
    /// # Errors
    /// `g` does not have one entry per row, or `constraint` refers to a joint or body that the robot does not have.
    pub fn value<K: Constraint<C> + ?Sized>(&self, constraint: &K, g: &mut [S]) -> Result<()> {
        check_length("g", constraint.dim(), g.len())?;
        constraint.value(&self.state, g)
    }

    /// Computes at least these rows of `constraint` into `g`, one entry per row.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    pub fn value_of<K: Constraint<C> + ?Sized>(&self, constraint: &K, rows: RowList<'_>, g: &mut [S]) -> Result<()> {
        check_length("g", constraint.dim(), g.len())?;
        constraint.value_of(&self.state, Some(rows), g, None)
    }

    /// Computes the sums of derivatives weighted by row: the gradient alone, or the Hessian too.
    ///
    /// # Errors
    /// The number of weights is not that of the rows, or `constraint` refers to a joint or body that the robot does not
    /// have.
    pub fn weighted_derivatives<K: Constraint<C> + ?Sized>(
        &mut self,
        constraint: &K,
        weights: Weights<'_, S>,
    ) -> Result<&WeightedDerivatives<S>> {
        weights.check(constraint.dim())?;
        self.contraction.reset(weights.gauss_newton.is_some());
        constraint.add_weighted_derivatives(&self.state, weights, self.contraction)?;
        let joints = self.state.model.joints();
        for ((axis, joint), placement) in self.axes.iter_mut().zip(joints).zip(self.state.placements) {
            *axis = joint.motion_subspace(placement);
        }
        self.contraction.collect(self.state.model, self.axes);
        Ok(self.contraction)
    }
}

impl Placed<'_, f64, f64> {
    /// The row that is violated most, with its excess in the unit of its label, which is negative if it is kept; `None`
    /// without rows.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    pub fn worst_row<K: Constraint + ?Sized>(&self, constraint: &K) -> Result<Option<(f64, RowLabel)>> {
        let mut g = vec![0.0; constraint.dim()];
        self.value(constraint, &mut g)?;
        let all = g.iter().enumerate().map(|(row, g)| {
            let RowSet { is_equality, scale, .. } = constraint.row_set(row);
            let g = if is_equality { g.abs() } else { *g };
            let label = constraint.label(row, self.state.model);
            (label.form.excess(g / scale, scale), label)
        });
        Ok(all.max_by(|(a, _), (b, _)| a.total_cmp(b)))
    }
}
