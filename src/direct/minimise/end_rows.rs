//! The rows between the points beside an end that is at a bound.

use super::grid_rows::GridRows;
use super::point_rows::PointRows;
use super::program::Program;
use super::unknowns::Unknowns;
use crate::constraint::{Constraint, Evaluator, Weights};
use crate::cost::CostWithControl;
use crate::error::Result;
use crate::transcription::{Grid, Maximum};
use nalgebra::DVector;

/// The number of times beside an end, each half as far from it as the one before, which divides a violation between it
/// and the end by four at rest, and by eight with zero acceleration.
const HALVINGS: i32 = 3;

/// A row of the state that is at its bound at an end.
struct AtBound {
    row: usize,
    /// Its slope in the configuration, in its unit.
    slope: DVector<f64>,
    /// The product of the slope and the configuration at which the bound is reached.
    value: f64,
}

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// Adds rows for each row of the state that is at its bound at a fixed end, where the robot is at rest.
    ///
    /// Near such an end a row is of the order of a power of the time to the end, for any motion: with a margin at the
    /// point beside the end the search would change a higher derivative instead of the lowest one, whose sign decides
    /// whether the bound is kept. So there are rows at times between that point and the end, to first order in the
    /// configuration, divided by that power.
    pub(super) fn add_rows_of_ends(&mut self) -> Result<()> {
        let Self { unknowns, grid_rows, points, search, stage, .. } = self;
        let fixed = unknowns.fixed_ends();
        let is_zero = |(column, _)| unknowns.rates[0].column(column).iter().all(|rate| *rate == 0.0);
        let times = &unknowns.grid.times;
        if times[0] != 0.0 || !unknowns.basis.fixed_slopes().all(is_zero) {
            return Ok(());
        }
        let last = times.len() - 1;
        let beside = [(0.0, times[1]), (1.0, times[last - 1] - 1.0)];
        for end in [0, 1].into_iter().filter(|end| fixed[*end]) {
            let (at, interval) = beside[end];
            let power = 2 + i32::from(unknowns.basis.fixed_accelerations().any(|of| of.1 == end && is_zero(of)));
            let rows = grid_rows.rows_at_bound(end, unknowns, (search.reserve, stage.feasible))?;
            grid_rows.at_bound[end] = rows.iter().map(|of| of.row).collect();
            for half in (1..=HALVINGS).take_while(|_| !rows.is_empty()) {
                let part = 0.5_f64.powi(half);
                let factor = part.powi(-power);
                // The reserve, which is added to the rows of points, cancels.
                let value = |of: &AtBound| factor * of.value + search.reserve;
                let linear = rows.iter().map(|of| (factor * &of.slope, value(of)));
                let (linear, time) = (linear.collect(), at + part * interval);
                let model = grid_rows.objective.cost().rows.model;
                points.push(|first| PointRows::of_linear(model, linear, time, first));
            }
        }
        Ok(())
    }
}

impl<K: Constraint, P: CostWithControl> GridRows<'_, '_, K, P> {
    /// Returns true if there are [rows](Program::add_rows_of_ends) beside a maximum.
    pub(super) fn has_rows_of_ends(&self, grid: &Grid<f64>, maximum: &Maximum) -> bool {
        let times = &grid.times;
        let [first, last] = &self.at_bound;
        (maximum.time < times[1] && first.contains(&maximum.row))
            || (maximum.time > times[times.len() - 2] && last.contains(&maximum.row))
    }

    /// The rows of the state that are within the reserve of their bounds at an end, or exceed them by no more than is
    /// accepted.
    fn rows_at_bound(&self, end: usize, unknowns: &Unknowns, (reserve, feasible): (f64, f64)) -> Result<Vec<AtBound>> {
        let integrand = self.objective.cost();
        let (rows, h) = (&integrand.rows, &integrand.h);
        let (attributes, n) = (rows.attributes(), rows.model.dof());
        let (first, breakpoint) = match end {
            0 => (0, 0),
            _ => (h.len() - rows.count(), unknowns.basis.segments()),
        };
        let q = unknowns.coefficients.column(unknowns.basis.value(breakpoint));
        let is_at_bound = |row: &usize| {
            let least = -feasible / attributes.units[*row];
            let other = attributes.equalities[*row] || rows.is_of_phase(*row);
            !other && (least..=reserve).contains(&-h[first + row])
        };
        let (mut evaluator, mut found) = (Evaluator::new(rows.model), Vec::new());
        let mut state = vec![0.0; 2 * n];
        state[..n].copy_from_slice(q.as_slice());
        for row in (0..rows.states()).filter(is_at_bound) {
            let mut only = vec![0.0; rows.states()];
            only[row] = attributes.scales[row] * attributes.units[row];
            let weights = Weights { first_order: &only, gauss_newton: None };
            let state_rows = &rows.constraints.state;
            let of = evaluator.weighted_derivatives_at(&state, (state_rows, None), weights)?;
            let slope = of.gradient().rows(0, n).into_owned();
            let distance = -h[first + row] * attributes.units[row];
            let value = slope.dot(&q) + distance.max(0.0);
            found.push(AtBound { row, slope, value });
        }
        Ok(found)
    }
}
