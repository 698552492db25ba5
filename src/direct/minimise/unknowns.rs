//! The unknowns of a program, and the candidates that they belong to.

use super::Candidate;
use super::program::Program;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::nlp::Iterate;
use nalgebra::{DMatrix, DVector};

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// The known multipliers at the points, without those of rows beside ends that another program had.
    pub fn known_multipliers<'k>(
        &self,
        of: &Candidate,
        known: &'k mut Vec<f64>,
    ) -> Option<&'k [f64]> {
        let count = self.objective.cost().rows.count();
        of.multipliers.at_in(&self.grid.times, count, known)?;
        known.truncate(self.range_of_points().end);
        Some(known)
    }

    /// Sets the multipliers of a candidate to those of an iterate, but those of waypoints and of a goal.
    pub fn put_multipliers(&mut self, iterate: &Iterate, candidate: &mut Candidate) {
        iterate.multipliers_in(self.margins.len(), &mut self.multipliers);
        let (all, rows) = (&self.multipliers, &self.objective.cost().rows);
        candidate.multipliers.put(&self.grid, rows, all);
    }

    /// Sets the diagonal of the norm of steps of the border.
    pub(super) fn norm_of_border(&self, corner: &mut DMatrix<f64>) {
        if !self.moving.is_empty() {
            corner.fill_diagonal(self.mean_square_slope());
        }
        if self.free_horizon.is_some() {
            corner[(0, 0)] = self.horizon.powi(-2);
        }
    }

    /// The unknowns of a curve in the basis.
    pub fn unknowns(&self, of: &Candidate) -> DVector<f64> {
        let mut x = DVector::zeros(self.derivatives.gradient.len() + self.border());
        self.unknowns_in(of, &mut x);
        x
    }

    /// Computes the unknowns of a curve in the basis.
    pub fn unknowns_in(&self, of: &Candidate, x: &mut DVector<f64>) {
        let free = self.grid.free.iter();
        let coefficients = &of.path.coefficients;
        let all = free.flat_map(|function| coefficients.column(*function).into_iter().copied());
        let horizon = self.free_horizon.map(|_| of.horizon);
        let times = self.moving.iter().map(|k| of.times[*k]);
        for (x, value) in x.iter_mut().zip(all.chain(horizon).chain(times)) {
            *x = value;
        }
    }

    /// Sets path, horizon and times of waypoints of a candidate to those of unknowns.
    pub fn put(&mut self, x: &DVector<f64>, candidate: &mut Candidate) {
        self.place(x);
        candidate.path.coefficients.copy_from(&self.coefficients);
        candidate.horizon = self.horizon;
        candidate.times.clone_from(&self.times);
    }

    /// Sets coefficients, horizon and times.
    pub(super) fn place(&mut self, x: &DVector<f64>) {
        let own = self.derivatives.gradient.len();
        let columns = x.as_slice()[..own].chunks_exact(self.objective.dof());
        for (function, column) in self.grid.free.iter().zip(columns) {
            self.coefficients
                .column_mut(*function)
                .copy_from_slice(column);
        }
        if self.free_horizon.is_some() {
            self.horizon = x[own];
            for column in self.basis.fixed_slopes() {
                let mut slope = self.coefficients.column_mut(column);
                slope.copy_from(&self.rates.column(column));
                slope *= self.horizon;
            }
        }
        self.set_times(x);
        self.objective.set_horizon(self.horizon);
    }
}
