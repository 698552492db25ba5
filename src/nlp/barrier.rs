//! The barrier parameter and its update.

use super::{Options, Progress, Row, RowState, State};
use std::fmt::Debug;

/// The least first slack of a hard row: 1e-2 as in WB (3.6).
const FIRST_SLACK: f64 = 1e-2;

/// The parameters of the barrier function.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Barrier {
    /// The barrier parameter $\mu$.
    pub mu: f64,
    /// The least penalty $\nu$ of a violation.
    pub nu: f64,
}

/// An iterate as a rule of the barrier parameter sees it. All values are relative to the objective, and sums over the
/// rows have their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarrierState {
    /// The barrier parameter summed over all rows, $\sum_j w_j \mu$.
    pub mu: f64,
    /// The complementarity $\sum_j w_j s_j z_j$ of slacks and multipliers, which is `mu` on the central path.
    pub complementarity: f64,
    /// The decrease of the barrier function that the direction of the last step predicts, without the multiple of the
    /// norm in the Hessian and at most up to the [longest step](Options::longest_step): a short step does not show that
    /// the minimum is near.
    pub decrease: f64,
    /// The fraction of that step that was taken: more than 1 along negative curvature.
    pub alpha: f64,
    /// True if there are equalities.
    pub has_equalities: bool,
    /// The number of iterations since the barrier function last decreased by more than `mu`.
    pub stalled: usize,
}

impl BarrierState {
    /// The state after a step that predicted this decrease.
    pub(super) fn after(state: &State, decrease: f64, options: &Options) -> Self {
        let Progress { step, .. } = state.progress;
        let curvature = state.progress.curvature();
        let longest = options.longest_step / step;
        let further = if longest.is_finite() && curvature * longest < 1.0 { longest } else { 1.0 / curvature };
        let decrease = if further > 1.0 { further * decrease } else { decrease };
        let scale = state.scale();
        Self {
            mu: state.complementarity(),
            complementarity: state.measure * state.iterate.gap() / scale,
            decrease: decrease / scale,
            alpha: state.progress.alpha,
            has_equalities: !state.iterate.equalities.is_empty(),
            stalled: state.stalled,
        }
    }
}

/// A rule by which the barrier parameter changes.
pub trait BarrierUpdate: Debug + Send + Sync {
    /// Returns true if the barrier problem is solved well enough after a step. It also counts as solved if no step
    /// decreases the barrier function.
    fn is_solved(&self, state: &BarrierState) -> bool;

    /// The next barrier parameter, summed over all rows and relative to the objective like [`BarrierState::mu`]. The
    /// [last one](Options::last_barrier) takes its place if it is less.
    fn next(&self, state: &BarrierState) -> f64;
}

/// The monotone rule of Fiacco and McCormick: $\mu \leftarrow \min(\kappa \mu, \mu^\theta)$, relative to the objective
/// (WB 7).
#[derive(Clone, Debug, PartialEq)]
pub struct Monotone {
    /// The linear factor $\kappa$ of a reduction: 0.2 as in WB.
    pub factor: f64,
    /// The exponent $\theta$ of a superlinear reduction: 1.5 as in WB.
    pub power: f64,
    /// The predicted decrease, relative to the barrier parameter summed over all rows, below which that parameter is
    /// reduced, without and with equalities: along these less accurate minima lead to others, and walks on a free
    /// horizon to none.
    pub done: [f64; 2],
    /// The number of iterations without a decrease by more than that parameter after which it is also reduced, if there
    /// are no equalities: a step may decrease their violation alone. Rows with kinks, such as the distance of two
    /// covers, keep the predicted decrease large where steps across them are short (tuned on 53 problems of Fetch, UR5,
    /// Baxter and Panda: 5 or 15 gain half as much or less; 18 of a UR5 with its meshes take a fifth fewer iterations).
    pub stalled: usize,
}

impl Default for Monotone {
    fn default() -> Self {
        Self { factor: 0.2, power: 1.5, done: [1.0, 0.1], stalled: 8 }
    }
}

impl BarrierUpdate for Monotone {
    fn is_solved(&self, state: &BarrierState) -> bool {
        let done = self.done[usize::from(state.has_equalities)];
        let stalled = !state.has_equalities && state.stalled >= self.stalled;
        state.decrease <= done * state.mu || stalled
    }

    fn next(&self, state: &BarrierState) -> f64 {
        (self.factor * state.mu).min(state.mu.powf(self.power))
    }
}

impl Barrier {
    /// The slack and the elastic variable that minimise the barrier function for a value of the row.
    pub fn split(&self, row: &Row, h: f64, nu: f64) -> [f64; 2] {
        // The minimum is that of one penalty for the sum of both.
        let mu = if row.is_equality { self.mu } else { 2.0 * self.mu };
        let product = h * nu;
        let root = product.hypot(mu);
        // The root less the product and the root and the product, none of which loses digits.
        let large = root + product.abs();
        let small = mu * (mu / large);
        let (less, more) = if product > 0.0 { (small, large) } else { (large, small) };
        [(mu + less) * 0.5 / nu, (mu + more) * 0.5 / nu]
    }

    /// The state of a row with a value, as [`split`](Self::split), and the more accurate one of two multipliers.
    pub fn central(&self, row: Row, h: f64, nu: f64) -> RowState {
        let mu = self.mu;
        if row.is_hard {
            let slack = (-h).max(FIRST_SLACK);
            return RowState { row, slack, elastic: h + slack, multiplier: mu / slack, penalty: f64::INFINITY };
        }
        let [slack, elastic] = self.split(&row, h, nu);
        let state = RowState { row, slack, elastic, multiplier: 0.0, penalty: nu };
        let multiplier = if slack > elastic { state.least() + mu / slack } else { nu - mu / elastic };
        RowState { multiplier, ..state }
    }

    /// The parameters for a barrier parameter summed over all rows and relative to the objective.
    pub(super) fn of_total(total: f64, state: &State, options: &Options) -> Self {
        Self {
            mu: total.max(options.last_barrier) * state.scale() / state.total_weight(),
            // The objective may have been zero at the start.
            nu: (options.penalty * state.scale() / state.measure).max(state.iterate.barrier.nu),
        }
    }
}
