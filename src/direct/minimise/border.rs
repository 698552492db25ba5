//! The rows that are linear in the horizon and the times of waypoints.

use super::unknowns::Unknowns;
use crate::nlp::{Iterate, Kkt};
use nalgebra::DVector;

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

impl Unknowns {
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
    pub fn linear_rows(&self) -> impl Iterator<Item = LinearRow> {
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
    pub fn max_step_fraction(&self, x: &DVector<f64>, step: &DVector<f64>) -> f64 {
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

    /// Adds the derivatives of the linear rows, the first of which has this number among all.
    pub fn add_linear_rows(&self, iterate: &Iterate, first: usize, out: &mut Kkt) {
        let (horizon, own) = (self.horizons.whole(), out.gradient.len() - self.border());
        // All of them are in the working set, at its end.
        let begin = iterate.working.partition_point(|of| of.row.at < first);
        for (state, row) in iterate.working[begin..].iter().zip(self.linear_rows()) {
            let term = iterate.term(state, row.value).times(state.row.weight);
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
}
