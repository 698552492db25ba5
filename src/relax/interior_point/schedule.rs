//! How barriers, prices and duals go on from one minimum to the next.

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

    /// Tells whether the barriers of all rows together are as weak as they have to be in the end.
    pub(super) fn is_last_barrier(&mut self, cost: f64) -> bool {
        let weak =
            self.total_barrier() <= NEARLY * self.stage.last_barrier * cost.max(SMALLEST_COST);
        weak && self.objective.cost_mut().largest_relaxation() == 0.0
    }

    /// A weaker barrier if a step that promised so much leaves little to gain by the next; says whether it is.
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

    /// The duals of equalities that where the search stands asks for.
    pub(super) fn update_duals(&mut self) {
        let (horizon, feasible) = (self.horizon, self.stage.feasible);
        let cost = self.objective.cost_mut();
        cost.update_duals(feasible, cost.cost.max(SMALLEST_COST) / horizon);
    }

    /// A higher price of an excess, unless it is the highest already.
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

    /// Tells whether a row may be broken because its multiplier is at the price.
    pub(super) fn is_priced(&mut self) -> bool {
        let cost = self.objective.cost_mut();
        let most = AT_THE_PRICE * cost.barrier.nu;
        let mut rows = cost.multipliers.iter().zip(&cost.kinds);
        rows.any(|(z, kind)| *kind == Kind::Inequality && *z > most)
    }

    /// Larger margins for rows that are broken between the points, or a higher price of an excess where rows are broken because
    /// they may be; returns false if neither is possible.
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

    /// Margins from a look between the points.
    pub(super) fn set_margins(&mut self, peaks: &[Peak], end: bool) {
        let cost = self.objective.cost_mut();
        cost.set_margins(self.grid, peaks, end);
        cost.set_barrier(cost.barrier);
    }
}
