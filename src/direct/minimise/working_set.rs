//! The equalities and the inequalities of the working set.

use super::program::Program;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::direct::SearchOptions;
use crate::motion::Problem;
use crate::nlp::{Equality, Row};
use crate::transcription::{Attributes, Grid};

/// The value of each row of a point below which it is not in the working set: clearances are far from their bound most
/// of the time.
pub(super) fn nearest(
    problem: &Problem<'_>,
    attributes: &Attributes,
    search: &SearchOptions,
) -> Vec<f64> {
    let near = match problem.reach() {
        // Without a scale all rows are in the working set.
        0.0 => f64::INFINITY,
        reach => search.near * reach,
    };
    let rows = attributes.clearances.iter().zip(&attributes.cutoffs);
    rows.map(|(clearance, cutoff)| match clearance {
        true => -near.min(search.share_of_cutoff * cutoff),
        false => f64::NEG_INFINITY,
    })
    .collect()
}

impl<K: Constraint, P: CostWithControl> Program<'_, '_, K, P> {
    /// The equalities at the collocated points and of a goal.
    pub(super) fn list_equalities(&self, density: f64) -> Vec<Equality> {
        let rows = &self.objective.cost().rows;
        let (count, grid) = (rows.count(), self.grid);
        let held = rows.attributes().equalities.iter().enumerate();
        let held: Vec<usize> = held.filter_map(|(row, held)| held.then_some(row)).collect();
        let mut all = Vec::new();
        for g in (0..grid.times.len()).filter(|g| grid.collocated[g % grid.points()]) {
            let weight = grid.weights[g % grid.points()] / Grid::COLLOCATED;
            all.extend(held.iter().map(|row| {
                let first = match rows.constraints.is_passive(*row) {
                    true => self.search.motor_penalty,
                    false => self.search.equality_penalty * density,
                };
                let at = g * count + row;
                Equality {
                    row: Row { at, weight },
                    first,
                    penalty: self.equality_penalty * first,
                    multiplier: 0.0,
                }
            }));
        }
        let of_goal = self.goal.range().zip(&self.goal.equalities);
        all.extend(of_goal.filter(|(_, held)| **held).map(|(at, _)| {
            let first = self.search.equality_penalty * density;
            Equality {
                row: Row { at, weight: 1.0 },
                first,
                penalty: self.equality_penalty * first,
                multiplier: 0.0,
            }
        }));
        all
    }

    /// The inequalities of the working set, in ascending order, for values of all rows.
    pub(super) fn list_near(&mut self, h: &[f64]) -> Vec<Row> {
        let (grid, integrand) = (self.grid, self.objective.cost());
        let (count, states) = (integrand.rows.count(), integrand.rows.states());
        let equalities = &integrand.rows.attributes().equalities;
        let (last, with_ends) = (grid.times.len() - 1, grid.times[0] == 0.0);
        let ends = self.basis.continuity();
        let free = ends.free_final_velocity || ends.free_final_position;
        let is_fixed = |g| with_ends && (g == 0 || (g == last && !free));
        self.working.clear();
        self.working.resize(h.len(), false);
        let mut rows = Vec::new();
        for g in (0..grid.times.len()).filter(|_| count > 0) {
            let weight = grid.weights[g % grid.points()];
            let own = g * count..(g + 1) * count;
            // The state at a fixed end does not change, so its rows are neither listed nor refused; at collocated
            // points there are equalities alone.
            let first = match (grid.collocated[g % grid.points()], is_fixed(g)) {
                (true, _) => count,
                (false, true) => states,
                (false, false) => 0,
            };
            let (h, working) = (&h[own.clone()], &mut self.working[own.clone()]);
            working[..first].fill(true);
            for row in first..count {
                // NaN counts as near.
                if (h[row] >= self.nearest[row] || h[row].is_nan()) && !equalities[row] {
                    working[row] = true;
                    let at = own.start + row;
                    rows.push(Row { at, weight });
                }
            }
        }
        self.working[self.goal.first..].fill(true);
        let of_goal = self.goal.range().zip(&self.goal.equalities);
        let of_goal = of_goal.filter_map(|(at, held)| (!held).then_some(at));
        let bounds = self.goal.range().end..h.len();
        rows.extend(of_goal.chain(bounds).map(|at| Row { at, weight: 1.0 }));
        rows
    }

    /// Returns true if a clearance outside the working set is violated: a step into something that was far away.
    pub(super) fn is_beyond_working_set(&self, h: &[f64]) -> bool {
        let clearances = &self.objective.cost().rows.attributes().clearances;
        let points = h[..self.goal.first].chunks_exact(clearances.len().max(1));
        let working = self.working.chunks_exact(clearances.len().max(1));
        points.zip(working).any(|(h, working)| {
            let rows = h.iter().zip(working).zip(clearances);
            // Without a branch, so that rows are compared side by side.
            rows.fold(false, |any, ((h, working), clearance)| {
                any | (!working & *clearance & (*h > 0.0))
            })
        })
    }
}
