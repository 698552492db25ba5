//! The unknowns beside the coefficients: the horizon and the times of waypoints, with the rows that depend on them.

use super::point_rows::{Place, PointDerivatives};
use super::program::Program;
use super::windows::{InHorizon, pair};
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::error::Result;
use crate::linalg::BlockTridiagonal;
use crate::nlp::{Iterate, Kkt};
use crate::transcription::{Grid, place};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// A row that is linear in the unknowns of the border, or is so once its weight, the horizon, is multiplied into it.
pub(super) struct LinearRow {
    pub value: f64,
    /// The slopes by the index of the unknown in the border, at most two, and that in each free horizon.
    slopes: [Option<(usize, f64)>; 2],
    of_whole: f64,
    /// The unit of the row: s, or the horizon.
    pub unit: f64,
}

/// The row of a bound of a horizon, a lower one with a negative sign, and its slope.
fn bound_of_horizon(horizon: f64, bound: f64, sign: f64) -> (f64, f64) {
    if sign > 0.0 { (horizon / bound - 1.0, 1.0 / bound) } else { (bound / horizon - 1.0, -bound / horizon.powi(2)) }
}

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// The number of unknowns of the border: the horizon if it is free, or those of parts, then the unknown times of
    /// waypoints.
    pub(super) fn border(&self) -> usize {
        self.free.parts.len() + self.moving.len()
    }

    /// The mean square of the slope of the curve in normalised time.
    pub(super) fn mean_square_slope(&self) -> f64 {
        let (grid, mut sum) = (&self.grid, 0.0);
        let mut states = DMatrix::zeros(self.coefficients.nrows(), grid.table.ncols());
        for e in 0..grid.segments {
            place(&self.coefficients, grid.first(e), &grid.table, &mut states);
            for (g, weight) in grid.weights.iter().enumerate() {
                sum += weight * states.column(3 * g + 1).norm_squared();
            }
        }
        sum
    }

    /// Sets the times of waypoints from unknowns.
    pub(super) fn set_times(&mut self, x: &DVector<f64>) {
        let first = self.own() + self.border() - self.moving.len();
        for (i, k) in self.moving.iter().enumerate() {
            self.times[*k] = x[first + i];
        }
    }

    /// The index of an unknown time in the border, if it is one.
    fn unknown_time(&self, waypoint: usize) -> Option<usize> {
        let at = self.moving.iter().position(|k| *k == waypoint)?;
        Some(self.free.parts.len() + at)
    }

    /// The rows that keep the times of waypoints between those of their neighbours.
    fn time_rows(&self) -> impl Iterator<Item = LinearRow> {
        // Without unknown times there are none.
        let after = 0..=self.times.len();
        let after = after.filter(|_| !self.moving.is_empty());
        after.filter_map(|after| {
            let before = after.checked_sub(1);
            let slope = |k, slope| Some((self.unknown_time(k)?, slope));
            let slopes = [before.and_then(|k| slope(k, 1.0)), slope(after, -1.0)];
            let earlier = before.map_or(0.0, |k| self.times[k]);
            let later = self.times.get(after).copied().unwrap_or(1.0);
            slopes.iter().any(Option::is_some).then_some(LinearRow {
                value: earlier - later,
                slopes,
                of_whole: 0.0,
                unit: self.horizons.whole(),
            })
        })
    }

    /// The rows that are linear in the unknowns of the border: those of times, then the two bounds of each free
    /// horizon, then those of the whole one.
    ///
    /// The lower bound $T_0$ of a horizon is $T_0 / T - 1 \le 0$. Rows have the weight `T`, and with $T_0 - T$ the
    /// penalty $\nu T (T_0 - T)$ would fall towards $T = 0$.
    pub(super) fn linear_rows(&self) -> impl Iterator<Item = LinearRow> {
        let horizons = self.horizons.parts();
        let of_horizons = self.free.parts.iter().enumerate();
        let of_horizons = of_horizons.flat_map(|(k, (part, [shortest, longest]))| {
            [(shortest, -1.0), (longest, 1.0)].map(|(bound, sign)| {
                let (value, slope) = bound_of_horizon(horizons[*part], *bound, sign);
                LinearRow { value, slopes: [Some((k, slope)), None], of_whole: 0.0, unit: *bound }
            })
        });
        let (horizon, share) = (self.horizons.whole(), self.horizons.share());
        let of_whole = self.free.whole.iter().map(move |(bound, sign)| {
            let (value, slope) = bound_of_horizon(horizon, *bound, *sign);
            LinearRow { value, slopes: [None; 2], of_whole: share * slope, unit: *bound }
        });
        self.time_rows().chain(of_horizons).chain(of_whole)
    }

    /// The largest fraction of a step that leaves at least half of each horizon and of the time between two waypoints.
    pub(super) fn longest_on_border(&self, x: &DVector<f64>, step: &DVector<f64>) -> f64 {
        let own = self.own();
        let mut most: f64 = 1.0;
        for k in own..own + self.free.parts.len() {
            most = most.min(0.5 * x[k] / step[k].abs());
        }
        for row in self.time_rows() {
            let slopes = row.slopes.iter().flatten();
            let changes = slopes.map(|(k, slope)| slope * step[own + k]);
            let change: f64 = changes.sum();
            if change > 0.0 {
                most = most.min(-0.5 * row.value / change);
            }
        }
        most
    }

    /// Adds the derivatives of the rows that are linear in the unknowns of the border, from row `first` on.
    pub(super) fn add_linear_rows(&self, iterate: &Iterate, first: usize, out: &mut Kkt) {
        let (horizon, own) = (self.horizons.whole(), out.gradient.len() - self.border());
        // All of them are in the working set, at its end.
        let begin = iterate.working.partition_point(|of| of.row.at < first);
        for (state, row) in iterate.working[begin..].iter().zip(self.linear_rows()) {
            let term = self.term(iterate, state, row.value).times(state.row.weight);
            for k in 0..self.free.parts.len() {
                out.gradient[own + k] += term.cost * self.horizons.share();
            }
            let slopes = || {
                let whole = (0..self.free.parts.len()).filter(|_| row.of_whole != 0.0);
                let whole = whole.map(|k| (k, row.of_whole));
                row.slopes.iter().flatten().copied().chain(whole)
            };
            for (i, slope) in slopes() {
                out.gradient[own + i] += horizon * term.slope * slope;
                for (j, other) in slopes() {
                    out.hessian.corner[(i, j)] += horizon * term.curvature * slope * other;
                }
            }
        }
    }

    /// The indices of the rows of points among all rows.
    pub fn range_of_points(&self) -> Range<usize> {
        let last = self.points.last().map_or(self.first_of_points, |of| of.range().end);
        self.first_of_points..last
    }

    /// The indices of the inequalities of points.
    pub(super) fn inequalities_of_points(&self) -> impl Iterator<Item = usize> {
        let held = self.points.iter().flat_map(|point| &point.equalities);
        let rows = self.range_of_points().zip(held);
        rows.filter_map(|(at, held)| (!held).then_some(at))
    }

    /// The index of the first row that is linear in times and horizon.
    pub(super) fn first_of_border(&self) -> usize {
        self.range_of_points().end
    }

    /// The place of a point on a curve, at its own time, that of a waypoint, or the end for a goal.
    fn place_of_point(&self, point: usize, coefficients: &DMatrix<f64>) -> Place {
        let rows = &self.points[point];
        let of_motion = |time: f64| (time / self.horizons.whole()).min(1.0);
        let time = rows.time.or(rows.time_s.map(of_motion));
        let time = time.or(self.times.get(point).copied());
        Place::new(&self.basis, coefficients, time.unwrap_or(1.0), &self.horizons)
    }

    /// Evaluates the rows of all points at the current unknowns.
    pub(super) fn evaluate_points(&mut self) -> Result<()> {
        for point in 0..self.points.len() {
            let place = self.place_of_point(point, &self.coefficients);
            self.points[point].evaluate(&place)?;
        }
        Ok(())
    }

    /// The places of all points, with the derivatives of their weighted rows.
    pub(super) fn of_points(&mut self, iterate: &Iterate) -> Result<Vec<(Place, PointDerivatives)>> {
        self.evaluate_points()?;
        let mut all = Vec::new();
        for point in 0..self.points.len() {
            let rows = &self.points[point];
            let own = rows.range();
            let value = |at: usize| rows.h[at - own.start] + self.margins[at];
            let held = iterate.equalities.iter().filter(|of| own.contains(&of.row.at));
            let held = held.map(|of| (of.row, iterate.equality_term(of, value(of.row.at))));
            let near = iterate.working.iter().filter(|of| own.contains(&of.row.at));
            let near = near.map(|of| (of.row, self.term(iterate, of, value(of.row.at))));
            let terms = held.chain(near);
            let terms: Vec<_> = terms.map(|(row, term)| (row.at, term.times(row.weight))).collect();
            let place = self.place_of_point(point, &self.coefficients);
            let of = self.points[point].derivatives(terms.into_iter())?;
            all.push((place, of));
        }
        Ok(all)
    }

    /// Adds the derivatives of the rows of points to gradient and condensed matrix.
    pub(super) fn add_points(&mut self, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        let (grid, measure) = (self.grid.clone(), self.measure_of_points);
        for (point, (place, of)) in self.of_points(iterate)?.into_iter().enumerate() {
            place.add_hessian(&grid, &of, measure, &mut out.hessian.matrix);
            place.scatter(&grid, &of.gradient, 0, measure, out.gradient.as_mut_slice());
            self.add_border_of(point, (&place, &of), out);
        }
        Ok(())
    }

    /// The derivatives of a place in the horizon, through the coefficients and the slopes that depend on it.
    fn rates_of_point(&self, point: usize, place: &Place) -> DMatrix<f64> {
        match &place.in_part {
            None => self.place_of_point(point, &self.rates).q,
            Some(in_part) => {
                let first = self.grid.first(place.segment);
                let own = self.coefficients.columns(first, in_part.ncols());
                own * in_part.transpose()
            }
        }
    }

    /// Adds the derivatives of the rows of a point in the unknowns of the border.
    ///
    /// The configuration $q = \sum_m \phi_m(\tau) c_m$ and its slope are bilinear in functions and coefficients: their
    /// second derivatives in a coefficient and the time are $\phi_m'$ and $\phi_m''$. The horizon moves the coefficients
    /// of the boundary velocities; that of a part moves its slopes.
    fn add_border_of(&self, point: usize, (place, of): (&Place, &PointDerivatives), out: &mut Kkt) {
        let (grid, measure) = (&self.grid, self.measure_of_points);
        let own = out.gradient.len() - self.border();
        let part = self.horizons.part(place.segment, grid.segments);
        let mut parts = self.free.parts.iter();
        let horizon = parts.position(|(of, _)| *of == part);
        let rates = self.rates_of_point(point, place);
        // The unknown, with the derivatives of configuration and slope in it.
        let time_s = self.points[point].time_s;
        let at_time = time_s.map(|time| InHorizon::new(place, &rates, time));
        let in_horizon = horizon.map(|k| match &at_time {
            Some(at) => (k, at.first.clone()),
            None => (k, pair(&rates, 0)),
        });
        let in_time = self.unknown_time(point);
        let in_time = in_time.map(|k| (k, pair(&place.q, 1)));
        let Kkt { gradient, hessian, .. } = out;
        for (k, by) in in_horizon.iter().chain(&in_time) {
            gradient[own + k] += measure * of.gradient.dot(by);
            let bent = &of.hessian * by;
            let mut column = hessian.border.column_mut(*k);
            place.scatter(grid, &bent, 0, measure, column.as_mut_slice());
            for (j, by) in in_horizon.iter().chain(&in_time) {
                hessian.corner[(*k, *j)] += measure * bent.dot(by);
            }
        }
        if let Some((k, _)) = &in_time {
            let k = *k;
            let mut column = hessian.border.column_mut(k);
            place.scatter(grid, &of.of_multipliers, 1, measure, column.as_mut_slice());
            hessian.corner[(k, k)] += measure * of.of_multipliers.dot(&pair(&place.q, 2));
        }
        if let Some((k, _)) = in_horizon {
            if let Some(at) = &at_time {
                let mut column = hessian.border.column_mut(k);
                let column = column.as_mut_slice();
                hessian.corner[(k, k)] += at.add_second((place, grid), &of.of_multipliers, measure, column);
            }
            if let Some(in_part) = &place.in_part {
                let mut column = hessian.border.column_mut(k);
                place.scatter_functions(grid, (in_part, 0), &of.of_multipliers, measure, column.as_mut_slice());
            }
            if let Some((j, _)) = in_time {
                let late = pair(&rates, 1);
                let both = measure * of.of_multipliers.dot(&late);
                hessian.corner[(k, j)] += both;
                hessian.corner[(j, k)] += both;
            }
        }
    }
}

impl Place {
    /// Adds `factor` times the derivatives in the unknown coefficients of a function of $q$ and $q'$, or, with `d` one,
    /// those of its derivative in time where the functions themselves change.
    pub(super) fn scatter(&self, grid: &Grid<f64>, of: &DVector<f64>, d: usize, factor: f64, out: &mut [f64]) {
        self.scatter_functions(grid, (&self.functions, d), of, factor, out);
    }

    /// Does the same with other functions.
    fn scatter_functions(
        &self,
        grid: &Grid<f64>,
        (functions, d): (&DMatrix<f64>, usize),
        of: &DVector<f64>,
        factor: f64,
        out: &mut [f64],
    ) {
        let n = of.len() / 2;
        for (m, unknown) in self.unknowns(grid) {
            let [value, slope] = [d, d + 1].map(|d| factor * functions[(d, m)]);
            for (i, out) in out[unknown * n..(unknown + 1) * n].iter_mut().enumerate() {
                *out += value * of[i] + slope * of[n + i];
            }
        }
    }

    /// Adds `factor` times the Hessian in the unknown coefficients.
    pub(super) fn add_hessian(
        &self,
        grid: &Grid<f64>,
        of: &PointDerivatives,
        factor: f64,
        out: &mut BlockTridiagonal<f64>,
    ) {
        let n = of.gradient.len() / 2;
        for (a, b) in grid.pairs.iter().copied() {
            if let Some(mut target) = grid.block_mut(self.segment, (a, b), n, out) {
                for (x, y) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let product = factor * self.functions[(x, a)] * self.functions[(y, b)];
                    // Half of the functions of a breakpoint vanish there.
                    if product != 0.0 {
                        let own = of.hessian.view((x * n, y * n), (n, n));
                        target.zip_apply(&own, |to, own| *to += product * own);
                    }
                }
            }
        }
    }

    /// The functions of the segment with unknown coefficients, each with its unknown.
    fn unknowns(&self, grid: &Grid<f64>) -> impl Iterator<Item = (usize, usize)> {
        let first = grid.first(self.segment);
        let functions = 0..self.functions.ncols();
        functions.filter_map(move |m| Some((m, grid.unknown[first + m]?)))
    }
}
