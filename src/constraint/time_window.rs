//! Rows that are kept for a part of the time.

use super::{AnyConstraint, Constraint, Constraints, Evaluator, RowLabel, StageConstraint, StageInput, Weights};
use crate::error::{Error, Result, plain};
use crate::model::Model;
use nalgebra::DMatrix;

/// Inequalities on the state that are kept between two times; elsewhere their rows are a negative constant.
#[derive(Clone, Debug)]
pub struct TimeWindow {
    model: Model,
    rows: Vec<AnyConstraint>,
    times: [f64; 2],
    scales: Vec<f64>,
}

impl TimeWindow {
    /// The rows of constraints of a robot from `times[0]` to `times[1]`, s, either of which may be infinite.
    ///
    /// # Errors
    /// The first time is not before the second one, or a row is an equality.
    pub fn new(model: Model, rows: Vec<AnyConstraint>, times: [f64; 2]) -> Result<Self> {
        let refuse = |what: &str, condition: String| Err(Error::input("rows", what, condition));
        let [from, to] = times;
        // NaN is before nothing.
        if from.is_nan() || to.is_nan() || from >= to {
            let [from, to] = times.map(plain);
            return refuse("times", format!("they are {from} s and {to} s, the first one is to be before the second"));
        }
        if let Some(row) = (0..rows.dim()).find(|row| rows.row_set(*row).is_equality) {
            let RowLabel { name, .. } = rows.label(row, &model);
            return refuse("equalities", format!("{name} is one, which is kept throughout or not at all"));
        }
        let scales = rows.row_scales();
        Ok(Self { model, rows, times, scales })
    }

    /// The rows.
    pub(crate) fn rows(&self) -> &[AnyConstraint] {
        &self.rows
    }

    /// The times between which they are kept, s.
    pub(crate) fn times(&self) -> [f64; 2] {
        self.times
    }

    /// Computes the rows as if they were kept at all times: these are continuous in time.
    pub(crate) fn at_all_times(&self, at: &StageInput<'_, f64>, g: &mut [f64]) -> Result<()> {
        let mut evaluator = Evaluator::new(&self.model);
        evaluator.at(&[at.q, at.v].concat())?.value(&self.rows, g)
    }

    fn is_kept(&self, t: f64) -> bool {
        (self.times[0]..=self.times[1]).contains(&t)
    }
}

impl<K: Constraint> Constraints<K> {
    /// The constraints that are kept between two times, each with its first row.
    pub(crate) fn windows(&self) -> impl Iterator<Item = (usize, &TimeWindow)> {
        let first_of_stage = self.first_of_stage();
        let others = self.stage.custom_rows();
        others.filter_map(move |(first, other)| Some((first_of_stage + first, other.window()?)))
    }

    /// The times between which each row is kept, s, infinite for most.
    pub(crate) fn times(&self) -> Vec<[f64; 2]> {
        let mut times = vec![[f64::NEG_INFINITY, f64::INFINITY]; self.dim()];
        for (first, window) in self.windows() {
            times[first..first + window.dim()].fill(window.times);
        }
        times
    }
}

impl StageConstraint for TimeWindow {
    fn dim(&self) -> usize {
        self.rows.dim()
    }

    fn value(&self, at: &StageInput<'_, f64>, g: &mut [f64]) -> Result<()> {
        if !self.is_kept(at.t) {
            for (g, scale) in g.iter_mut().zip(&self.scales) {
                *g = -scale;
            }
            return Ok(());
        }
        self.at_all_times(at, g)
    }

    fn derivatives(
        &self,
        at: &StageInput<'_, f64>,
        multipliers: &[f64],
        gradients: &mut DMatrix<f64>,
        hessian: &mut DMatrix<f64>,
    ) -> Result<()> {
        gradients.fill(0.0);
        if !self.is_kept(at.t) {
            return Ok(());
        }
        let (x, n) = ([at.q, at.v].concat(), 2 * self.model.dof());
        let mut evaluator = Evaluator::new(&self.model);
        let mut placed = evaluator.at(&x)?;
        for row in 0..self.dim() {
            let mut first_order = vec![0.0; self.dim()];
            first_order[row] = 1.0;
            let weights = Weights { first_order: &first_order, gauss_newton: None };
            let found = placed.weighted_derivatives(&self.rows, weights)?;
            gradients.view_mut((0, row), (n, 1)).copy_from(found.gradient());
        }
        let weights = Weights { first_order: multipliers, gauss_newton: Some(&vec![0.0; self.dim()]) };
        let found = placed.weighted_derivatives(&self.rows, weights)?;
        let mut block = hessian.view_mut((0, 0), (n, n));
        block += found.hessian();
        Ok(())
    }

    fn window(&self) -> Option<&TimeWindow> {
        Some(self)
    }

    fn scale(&self, row: usize) -> f64 {
        self.scales.get(row).copied().unwrap_or(1.0)
    }

    fn label(&self, row: usize, model: &Model) -> RowLabel {
        self.rows.label(row, model)
    }
}
