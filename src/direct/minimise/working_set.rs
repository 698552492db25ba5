//! The equalities and the inequalities of the working set.

use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::direct::SearchOptions;
use crate::motion::Problem;
use crate::nlp::{Equality, Row};
use crate::transcription::{Grid, Rows};

/// The inequalities at the points of a grid that are in the working set: clearances while they are near their bound,
/// since they are far from it most of the time, and all others always.
pub(crate) struct WorkingSet {
    /// The value of each row of a point below which it is not in the working set.
    nearest: Vec<f64>,
    /// True for clearances that are not in the working set although they may be: row by row for each point.
    outside: Vec<bool>,
    /// The clearances in the working set, as indices among the rows of all points.
    inside: Vec<usize>,
    clearances: Vec<bool>,
    /// The reach of the problem, in m.
    reach: f64,
}

impl WorkingSet {
    pub fn new<K: Constraint, P: CostWithControl>(
        problem: &Problem<'_>,
        rows: &Rows<'_, K, P>,
        search: &SearchOptions,
    ) -> Self {
        let mut working = Self {
            nearest: Vec::new(),
            outside: Vec::new(),
            inside: Vec::new(),
            reach: 0.0,
            clearances: rows.attributes().clearances.clone(),
        };
        working.restart(problem, rows, search);
        working
    }

    /// Allocates memory for a working set of all rows.
    pub fn allocate(&mut self, rows: usize) {
        self.outside.reserve(rows);
        self.inside.reserve(rows);
    }

    /// Begins the lists of rows that may be in the working set or above the depth of a scan.
    pub fn begin_lists<K: Constraint, P: CostWithControl>(
        &self,
        grid: &Grid<f64>,
        rows: &mut Rows<'_, K, P>,
        search: &SearchOptions,
    ) {
        let parts = grid.times[..grid.points()].iter();
        let times = parts.map(|time| time * grid.segments as f64).collect();
        let state = &rows.constraints.state;
        let cutoffs = rows.attributes().cutoffs[..state.dim()].iter();
        let both = self.nearest.iter().zip(cutoffs);
        // A scan needs no row with a cutoff that is not in the working set.
        let far = both.clone().map(|(nearest, cutoff)| {
            if cutoff.is_finite() { nearest - search.reserve } else { nearest.min(-search.scan_depth) - search.reserve }
        });
        let far: Vec<_> = far.collect();
        // Two balls may move before a row that was at its cutoff is near.
        let beyond = both.map(|(nearest, cutoff)| 0.5 * (cutoff + nearest) - search.reserve);
        let moved = beyond.fold(search.moved * self.reach, f64::min);
        rows.near.begin(state, &far, moved, (times, grid.segments));
    }

    /// Begins without any rows, for another problem; returns true if other rows are near now.
    pub fn restart<K: Constraint, P: CostWithControl>(
        &mut self,
        problem: &Problem<'_>,
        rows: &Rows<'_, K, P>,
        search: &SearchOptions,
    ) -> bool {
        self.reach = problem.reach();
        let near = match self.reach {
            // Without a scale all rows are in the working set.
            0.0 => f64::INFINITY,
            reach => search.near * reach,
        };
        let attributes = rows.attributes();
        let rows = attributes.clearances.iter().zip(&attributes.cutoffs);
        let nearest = rows.map(
            |(clearance, cutoff)| {
                if *clearance { -near.min(search.share_of_cutoff * cutoff) } else { f64::NEG_INFINITY }
            },
        );
        self.outside.clear();
        self.inside.clear();
        let others = !nearest.clone().eq(self.nearest.iter().copied());
        if others {
            self.nearest.clear();
            self.nearest.extend(nearest);
        }
        others
    }

    /// Lists the inequalities of the working set in ascending order in `all`, for the values `h` of the rows at all
    /// points. The state at a fixed start or end does not change, so its rows are neither listed nor refused.
    pub fn list<K: Constraint, P: CostWithControl>(
        &mut self,
        grid: &Grid<f64>,
        rows: &mut Rows<'_, K, P>,
        fixed: [bool; 2],
        h: &[f64],
        all: &mut Vec<Row>,
    ) {
        let (count, points) = (rows.count(), grid.times.len());
        all.clear();
        let equalities = &rows.attributes().equalities;
        let with_ends = grid.times[0] == 0.0;
        let is_fixed = |g| with_ends && ((g == 0 && fixed[0]) || (g + 1 == points && fixed[1]));
        // At collocated points there are equalities alone.
        let first = |g| match (grid.collocated[g % grid.points()], is_fixed(g)) {
            (true, _) => count,
            (false, true) => rows.states(),
            (false, false) => 0,
        };
        if self.outside.is_empty() {
            for g in 0..points {
                self.outside.extend_from_slice(&self.clearances);
                self.outside[g * count..][..first(g)].fill(false);
            }
        }
        for at in self.inside.drain(..) {
            self.outside[at] = true;
        }
        for g in (0..points).filter(|_| count > 0) {
            let weight = grid.weights[g % grid.points()];
            let (first, (listed, others)) = (first(g), rows.near_at(g));
            let listed = listed.iter().copied().filter(|row| *row >= first);
            listed.chain(others.start.max(first)..others.end).for_each(|row| {
                let at = g * count + row;
                // NaN counts as near.
                let is_far = h[at] < self.nearest[row];
                if is_far || equalities[row] {
                    return;
                }
                if self.clearances[row] {
                    self.inside.push(at);
                    self.outside[at] = false;
                }
                all.push(Row { is_curved: self.clearances[row], ..Row::new(at, weight) });
            });
        }
        let listed = all.iter().map(|row| (row.at / count, row.at % count));
        rows.near.set_working(listed);
    }

    /// Returns true if a clearance outside the working set is violated: the step leads into an obstacle or link that
    /// was far away.
    pub fn is_left<K: Constraint, P: CostWithControl>(&self, rows: &Rows<'_, K, P>, h: &[f64]) -> bool {
        let count = self.clearances.len().max(1);
        let points = h.chunks_exact(count).zip(self.outside.chunks_exact(count));
        let mut points = points.enumerate();
        points.any(|(g, (h, outside))| {
            let (listed, others) = rows.near_at(g);
            // Without a branch, so that rows are compared side by side.
            let left = |any, (outside, h): (&bool, &f64)| any | (*outside & (*h > 0.0));
            let listed = listed.iter().map(|row| (&outside[*row], &h[*row]));
            let others = outside[others.clone()].iter().zip(&h[others]);
            others.fold(listed.fold(false, left), left)
        })
    }
}

/// The equalities at the collocated points.
pub(crate) fn equalities<K: Constraint, P: CostWithControl>(grid: &Grid<f64>, rows: &Rows<'_, K, P>) -> Vec<Equality> {
    let (count, mut all) = (rows.count(), Vec::new());
    let held = rows.attributes().equalities.iter().enumerate();
    let held: Vec<usize> = held.filter_map(|(row, held)| held.then_some(row)).collect();
    for g in (0..grid.times.len()).filter(|g| grid.collocated[g % grid.points()]) {
        let weight = grid.weights[g % grid.points()] / Grid::COLLOCATED;
        all.extend(held.iter().map(|row| Equality::new(Row::new(g * count + row, weight))));
    }
    all
}
