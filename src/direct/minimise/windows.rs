//! The rows that are kept between two times, at these times.

use super::margins::beside;
use super::point_rows::PointRows;
use super::points::PointBlock;
use super::unknowns::Unknowns;
use crate::constraint::{Constraint, Constraints, StageConstraint};
use crate::model::Model;
use crate::transcription::Maximum;
use std::ops::Range;

/// Rows that are kept between two times.
pub(super) struct Window {
    /// The rows among those of a point of the quadrature.
    rows: Range<usize>,
    times_s: [f64; 2],
    /// The index of their rows at each of the times, if the motion may be there then.
    points: [Option<usize>; 2],
}

impl<'g> PointBlock<'g> {
    /// Adds the rows that are kept between two times at these, which are no points of the quadrature. A motion in parts
    /// has none.
    pub fn add_windows<K: Constraint>(
        &mut self,
        model: &'g Model,
        constraints: &'g Constraints<K>,
        unknowns: &Unknowns,
    ) {
        if unknowns.horizons.reference().is_some() {
            return;
        }
        let longest = match &unknowns.free.parts[..] {
            [] => unknowns.horizons.whole(),
            [(_, [_, longest]), ..] => *longest,
        };
        for (first, window) in constraints.windows() {
            let times_s = window.times();
            let points = times_s.map(|time| {
                (0.0 < time && time < longest)
                    .then(|| self.push(|after| PointRows::of_time(model, window.rows(), time, after)))
            });
            self.windows.push(Window { rows: first..first + window.dim(), times_s, points });
        }
    }

    /// The row of a maximum at the points beside it, as indices among all rows; `count` is the number of rows of a
    /// point of the quadrature. A row that is kept between two times is neither kept at points before nor at points
    /// after, but at these times.
    pub fn rows_beside(&self, maximum: &Maximum, unknowns: &Unknowns, count: usize) -> [Option<usize>; 2] {
        let grid = &unknowns.grid;
        let mut of_points = beside(grid, maximum);
        let windows = &mut self.windows.iter();
        let Some(window) = windows.find(|window| window.rows.contains(&maximum.row)) else {
            return of_points.map(|g| Some(g? * count + maximum.row));
        };
        let [from, to] = window.times_s;
        let part = unknowns.horizons.part(maximum.segment, grid.segments);
        let time_s = |time| unknowns.horizons.time(part, time);
        let own = |end: usize| {
            let first = self.rows[window.points[end]?].first;
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
}
