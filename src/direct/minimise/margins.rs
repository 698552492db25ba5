//! The rows between the points of the quadrature, and the margins that they need at the points.

use super::point_rows::PointRows;
use super::program::Program;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::cost::MIN_COST;
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
fn share_in_phase(phases: usize, time: f64) -> f64 {
    let of_phase = (phases as f64 * time).fract();
    (of_phase * (1.0 - of_phase) / 0.01).powi(2).min(1.0)
}

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// Finds the local maxima of the rows between the points; returns the largest violation, in its unit.
    pub(super) fn maxima(&mut self, end: bool) -> Result<f64> {
        let scan = self.scans[usize::from(end)].clone();
        self.evaluate_points()?;
        let of_border = self.linear_rows().map(|row| row.unit * row.value);
        let of_points = self.points.iter().map(PointRows::violation);
        let beside = of_border.chain(of_points).fold(0.0, f64::max);
        let integrand = self.objective.cost_mut();
        let floor = -self.search.scan_depth;
        let (rows, scanned) = (&mut integrand.rows, &mut self.scanned);
        let (horizons, coefficients) = (&self.horizons, &self.coefficients);
        self.deviation = scan.maxima(rows, coefficients, horizons, floor, scanned)?;
        self.evaluate_beside()?;
        let integrand = self.objective.cost();
        let attributes = integrand.rows.attributes();
        let (units, equalities) = (&attributes.units, &attributes.equalities);
        let maxima = self.scanned.found.iter();
        let highest = maxima.map(|maximum| maximum.height * units[maximum.row]);
        let mut largest = beside.max(highest.fold(0.0, f64::max));
        let count = integrand.rows.count();
        for (g, h) in integrand.h.chunks_exact(count.max(1)).enumerate() {
            if self.grid.collocated[g % self.grid.points()] {
                for (row, h) in h.iter().enumerate().filter(|(row, _)| equalities[*row]) {
                    largest = largest.max(h.abs() * units[row]);
                }
            }
        }
        Ok(largest)
    }

    /// Evaluates the rows beside their maxima at the points where they were far.
    fn evaluate_beside(&mut self) -> Result<()> {
        for maximum in &self.scanned.found {
            for g in beside(&self.grid, maximum).into_iter().flatten() {
                let near = &mut self.objective.cost_mut().rows.near;
                if near.hold(g, maximum.row) {
                    self.evaluated = None;
                }
            }
        }
        self.cost().map(|_| ())
    }

    /// Returns true if a finer quadrature gives a different cost; the tolerance is larger before the `end`.
    pub(super) fn is_coarse(&mut self, end: bool) -> Result<bool> {
        let cost = self.cost()?;
        let Some(finer) = &mut self.finer else {
            return Ok(false);
        };
        finer.set_horizons(&self.horizons);
        let exact = finer.value(&self.coefficients)?;
        let error = (exact - cost).abs() / exact.abs().max(MIN_COST);
        self.finer_cost = [exact, error];
        let on_the_way = if end { 0.0 } else { self.search.quadrature_on_the_way };
        Ok(self.refinable && error > self.stage.quadrature_tolerance.max(on_the_way))
    }

    /// Sets the margins against rounding at the unknowns of a start.
    pub(super) fn set_first_margins(&mut self, x: &DVector<f64>) -> Result<()> {
        self.place(x);
        self.cost()?;
        self.add_rows_of_ends()?;
        self.reserve();
        Ok(())
    }

    /// True for the start and the end if its state is fixed.
    pub(super) fn fixed_ends(&self) -> [bool; 2] {
        let ends = self.basis.continuity();
        let free = ends.free_final_velocity || ends.free_final_position;
        [!ends.free_start, !free]
    }

    /// Sets the margin of each row against rounding: at most the distance of a fixed start or end from the bound, as no
    /// motion has a larger distance right beside that start or end. A larger margin would be a violation that no
    /// penalty removes.
    fn set_reserves(&mut self) {
        let (fixed, integrand) = (self.fixed_ends(), self.objective.cost());
        let rows = &integrand.rows;
        let (states, attributes) = (rows.states(), rows.attributes());
        let with_ends = self.grid.times[0] == 0.0;
        let last = integrand.h.len() - rows.count();
        let reserve = |row: usize| {
            if attributes.equalities[row] {
                return 0.0;
            }
            // Its share vanishes at the ends.
            if rows.is_of_phase(row) {
                return self.search.reserve;
            }
            let ends = [row, last + row].into_iter().zip(fixed);
            let ends = ends.filter(|(_, fixed)| *fixed && with_ends && row < states);
            let distances = ends.map(|(at, _)| -integrand.h[at]);
            // An end that is outside by more than is accepted does not widen its bound.
            let least = -self.stage.feasible / attributes.units[row];
            let distances = distances.filter(|distance| *distance >= least);
            distances.fold(self.search.reserve, f64::min)
        };
        self.reserves.clear();
        self.reserves.extend((0..rows.count()).map(reserve));
    }

    /// Sets the margins against rounding.
    pub(super) fn reserve(&mut self) {
        self.set_reserves();
        let margins = self.reserves.iter().copied();
        let reserve = self.search.reserve;
        let (of_grid, beside) = self.margins.split_at_mut(self.first_of_points);
        for (margin, of_row) in of_grid.iter_mut().zip(margins.cycle()) {
            *margin = of_row;
        }
        let rows = &self.objective.cost().rows;
        let (count, phases) = (rows.count(), rows.cost.phases());
        for phase in &rows.constraints.stage.phases {
            let points = of_grid.chunks_exact_mut(count).zip(&self.grid.times);
            for (margins, time) in points {
                for margin in &mut margins[phase.rows.clone()] {
                    *margin *= share_in_phase(phases, *time);
                }
            }
        }
        let of_points = self.points.iter().flat_map(|point| &point.equalities);
        for (margin, _) in beside.iter_mut().zip(of_points).filter(|(_, held)| !**held) {
            *margin = reserve;
        }
    }

    /// Sets margins from the [local maxima](Self::maxima) of the rows between the points.
    ///
    /// They raise the rows at the two points of the segment next to a maximum to the height of the maximum, or only
    /// `grow`, by twice the excess of the maximum.
    pub(super) fn set_margins(&mut self, grow: bool) {
        if grow {
            self.set_reserves()
        } else {
            self.reserve()
        }
        let fixed = self.fixed_ends();
        let (grid, integrand) = (&self.grid, self.objective.cost());
        let (count, states) = (integrand.rows.count(), integrand.rows.states());
        // Times are sums of intervals.
        let is_at = |time: f64, end: f64| (time - end).abs() <= 8.0 * f64::EPSILON;
        let is_fixed = |time: f64| (fixed[0] && is_at(time, 0.0)) || (fixed[1] && is_at(time, 1.0));
        let phases = integrand.rows.cost.phases();
        let changes = |time: f64| is_at(phases as f64 * time, (phases as f64 * time).round());
        for maximum in &self.scanned.found {
            // Margins change neither the state at a fixed end nor the place of a foot that lands. Beside an end at its
            // bound they would act on another derivative than the decisive one.
            let at_ends = is_fixed(maximum.time) || self.has_rows_of_ends(maximum);
            let of_phase = integrand.rows.is_of_phase(maximum.row);
            if maximum.row < states && (at_ends || (of_phase && changes(maximum.time))) {
                continue;
            }
            for at in self.rows_beside(maximum).into_iter().flatten() {
                let share = if of_phase { share_in_phase(phases, grid.times[at / count]) } else { 1.0 };
                let reserve = share * self.reserves[maximum.row];
                if !grow {
                    let beside = reserve + maximum.height - self.value_of(at);
                    self.margins[at] = self.margins[at].max(beside);
                } else if maximum.height > 0.0 {
                    self.margins[at] += 2.0 * maximum.height + reserve;
                }
            }
        }
    }
}
