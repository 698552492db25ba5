//! The schedule of barrier weights, prices and duals between minimisations.

use super::barrier::Barrier;
use super::row::Kind;
use super::search::Search;
use crate::constraint::Constraint;
use crate::relax::CostWithControl;
use crate::relax::transcription::Peak;
use crate::relax::tuning::{
    AT_THE_PRICE, BARRIER_DONE, BARRIER_FACTOR, LARGEST_PRICE, NEARLY, PRICE_FACTOR, SMALLEST_COST,
};

impl<K: Constraint, P: CostWithControl> Search<'_, '_, K, P> {
    /// The weight of the barriers of all rows over the whole horizon.
    pub(super) fn total_barrier(&mut self) -> f64 {
        let cost = self.objective.cost_mut();
        cost.barrier.mu * cost.mean_count() * self.horizon
    }

    /// Returns true at the last weight of the barriers of all rows together.
    pub(super) fn is_last_barrier(&mut self, cost: f64) -> bool {
        let weak =
            self.total_barrier() <= NEARLY * self.stage.last_barrier * cost.max(SMALLEST_COST);
        weak && self.objective.cost_mut().largest_relaxation() == 0.0
    }

    /// Reduces the barrier weight if the last step, which predicted a decrease of `promised`, leaves little to gain;
    /// returns true if it did.
    pub(super) fn reduce_barrier(&mut self, promised: f64) -> bool {
        let (horizon, last) = (self.horizon, self.stage.last_barrier);
        let cost = self.objective.cost_mut();
        let all = cost.mean_count() * horizon;
        let Barrier { mu, nu } = cost.barrier;
        if promised > BARRIER_DONE * mu * all {
            return false;
        }
        let least = last * cost.cost.max(SMALLEST_COST) / all;
        if mu <= NEARLY * least {
            return false;
        }
        let mu = (BARRIER_FACTOR * mu).max(least);
        cost.set_barrier(Barrier { mu, nu });
        self.update_duals();
        true
    }

    /// Updates the duals of the equalities at the current point.
    pub(super) fn update_duals(&mut self) {
        let (horizon, feasible) = (self.horizon, self.stage.feasible);
        let cost = self.objective.cost_mut();
        cost.update_duals(feasible, cost.cost.max(SMALLEST_COST) / horizon);
    }

    /// Raises the price of an excess; returns false if it is the highest already.
    pub(super) fn raise_price(&mut self) -> bool {
        let horizon = self.horizon;
        let cost = self.objective.cost_mut();
        let Barrier { mu, nu } = cost.barrier;
        let density = cost.cost.max(SMALLEST_COST) / horizon;
        let higher = (nu * PRICE_FACTOR).min(LARGEST_PRICE * density);
        if higher <= nu {
            return false;
        }
        cost.set_barrier(Barrier { mu, nu: higher });
        true
    }

    /// Returns true if a row may be violated because its multiplier has reached the price.
    pub(super) fn is_priced(&mut self) -> bool {
        let cost = self.objective.cost_mut();
        let most = AT_THE_PRICE * cost.barrier.nu;
        let mut rows = cost.multipliers.iter().zip(&cost.kinds);
        rows.any(|(z, kind)| *kind == Kind::Inequality && *z > most)
    }

    /// Increases the margins of rows that are violated between the points, or the price if rows are violated because of
    /// it; returns false if neither is possible.
    pub(super) fn mend(&mut self, peaks: &[Peak]) -> bool {
        if self.objective.cost_mut().largest_equality() > self.stage.feasible {
            self.update_duals();
            return true;
        }
        // What is broken because that is cheap says nothing of what is between the points.
        if self.is_priced() {
            return self.raise_price();
        }
        self.set_margins(peaks, true);
        true
    }

    /// Sets margins from the peaks of the rows between the points.
    pub(super) fn set_margins(&mut self, peaks: &[Peak], end: bool) {
        let cost = self.objective.cost_mut();
        cost.set_margins(self.grid, peaks, end);
        cost.set_barrier(cost.barrier);
    }
}
