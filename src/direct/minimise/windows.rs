//! The rows that are kept between two times, at these times.

use super::margins::beside;
use super::point_rows::{Place, PointRows};
use super::program::Program;
use crate::constraint::{Constraint, Constraints, StageConstraint};
use crate::cost::CostWithControl;
use crate::transcription::{Grid, Maximum};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Rows that are kept between two times.
pub(super) struct Window {
    /// The rows among those of a point of the quadrature.
    rows: Range<usize>,
    times_s: [f64; 2],
    /// The index of their rows at each of the times, if the motion may be there then.
    points: [Option<usize>; 2],
}

impl<'g, K: Constraint, P: CostWithControl> Program<'g, '_, K, P> {
    /// Adds the rows that are kept between two times at these, which are no points of the quadrature; after
    /// [`add_goal_and_waypoints`](Self::add_goal_and_waypoints). A motion in parts has none.
    pub fn add_windows(&mut self, constraints: &'g Constraints<K>) {
        if self.horizons.reference().is_some() {
            return;
        }
        let longest = match &self.free.parts[..] {
            [] => self.horizons.whole(),
            [(_, [_, longest]), ..] => *longest,
        };
        for (first, window) in constraints.windows() {
            let times_s = window.times();
            let points = times_s.map(|time| {
                (0.0 < time && time < longest).then(|| {
                    let after = self.range_of_points().end;
                    let rows = PointRows::of_time(self.model, window.rows(), time, after);
                    self.points.push(rows);
                    self.points.len() - 1
                })
            });
            self.windows.push(Window { rows: first..first + window.dim(), times_s, points });
        }
        self.count_margins();
    }

    /// The row of a maximum at the points beside it, as indices among all rows. A row that is kept between two times is
    /// neither kept at points before nor at points after, but at these times.
    pub(super) fn rows_beside(&self, maximum: &Maximum) -> [Option<usize>; 2] {
        let (grid, count) = (&self.grid, self.objective.cost().rows.count());
        let mut of_points = beside(grid, maximum);
        let windows = &mut self.windows.iter();
        let Some(window) = windows.find(|window| window.rows.contains(&maximum.row)) else {
            return of_points.map(|g| Some(g? * count + maximum.row));
        };
        let [from, to] = window.times_s;
        let part = self.horizons.part(maximum.segment, grid.segments);
        let time_s = |time| self.horizons.time(part, time);
        let own = |end: usize| {
            let first = self.points[window.points[end]?].first;
            Some(first + maximum.row - window.rows.start)
        };
        // Times are sums of intervals. An end that the window does not have has no point.
        let is_at = |end: &usize| {
            let time = window.times_s[*end];
            let off = (time_s(maximum.time) - time).abs();
            window.points[*end].is_some() && off <= 8.0 * f64::EPSILON * time
        };
        if let Some(end) = [0, 1].into_iter().find(is_at) {
            return [own(end), None];
        }
        let is_kept = |g: &usize| (from..=to).contains(&time_s(grid.times[*g]));
        of_points = of_points.map(|g| g.filter(is_kept));
        [0, 1].map(|end| of_points[end].map(|g| g * count + maximum.row).or_else(|| own(end)))
    }

    /// The value of a row at a point of the quadrature or another one.
    pub(super) fn value_of(&self, at: usize) -> f64 {
        if at < self.first_of_points {
            return self.objective.cost().h[at];
        }
        let after = self.points.partition_point(|point| point.first <= at);
        let point = &self.points[after - 1];
        point.h[at - point.first]
    }
}

/// Two neighbouring columns, one below the other.
pub(super) fn pair(of: &DMatrix<f64>, first: usize) -> DVector<f64> {
    DVector::from_column_slice(of.columns(first, 2).into_owned().as_slice())
}

/// The derivatives in the horizon of configuration and slope at a time in s.
///
/// The normalised time is $\tau = t / T$ and the velocity $q' / T$, where $q'$ is the slope in normalised time. A longer
/// horizon moves the time by $-\tau / T$, and acts on the velocity as a change of the slope by $-q' / T$ does.
pub(super) struct InHorizon {
    pub first: DVector<f64>,
    second: DVector<f64>,
    /// $\tau / T$ and $T$.
    late: f64,
    horizon: f64,
}

impl InHorizon {
    /// The derivatives at a place with configuration and slopes `q`; `rates` are those of coefficients that depend on
    /// the horizon.
    pub fn new(place: &Place, rates: &DMatrix<f64>, time_s: f64) -> Self {
        let (q, n, horizon) = (&place.q, place.q.nrows(), place.horizon);
        let late = time_s / (horizon * horizon);
        let moved = pair(rates, 0) - pair(q, 1) * late;
        let mut first = moved.clone();
        let slope = place.q.column(1) / horizon;
        let mut of_slope = first.rows_mut(n, n);
        of_slope -= &slope;
        let mut second =
            pair(q, 2) * (late * late) + pair(q, 1) * (2.0 * late / horizon) - pair(rates, 1) * (2.0 * late);
        let mut of_slope = second.rows_mut(n, n);
        of_slope += (slope - moved.rows(n, n)) * (2.0 / horizon);
        Self { first, second, late, horizon }
    }

    /// Adds the second derivatives of rows with these multipliers, `factor` times: in the horizon and each coefficient
    /// to `column`, and in the horizon alone, which is returned.
    pub fn add_second(
        &self,
        (place, grid): (&Place, &Grid<f64>),
        multipliers: &DVector<f64>,
        factor: f64,
        column: &mut [f64],
    ) -> f64 {
        place.scatter(grid, multipliers, 1, -factor * self.late, column);
        let mut of_slope = multipliers.clone();
        of_slope.rows_mut(0, place.q.nrows()).fill(0.0);
        place.scatter(grid, &of_slope, 0, -factor / self.horizon, column);
        factor * multipliers.dot(&self.second)
    }
}
