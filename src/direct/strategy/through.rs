//! Starts through waypoints.

use crate::direct::{Waypoint, waypoint};
use crate::motion::{Path, Problem};
use crate::plan::distance;
use nalgebra::{DMatrix, DVector};

/// The number of times per leg among which the time is searched at which a curve is nearest to a waypoint.
const LOOKS: usize = 64;

/// The number of Gauss-Newton steps from there, each of which doubles the number of digits.
const GAUSS_NEWTON: usize = 5;

/// The normalised times of waypoints along the polyline from start to goal by its lengths in configuration space, those
/// that are given where they are.
pub(crate) fn times_by_length(problem: &Problem<'_>, waypoints: &[Waypoint], start: usize) -> Vec<f64> {
    let n = problem.model().dof();
    let mut before = &problem.start()[..n];
    let (mut lengths, mut length) = (Vec::new(), 0.0);
    let points = waypoints.iter().map(|waypoint| waypoint.guess(start));
    for q in points.chain([&problem.goal()[..n]]) {
        // A waypoint at the place of the one before has a time of its own.
        length += distance(before, q).max(f64::EPSILON.sqrt());
        lengths.push(length);
        before = q;
    }
    let given = |k: usize| waypoints.get(k)?.share;
    let mut times = Vec::new();
    let [mut from, mut to] = [(0.0, 0.0); 2];
    for (k, length) in lengths[..waypoints.len()].iter().enumerate() {
        if k == 0 || given(k - 1).is_some() {
            from = to;
            let next = (k..waypoints.len()).find_map(|j| Some((lengths[j], given(j)?)));
            to = next.unwrap_or((lengths[waypoints.len()], 1.0));
        }
        let share = (length - from.0) / (to.0 - from.0);
        times.push(given(k).unwrap_or(from.1 + share * (to.1 - from.1)));
    }
    times
}

/// The normalised times at which a curve is nearest to its waypoints in their order: the least sum of squared distances
/// over a grid of times, or, if times are given, those [by length](times_by_length).
pub(crate) fn nearest_times(path: &Path, problem: &Problem<'_>, waypoints: &[Waypoint]) -> Vec<f64> {
    if waypoints.iter().any(|waypoint| waypoint.share.is_some()) {
        return times_by_length(problem, waypoints, 0);
    }
    let looks = LOOKS * (waypoints.len() + 1);
    let times: Vec<f64> = (1..looks).map(|i| i as f64 / looks as f64).collect();
    let places = times.iter().map(|time| path.basis.evaluate(&path.coefficients, *time));
    let places: Vec<_> = places.map(|[q, ..]| q).collect();
    // The least sum up to a waypoint that is passed at a time or earlier, and the time at which it is passed then.
    let mut least = vec![0.0; times.len() + 1];
    let mut chosen = Vec::new();
    for waypoint in waypoints {
        let (mut best, mut at) = (f64::INFINITY, 0);
        let mut sums = vec![f64::INFINITY];
        let mut here = Vec::new();
        for (i, q) in places.iter().enumerate() {
            let guesses = waypoint.guesses.iter();
            let distances = guesses.map(|guess| distance(guess, q.as_slice()));
            let off = distances.fold(f64::INFINITY, f64::min);
            let sum = least[i] + off * off;
            if sum < best {
                (best, at) = (sum, i);
            }
            sums.push(best);
            here.push(at);
        }
        least = sums;
        chosen.push(here);
    }
    let mut last = times.len();
    let mut found = vec![0.0; waypoints.len()];
    for (k, here) in chosen.iter().enumerate().rev() {
        last = here[last - 1];
        found[k] = times[last];
    }
    for k in 0..found.len() {
        let before = k.checked_sub(1).map_or(0.0, |k| found[k]);
        let after = found.get(k + 1).copied().unwrap_or(1.0);
        found[k] = nearer(path, &waypoints[k], [before, found[k], after]);
    }
    found
}

/// The time at which a curve is nearest to a waypoint, or slowest where it stops, by Gauss-Newton steps from a time
/// between two others; that time if it is not between them.
fn nearer(path: &Path, waypoint: &Waypoint, [before, first, after]: [f64; 3]) -> f64 {
    let guess = waypoint.guess(0);
    let mut time = first;
    for _ in 0..GAUSS_NEWTON {
        let [q, slope, bend] = path.basis.evaluate(&path.coefficients, time);
        let (off, rate) = if waypoint.stop { (slope, bend) } else { (q - DVector::from_column_slice(guess), slope) };
        time -= off.dot(&rate) / rate.norm_squared();
        if !(time > before && time < after) {
            return first;
        }
    }
    time
}

impl Path {
    /// The curve with the least change of its free coefficients, whose functions have second derivatives of unit norm
    /// between breakpoints, that is at the waypoints at these times, and at rest where it stops.
    pub(crate) fn through(mut self, waypoints: &[Waypoint], start: usize, times: &[f64]) -> Self {
        if waypoints.is_empty() {
            return self;
        }
        let (n, free) = (self.coefficients.nrows(), self.basis.free());
        let rows = waypoint::conditions(waypoints);
        let (mut values, mut off) = (DMatrix::zeros(rows, free.len()), DMatrix::zeros(rows, n));
        let mut row = 0;
        for (waypoint, time) in waypoints.iter().zip(times) {
            let (segment, functions) = self.basis.functions_at(*time);
            let first = self.basis.first(segment);
            let [q, slope, _] = self.basis.evaluate(&self.coefficients, *time);
            let aim = DVector::from_column_slice(waypoint.guess(start));
            let conditions = [aim - q, -slope];
            for (d, condition) in conditions.iter().take(1 + usize::from(waypoint.stop)).enumerate() {
                for (column, function) in free.iter().enumerate() {
                    if (first..first + functions.ncols()).contains(function) {
                        values[(row, column)] = functions[(d, function - first)];
                    }
                }
                off.set_row(row, &condition.transpose());
                row += 1;
            }
        }
        // If there are fewer functions than conditions, these are met as closely as possible.
        let svd = values.svd(true, true);
        let small = f64::EPSILON.sqrt() * svd.singular_values.max();
        if let Ok(change) = svd.solve(&off, small) {
            for (row, function) in change.row_iter().zip(&free) {
                let mut column = self.coefficients.column_mut(*function);
                column += row.transpose();
            }
        }
        self
    }
}
