//! The check of the quadrature by a finer one.

use super::unknowns::Unknowns;
use crate::cost::{CostWithControl, MIN_COST};
use crate::error::Result;
use crate::transcription::{Grid, Objective};
use std::sync::Arc;

/// The cost alone by a finer quadrature, if there is one.
pub(super) struct Finer<'g, P> {
    objective: Option<Objective<'g, f64, P>>,
    /// The cost of the last evaluation, and its relative difference from that of the search.
    pub cost: [f64; 2],
    /// True if the number of points may increase.
    is_refinable: bool,
}

impl<P: CostWithControl> Finer<'_, P> {
    /// The cost of `dof` joints on a grid.
    pub fn new(grid: Option<Arc<Grid<f64>>>, cost: &P, dof: usize, is_refinable: bool) -> Self {
        let objective = grid.map(|grid| Objective::new(grid, cost.clone(), dof));
        Self { objective, cost: [f64::NAN; 2], is_refinable }
    }

    /// Returns true if the finer quadrature differs by more than `tolerance` from a cost, and more points are allowed.
    pub fn is_coarse(&mut self, unknowns: &Unknowns, cost: f64, tolerance: f64) -> Result<bool> {
        let Some(objective) = &mut self.objective else {
            return Ok(false);
        };
        objective.set_horizons(&unknowns.horizons);
        let exact = objective.value(&unknowns.coefficients)?;
        let error = (exact - cost).abs() / exact.abs().max(MIN_COST);
        self.cost = [exact, error];
        Ok(self.is_refinable && error > tolerance)
    }
}
