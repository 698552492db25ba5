//! The rows of the state at the points of a curve: all, or those that may be near their bounds.

use super::Rows;
use crate::constraint::{ActivePair, ActivePairs, Constraint, PlacedState, RowList, WeightedDerivatives, Weights};
use crate::cost::{CostWithControl, Points};
use crate::error::Result;
use crate::scalar::{LANES, Wide};
use std::ops::Range;

/// The rows of the state that are evaluated.
#[derive(Clone, Copy)]
pub(crate) enum RowSelection<'l> {
    /// All.
    All,
    /// Those that may be near, at the points of the grid.
    Cached,
    /// Those that may be near at the points of a group, at these times between them in parts of the segment, or all.
    CachedOverInterval(usize, &'l [f64]),
    /// All there.
    Trial(usize),
    /// These.
    Listed(&'l [usize]),
}

/// The value of a row in a phase in which it is not kept: far from its bound.
const NOT_KEPT: f64 = -1.0;

/// Values of rows at points that were evaluated side by side, to be written to those at all points.
struct Written<'w> {
    wide: &'w [Wide<f64>],
    scales: &'w [f64],
    highest: &'w mut [f64],
    h: &'w mut [f64],
    /// The first of the points, and their number.
    first: usize,
    found: usize,
}

impl Written<'_> {
    /// Writes rows.
    fn write(&mut self, rows: impl Iterator<Item = usize>) {
        let count = self.scales.len();
        for row in rows {
            let mut highest = self.highest[row];
            for (lane, value) in self.wide[row].0[..self.found].iter().enumerate() {
                let scaled = value * self.scales[row];
                self.h[(self.first + lane) * count + row] = scaled;
                highest = highest.max(scaled);
            }
            self.highest[row] = highest;
        }
    }

    /// Adds the rows that are not at their cutoffs for the first time to `touched`, and writes these to the points
    /// before.
    fn touch(&mut self, active_pairs: &[ActivePair<Wide>], cutoffs: &[f64], touched: &mut Vec<usize>) {
        let count = self.scales.len();
        for row in active_pairs.iter().map(|pair| pair.row) {
            if self.highest[row] == f64::NEG_INFINITY {
                self.highest[row] = -cutoffs[row];
                for point in 0..self.first {
                    self.h[point * count + row] = self.highest[row];
                }
                touched.push(row);
            }
        }
    }
}

impl<K: Constraint, P: CostWithControl> Rows<'_, K, P> {
    /// The rows that may be near their bounds at a point of the grid, in ascending order: some, and a range after them.
    pub fn near_at(&self, g: usize) -> (&[usize], Range<usize>) {
        match self.near.at(g) {
            Some(listed) => (listed, self.states()..self.count()),
            None => (&[], 0..self.count()),
        }
    }

    /// Computes rows of the state and leaves the others unchanged; returns true if these are all.
    pub(super) fn of_state(&mut self, points: Points<'_, f64>, which: RowSelection<'_>, h: &mut [f64]) -> Result<bool> {
        let count = self.count();
        if self.wide.is_empty() {
            return Ok(true);
        }
        self.highest.fill(f64::NEG_INFINITY);
        self.touched.clear();
        let mut all = true;
        for start in (0..points.count()).step_by(LANES) {
            let are_all = self.side_by_side(points, start, which, h)?;
            if let (true, RowSelection::CachedOverInterval(group, _)) = (are_all, which) {
                return self.of_state(points, RowSelection::Trial(group), h);
            }
            all &= are_all;
        }
        let others = self.constraints.stage.phases.iter().enumerate();
        for (_, other) in others.filter(|(k, _)| *k != points.phase) {
            for h in h.chunks_exact_mut(count).take(points.count()) {
                h[other.rows.clone()].fill(NOT_KEPT);
            }
        }
        Ok(all)
    }

    /// Computes rows of the state at the points from `start` on, side by side; returns true if these are all.
    fn side_by_side(
        &mut self,
        points: Points<'_, f64>,
        start: usize,
        which: RowSelection<'_>,
        h: &mut [f64],
    ) -> Result<bool> {
        let own = 2 * points.states.nrows();
        let found = points.gather(start, &mut self.z);
        let placed = self.evaluator.at(&self.z[..own])?;
        let at = *placed.state();
        let placements = at.placements;
        let group = match which {
            RowSelection::Cached => self.near.group(points.first, start, points.count()),
            _ => None,
        };
        let mut active_pairs = match (which, group) {
            (_, Some(group)) => std::mem::take(self.near.active_pairs(group)),
            (RowSelection::CachedOverInterval(group, _) | RowSelection::Trial(group), _) => {
                self.near.begin_between(Some(group), start)
            }
            _ => self.near.begin_between(None, start),
        };
        let listed = match (which, group) {
            (RowSelection::Cached, Some(group)) => self.near.at_points(group, placements),
            (RowSelection::CachedOverInterval(group, times), _) => {
                self.near.between(group, &times[start..], placements)
            }
            (RowSelection::Listed(rows), _) => Some(rows),
            _ => None,
        };
        let (state, scales) = (&self.constraints.state, &self.attributes.scales);
        // Values between the points are compared over time.
        let pairs = ActivePairs::new(&active_pairs);
        let pairs = if group.is_some() { pairs } else { pairs.independent() };
        let at = PlacedState { active_pairs: Some(pairs), ..at };
        self.active.clear();
        state.value_of(&at, listed.map(RowList::new), &mut self.wide, Some(&mut self.active))?;
        std::mem::swap(&mut active_pairs, &mut self.active);
        let are_all = listed.is_none();
        if let Some(group) = group.filter(|_| are_all && self.near.has_lists()) {
            let values = (&self.wide[..], &scales[..], found);
            self.near.list(group, placements, values);
        }
        self.write((which, group), &active_pairs, (start, found, are_all), h);
        match group {
            Some(group) => *self.near.active_pairs(group) = active_pairs,
            None => self.near.between_points = active_pairs,
        }
        Ok(are_all)
    }

    /// Writes the rows that were evaluated at `found` points from `first` on: those with a cutoff alone that may be
    /// near, or that were nearer than that at one of the points.
    fn write(
        &mut self,
        (which, group): (RowSelection<'_>, Option<usize>),
        active_pairs: &[ActivePair<Wide>],
        (first, found, are_all): (usize, usize, bool),
        h: &mut [f64],
    ) {
        let listed = match (which, group) {
            (RowSelection::Listed(rows), _) => Some(rows),
            (RowSelection::Cached, Some(group)) if self.near.has_lists() => Some(self.near.listed(group)),
            (RowSelection::CachedOverInterval(group, _), _) if !are_all => Some(self.near.listed(group)),
            _ => None,
        };
        let mut written =
            Written { wide: &self.wide, scales: &self.attributes.scales, highest: &mut self.highest, h, first, found };
        match (listed, which) {
            (Some(rows), _) if are_all => {
                written.write(self.dense.iter().chain(rows).copied());
            }
            (Some(rows), _) => written.write(rows.iter().copied()),
            (None, RowSelection::Cached) => written.write(0..self.wide.len()),
            (None, _) => {
                written.touch(active_pairs, &self.attributes.cutoffs, &mut self.touched);
                written.write(self.dense.iter().chain(&self.touched).copied());
            }
        }
    }

    /// Computes the weighted derivatives of the rows of the state at the points from `start` on, side by side.
    pub fn weighted_derivatives(
        &mut self,
        points: Points<'_, f64>,
        start: usize,
        weights: Weights<'_, Wide<f64>>,
    ) -> Result<&WeightedDerivatives<Wide<f64>>> {
        points.gather(start, &mut self.z);
        let own = 2 * points.states.nrows();
        let group = self.near.group(points.first, start, points.count());
        let active_pairs = group.map(|group| &self.near.active_pairs(group)[..]);
        let state = (&self.constraints.state, active_pairs);
        self.evaluator.weighted_derivatives_at(&self.z[..own], state, weights)
    }
}
