//! The margins that rows need at the points, so that they are kept between them.

use super::program::Program;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::error::Result;
use crate::transcription::{Grid, Maximum};
use nalgebra::DVector;

/// The points of its segment beside a maximum, at which rows are kept.
pub(super) fn beside(grid: &Grid<f64>, maximum: &Maximum) -> [Option<usize>; 2] {
    let after = grid.times.partition_point(|t| *t < maximum.time);
    let own = maximum.segment * grid.points()..(maximum.segment + 1) * grid.points();
    let asked = |g: &usize| !grid.collocated[g % grid.points()];
    [(own.start..after.min(own.end)).rfind(asked), (after.max(own.start)..own.end).find(asked)]
}

/// The share of the reserve of a row that is kept in one of several phases, at a time from 0 to 1. A foot that lands is
/// on the ground and at rest, so the share vanishes with its derivative at both ends of a phase; from a hundredth of
/// the phase on it is one.
pub(super) fn share_in_phase(phases: usize, time: f64) -> f64 {
    let of_phase = (phases as f64 * time).fract();
    (of_phase * (1.0 - of_phase) / 0.01).powi(2).min(1.0)
}

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// Finds the local maxima of the rows between the points; returns the largest violation, in its unit.
    pub(super) fn maxima(&mut self, end: bool) -> Result<f64> {
        self.points.evaluate(&self.unknowns)?;
        let of_border = self.unknowns.linear_rows().map(|row| row.unit * row.value);
        let others = of_border.fold(self.points.violation(), f64::max);
        let of_grid = self.grid_rows.maxima(&self.unknowns, end, -self.search.scan_depth)?;
        Ok(others.max(of_grid))
    }

    /// Sets the margins against rounding at the unknowns of a start, and adds the rows beside its ends.
    pub(super) fn set_first_margins(&mut self, x: &DVector<f64>) -> Result<()> {
        self.place(x);
        self.grid_rows.cost(&self.unknowns)?;
        self.add_rows_of_ends()?;
        self.reserve(false);
        Ok(())
    }

    /// Sets the margins against rounding, or only computes them where margins `grow`.
    fn reserve(&mut self, grow: bool) {
        self.grid_rows.set_reserves(&self.unknowns, &self.search, self.stage.feasible);
        if !grow {
            self.grid_rows.reserve(&self.unknowns.grid);
            self.points.reserve(self.search.reserve);
        }
    }

    /// Sets margins from the [local maxima](Self::maxima) of the rows between the points.
    ///
    /// They raise the rows at the two points of the segment next to a maximum to the height of the maximum, or only
    /// `grow`, by twice the excess of the maximum. Returns true if a row is beyond its bound at a maximum that margins
    /// change.
    pub(super) fn set_margins(&mut self, grow: bool) -> bool {
        self.reserve(grow);
        let Self { unknowns, grid_rows, points, .. } = self;
        let (fixed, grid, integrand) = (unknowns.fixed_ends(), &unknowns.grid, grid_rows.objective.cost());
        let (count, states) = (integrand.rows.count(), integrand.rows.states());
        // Times are sums of intervals.
        let is_at = |time: f64, end: f64| (time - end).abs() <= 8.0 * f64::EPSILON;
        let is_fixed = |time: f64| (fixed[0] && is_at(time, 0.0)) || (fixed[1] && is_at(time, 1.0));
        let phases = integrand.rows.cost.phases();
        let changes = |time: f64| is_at(phases as f64 * time, (phases as f64 * time).round());
        let mut is_beyond = false;
        for maximum in &grid_rows.scanned.found {
            // Margins change neither the state at a fixed end nor the place of a foot that lands. Beside an end at its
            // bound they would act on another derivative than the decisive one.
            let at_ends = is_fixed(maximum.time) || grid_rows.has_rows_of_ends(grid, maximum);
            let of_phase = integrand.rows.is_of_phase(maximum.row);
            if maximum.row < states && (at_ends || (of_phase && changes(maximum.time))) {
                continue;
            }
            is_beyond |= maximum.height > 0.0;
            for at in points.rows_beside(maximum, unknowns, count).into_iter().flatten() {
                let share = if of_phase { share_in_phase(phases, grid.times[at / count]) } else { 1.0 };
                let reserve = share * grid_rows.reserves[maximum.row];
                let (value, margin) = match grid_rows.margins.get_mut(at) {
                    Some(margin) => (integrand.h[at], margin),
                    None => (points.value(at), points.margin_mut(at)),
                };
                if !grow {
                    *margin = margin.max(reserve + maximum.height - value);
                } else if maximum.height > 0.0 {
                    *margin += 2.0 * maximum.height + reserve;
                }
            }
        }
        is_beyond
    }
}
