//! The nonlinear program of a curve in the state without rows.

use crate::cost::PointCost;
use crate::error::Result;
use crate::motion::{Path, Watch};
use crate::nlp::{Iterate, Kkt, Nlp, Row, Tightened};
use crate::transcription::{Derivatives, Grid, Objective};
use nalgebra::DVector;

/// The action of a Lagrangian: the unknowns are the free coefficients of a curve in the state.
pub(super) struct Free<'g, L> {
    pub grid: &'g Grid<f64>,
    pub objective: Objective<'g, f64, L>,
    derivatives: Derivatives<f64>,
    /// The curve, with the coefficients of the last evaluation.
    pub path: Path,
    pub horizon: f64,
    watch: &'g Watch,
}

impl<'g, L: PointCost<f64>> Free<'g, L> {
    pub fn new(grid: &'g Grid<f64>, lagrangian: L, path: Path, horizon: f64, watch: &'g Watch) -> Self {
        let size = path.coefficients.nrows();
        let mut objective = Objective::new(grid, lagrangian, size);
        objective.set_horizon(horizon);
        Self { grid, objective, derivatives: Derivatives::new(grid, size), path, horizon, watch }
    }

    /// The unknowns of the curve.
    pub fn unknowns(&self) -> DVector<f64> {
        let free = self.grid.free.iter();
        let all = free.flat_map(|f| self.path.coefficients.column(*f).into_iter().copied());
        DVector::from_iterator(self.derivatives.gradient.len(), all)
    }

    /// Sets the curve.
    pub fn place(&mut self, x: &DVector<f64>) {
        let columns = x.as_slice().chunks_exact(self.objective.dof());
        for (function, column) in self.grid.free.iter().zip(columns) {
            let mut to = self.path.coefficients.column_mut(*function);
            to.copy_from_slice(column);
        }
    }

    /// The action of the curve.
    pub fn action(&mut self) -> Result<f64> {
        self.objective.value(&self.path.coefficients)
    }

    /// Computes the derivatives of the action of the curve.
    pub fn derive(&mut self, out: &mut Kkt) -> Result<()> {
        let coefficients = &self.path.coefficients;
        self.objective.gradient_and_hessian(coefficients, &mut self.derivatives)?;
        out.gradient.copy_from(&self.derivatives.gradient);
        std::mem::swap(&mut out.hessian.matrix, &mut self.derivatives.hessian);
        Ok(())
    }
}

impl<L: PointCost<f64>> Nlp for Free<'_, L> {
    fn value(&mut self, x: &DVector<f64>, _: &mut Vec<f64>) -> Result<f64> {
        self.place(x);
        self.action()
    }

    fn derivatives(&mut self, x: &DVector<f64>, _: &Iterate, out: &mut Kkt) -> Result<()> {
        self.place(x);
        self.derive(out)
    }

    fn measure(&self, _: &DVector<f64>) -> f64 {
        self.horizon
    }

    fn working_set(&mut self, _: &[f64], rows: &mut Vec<Row>) {
        rows.clear();
    }

    fn tighten(&mut self, _: &DVector<f64>, _: &mut Vec<f64>, _: usize) -> Result<Tightened> {
        Ok(Tightened::Violation(0.0))
    }

    fn is_stopped(&self) -> bool {
        self.watch.stopped().is_some()
    }
}
