//! The rows of the state at the points of a curve: all, or those that may be near their bounds.

use super::Rows;
use super::near::Noted;
use crate::constraint::{Constraint, Pieces, PlacedState, RowList, WeightedDerivatives, Weights};
use crate::cost::{CostWithControl, Points};
use crate::error::Result;
use crate::scalar::{LANES, Wide};
use std::ops::Range;

/// The rows of the state that are evaluated.
#[derive(Clone, Copy)]
pub(crate) enum Which<'l> {
    /// All.
    All,
    /// Those that may be near, at the points of the grid.
    Near,
    /// Those that may be near at the points of a group, at these times between them in parts of the segment, or all.
    Between(usize, &'l [f64]),
    /// These.
    Only(&'l [usize]),
}

/// The value of a row in a phase in which it is not kept: far from its bound.
const NOT_KEPT: f64 = -1.0;

impl<K: Constraint, P: CostWithControl> Rows<'_, K, P> {
    /// The rows that may be near their bounds at a point of the grid, in ascending order: some, and a range after them.
    pub fn near_at(&self, g: usize) -> (&[usize], Range<usize>) {
        match self.near.at(g) {
            Some(listed) => (listed, self.states()..self.count()),
            None => (&[], 0..self.count()),
        }
    }

    /// Computes rows of the state and leaves the others unchanged; returns true if these are all.
    pub(super) fn of_state(
        &mut self,
        points: Points<'_, f64>,
        which: Which<'_>,
        h: &mut [f64],
    ) -> Result<bool> {
        let count = self.count();
        if self.wide.is_empty() {
            return Ok(true);
        }
        self.highest.fill(f64::NEG_INFINITY);
        let mut all = true;
        for start in (0..points.count()).step_by(LANES) {
            let are_all = self.side_by_side(points, start, which, h)?;
            if are_all && matches!(which, Which::Between(..)) {
                return self.of_state(points, Which::All, h);
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
        which: Which<'_>,
        h: &mut [f64],
    ) -> Result<bool> {
        let (own, count) = (2 * points.states.nrows(), self.count());
        let found = points.gather(start, &mut self.z);
        let placed = self.evaluator.at(&self.z[..own])?;
        let at = *placed.state();
        let placements = at.placements;
        let group = match which {
            Which::Near => self.near.group(points.first, start, points.count()),
            _ => None,
        };
        let mut noted = match group {
            Some(group) => std::mem::take(self.near.noted(group)),
            None => Noted::default(),
        };
        let follows = self.near.follows && noted.are_known;
        let listed = match (which, group) {
            (Which::Near, Some(group)) => self.near.at_points(group, placements),
            (Which::Between(group, times), _) => {
                self.near.between(group, &times[start..], placements)
            }
            (Which::Only(rows), _) => Some(rows),
            _ => None,
        };
        let (state, scales) = (&self.constraints.state, &self.attributes.scales);
        let beside = PlacedState {
            pieces: follows.then(|| Pieces::new(&noted.pieces)),
            ..at
        };
        match listed {
            Some(rows) => {
                noted.are_known &= follows;
                state.value_of(&beside, RowList::new(rows), &mut self.wide)?;
            }
            None if follows || group.is_none() => state.value(&beside, &mut self.wide)?,
            None => {
                noted.pieces.clear();
                state.value_and_pieces(&at, &mut self.wide, &mut noted.pieces)?;
                noted.are_known = true;
            }
        }
        for k in 0..listed.map_or(self.wide.len(), <[usize]>::len) {
            let row = listed.map_or(k, |rows| rows[k]);
            let mut highest = self.highest[row];
            for (lane, value) in self.wide[row].0[..found].iter().enumerate() {
                let scaled = value * scales[row];
                h[(start + lane) * count + row] = scaled;
                highest = highest.max(scaled);
            }
            self.highest[row] = highest;
        }
        let are_all = listed.is_none();
        if let Some(group) = group {
            if are_all && self.near.has_lists() {
                let values = (&self.wide[..], &scales[..], found);
                self.near.list(group, placements, values);
            }
            *self.near.noted(group) = noted;
        }
        Ok(are_all)
    }

    /// Computes the weighted derivatives of the rows of the state at the points from `start` on, side by side: of their
    /// pieces that were active at the last evaluation, which was here.
    pub fn weighted_derivatives(
        &mut self,
        points: Points<'_, f64>,
        start: usize,
        weights: Weights<'_, Wide<f64>>,
    ) -> Result<&WeightedDerivatives<Wide<f64>>> {
        points.gather(start, &mut self.z);
        let own = 2 * points.states.nrows();
        let group = self.near.group(points.first, start, points.count());
        let pieces = group.and_then(|group| self.near.pieces(group));
        let state = (&self.constraints.state, pieces);
        self.evaluator
            .weighted_derivatives_at(&self.z[..own], state, weights)
    }
}
