//! Margins of rows for the time between the points, and the relaxations that compensate for them.

use super::barrier_cost::BarrierCost;
use super::row::Kind;
use crate::constraint::Constraint;
use crate::relax::CostWithControl;
use crate::relax::transcription::{Grid, Peak};
use crate::relax::tuning::{RESERVE, ROOM};

impl<K: Constraint, P: CostWithControl> BarrierCost<'_, K, P> {
    /// Sets margins from the peaks of the rows between the points.
    ///
    /// During the search the margins raise the rows at the two points of the segment next to a peak to the height of
    /// the peak. At the `end` they only grow, by twice the excess of a peak, so that the process terminates. No row
    /// comes nearer to its bound: an increase of a margin becomes a relaxation, which the next steps remove.
    pub(super) fn set_margins(&mut self, grid: &Grid<f64>, peaks: &[Peak], end: bool) {
        let count = self.rows.count();
        let slacks: Vec<f64> = self.h.iter().map(|h| -h).collect();
        for at in 0..self.h.len() {
            self.h[at] += self.relaxations[at] - self.margins[at];
            if !end && self.kinds[at] == Kind::Inequality {
                self.margins[at] = RESERVE;
            }
        }
        for peak in peaks {
            let after = grid.times.partition_point(|t| *t < peak.time);
            let own = peak.segment * grid.points()..(peak.segment + 1) * grid.points();
            let asked = |g: &usize| self.kinds[g * count + peak.row] == Kind::Inequality;
            let beside = [
                (own.start..after.min(own.end)).rfind(asked),
                (after.max(own.start)..own.end).find(asked),
            ];
            for g in beside.into_iter().flatten() {
                let at = g * count + peak.row;
                if end {
                    if peak.height > 0.0 {
                        self.margins[at] += 2.0 * peak.height + RESERVE;
                    }
                } else {
                    let beside = RESERVE + peak.height - self.h[at];
                    self.margins[at] = self.margins[at].max(beside);
                }
            }
        }
        for at in 0..self.h.len() {
            let h = self.h[at] + self.margins[at];
            if self.kinds[at] != Kind::Inequality {
                self.h[at] = h;
                continue;
            }
            let room = slacks[at].clamp(0.0, ROOM);
            self.relaxations[at] = (h + room).max(0.0);
            self.h[at] = h - self.relaxations[at];
        }
        for point in 0..self.h.len() / count.max(1) {
            self.list_near(point);
        }
    }

    /// The largest violation of a row at the last evaluation, in its unit; zero if all rows are satisfied.
    pub(super) fn largest_violation(&self) -> f64 {
        let units = &self.rows.of().units;
        // Rows without a term are far from being violated.
        self.near.places().fold(0.0, |most, (at, row)| {
            let height = match self.kinds[at] {
                Kind::Inequality => self.h[at] + self.relaxations[at] - self.margins[at],
                Kind::Equality => self.h[at].abs(),
                Kind::Idle => return most,
            };
            f64::max(most, height * units[row])
        })
    }

    /// Relaxes all rows so that each has a minimum slack, or the slack of its multiplier if that is smaller.
    pub(super) fn relax(&mut self) {
        for at in 0..self.h.len() {
            if self.kinds[at] != Kind::Inequality {
                continue;
            }
            let central = self.barrier.mu / self.multipliers[at].max(f64::MIN_POSITIVE);
            let more = (self.h[at] + ROOM.min(central)).max(0.0);
            self.relaxations[at] += more;
            self.h[at] -= more;
        }
    }
}
