//! The filter of a line search with equalities (WB 2.3).

use super::Iterate;

/// The parts by which the violation, or the barrier function by that of the violation, decreases at least: 1e-5 as in
/// WB (3).
const PROGRESS: f64 = 1e-5;

/// The powers of the predicted decrease and of the violation in the switching condition: as in WB (3).
const POWERS: [f64; 2] = [2.3, 1.1];

/// The violation below which a step may count as one of descent, and the one above which none is accepted, relative to
/// that at the start: as in WB (3).
const LEAST: f64 = 1e-4;
const MOST: f64 = 1e4;

/// The largest violation and value of the barrier function of each step that was taken for a smaller violation.
#[derive(Clone, Debug, Default)]
pub(super) struct Filter {
    entries: Vec<[f64; 2]>,
    /// The violation with which the filter began, at least 1.
    first: f64,
}

/// A step that a filter accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Accepted {
    /// The barrier function decreases sufficiently.
    Descent,
    /// The violation or the barrier function decreases.
    Progress,
}

impl Filter {
    /// Forgets all entries.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.first = 0.0;
    }

    /// Accepts the end of the fraction `alpha` of a step, with violation and barrier function before and after, and the
    /// slope of the latter along the whole step: `sufficient` is the part of it that a descent achieves, less what
    /// `rounding` can hide.
    pub fn test(
        &mut self,
        before: [f64; 2],
        after: [f64; 2],
        (alpha, slope): (f64, f64),
        (sufficient, rounding): (f64, f64),
    ) -> Option<Accepted> {
        if self.first == 0.0 {
            self.first = before[0].max(1.0);
        }
        let barred = |[violation, merit]: &[f64; 2]| after[0] >= *violation && after[1] >= *merit;
        // False for NaN.
        if !(after[0] <= MOST * self.first && after[1].is_finite()) || self.entries.iter().any(barred) {
            return None;
        }
        let [slope_power, violation_power] = POWERS;
        let switches = slope < 0.0 && alpha * (-slope).powf(slope_power) > before[0].powf(violation_power);
        if switches && before[0] <= LEAST * self.first {
            let enough = after[1] <= before[1] + sufficient * alpha * slope + rounding;
            return enough.then_some(Accepted::Descent);
        }
        let progresses = after[0] <= (1.0 - PROGRESS) * before[0] || after[1] <= before[1] - PROGRESS * before[0];
        progresses.then_some(Accepted::Progress)
    }

    /// Adds the point before a step that was taken.
    pub fn add(&mut self, [violation, merit]: [f64; 2]) {
        let entry = [(1.0 - PROGRESS) * violation, merit - PROGRESS * violation];
        self.entries.retain(|known| known[0] < entry[0] || known[1] < entry[1]);
        self.entries.push(entry);
    }
}

impl Iterate {
    /// The violations of the equalities, then of the equations of hard rows.
    pub(super) fn violations(&self, h: &[f64]) -> impl Iterator<Item = f64> {
        let held = self.equalities.iter().map(|held| h[held.row.at].abs());
        held.chain(self.working.iter().filter(|of| of.row.is_hard).map(|of| of.elastic))
    }

    /// The sum of these violations.
    pub fn violation(&self, h: &[f64]) -> f64 {
        self.violations(h).sum()
    }
}
