//! A trial step and its effect on the rows.

use super::barrier_cost::BarrierCost;
use super::near::Near;
use super::row::Kind;
use crate::constraint::Constraint;
use crate::relax::CostWithControl;
use crate::relax::tuning::{SMALLEST_RELAXATION, TO_THE_WALL};

/// The trial of a fraction of a step from one iterate to another.
///
/// Slacks are independent iterates: along a step they change linearly, from their initial value to the one that the
/// rows have after the full step. If a row has less slack than this at the end of the fraction, the difference becomes
/// its relaxation; if it has more, the slack grows.
#[derive(Clone, Debug, Default)]
pub(super) struct Trial {
    /// The rows before the step and after the full step.
    pub before: Vec<f64>,
    pub whole: Vec<f64>,
    /// The rows with a term before the step.
    pub near: Near,
    pub share: f64,
    /// The relaxations at the end of the fraction, and their cost at the price of an excess.
    pub relaxations: Vec<f64>,
    pub price: f64,
}

impl Trial {
    /// A row with its margin, minus its relaxation.
    pub fn row(&mut self, at: usize, raw: f64) -> f64 {
        let before = self.before[at];
        let even = before + self.share * (self.whole[at] - before);
        let h = if before < 0.0 && even < 0.0 {
            raw.min(even.max(0.01 * before))
        } else {
            raw
        };
        let relaxation = raw - h;
        self.relaxations[at] = if relaxation < SMALLEST_RELAXATION {
            0.0
        } else {
            relaxation
        };
        raw - self.relaxations[at]
    }
}

impl<K: Constraint, P: CostWithControl> BarrierCost<'_, K, P> {
    /// Begins a trial; the current rows are those before the step.
    pub(super) fn begin(&mut self) {
        let trial = &mut self.trial;
        trial.before.clone_from(&self.h);
        trial.near.clone_from(&self.near);
        trial.whole.clear();
        trial.whole.resize(self.h.len(), f64::INFINITY);
        trial.relaxations.clone_from(&self.relaxations);
        self.trying = true;
        self.try_share(1.0);
    }

    /// Returns, after an evaluation at the end of the full step, the largest fraction of it that leaves every interior
    /// row in the interior.
    pub(super) fn end_of_whole(&mut self) -> f64 {
        let mut share = 1.0_f64;
        self.trial.whole.clone_from(&self.h);
        for (at, _) in self.near.places() {
            let (h, before) = (self.h[at], self.trial.before[at]);
            let inside = self.kinds[at] == Kind::Inequality && before < 0.0;
            if inside && h > (1.0 - TO_THE_WALL) * before {
                share = share.min(TO_THE_WALL * before / (before - h));
            }
        }
        share
    }

    /// Evaluates a fraction of the step.
    pub(super) fn try_share(&mut self, share: f64) {
        (self.trial.share, self.trial.price) = (share, 0.0);
    }

    /// The price of the relaxations of the trial.
    pub(super) fn trial_price(&self) -> f64 {
        self.trial.price
    }

    /// Accepts the trial as the iterate, with the multipliers predicted by the full step, safeguarded by the final
    /// rows.
    pub(super) fn accept(&mut self) {
        let known = std::mem::take(&mut self.multipliers);
        self.multipliers.resize(known.len(), 0.0);
        for (at, row) in self.near.places() {
            let (before, whole) = (self.trial.before[at], self.trial.whole[at]);
            let terms = self.terms();
            self.multipliers[at] = match (terms.at(at, row, before), terms.at(at, row, self.h[at]))
            {
                (Some(from), Some(to)) => {
                    let curvature = from.rate(known[at]);
                    to.safeguarded(from.multiplier() + curvature * (whole - before))
                }
                (None, Some(to)) => to.multiplier(),
                (_, None) => 0.0,
            };
        }
        self.relaxations.copy_from_slice(&self.trial.relaxations);
        self.trying = false;
    }

    /// Rejects the trial and restores the rows before it.
    pub(super) fn reject(&mut self) {
        std::mem::swap(&mut self.h, &mut self.trial.before);
        std::mem::swap(&mut self.near, &mut self.trial.near);
        self.trying = false;
    }

    /// The price of the relaxations, the part of it that the barriers recover, and the work of the push along the trial
    /// step.
    pub(super) fn price_of_relaxations(&self) -> [f64; 3] {
        let (count, trial, mut sums) = (self.rows.count(), &self.trial, [0.0; 3]);
        for (at, row) in trial.near.places() {
            let r = &self.relaxations[at];
            if *r > 0.0 {
                let w = self.weights[at / count % self.weights.len()];
                let before = trial.before[at];
                let Some(term) = self.terms().at(at, row, before) else {
                    continue;
                };
                // What the row itself changed by.
                let change = trial.whole[at] - before - r;
                sums[0] += w * self.barrier.nu * r;
                sums[1] += w * term.slope() * r;
                sums[2] += w * term.curvature(self.multipliers[at]) * r * change;
            }
        }
        sums
    }
}
