//! The barrier parameter and its update.

use super::{Options, State};

/// The parameters of the barrier function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// The barrier parameter $\mu$.
    pub mu: f64,
    /// The penalty $\nu$ of a violation.
    pub nu: f64,
}

/// A rule by which the barrier parameter decreases.
pub(crate) trait BarrierUpdate {
    /// Returns true if the barrier problem is solved well enough after a step that predicted this decrease.
    fn is_solved(&self, state: &State, decrease: f64) -> bool;

    /// The next parameters.
    fn next(&self, state: &State) -> Barrier;
}

/// The monotone rule of Fiacco and McCormick: $\mu \leftarrow \min(\kappa \mu, \mu^\theta)$, relative to the objective
/// (WB 7).
#[derive(Clone, Debug)]
pub(crate) struct Monotone {
    options: Options,
}

impl Monotone {
    pub fn new(options: &Options) -> Self {
        let options = options.clone();
        Self { options }
    }
}

impl BarrierUpdate for Monotone {
    fn is_solved(&self, state: &State, decrease: f64) -> bool {
        decrease <= self.options.barrier_done * state.iterate.barrier.mu * state.total_weight()
    }

    fn next(&self, state: &State) -> Barrier {
        let (options, now) = (&self.options, state.complementarity());
        let next = (options.barrier_factor * now).min(now.powf(options.barrier_power));
        let next = next.max(options.last_barrier);
        Barrier {
            mu: next * state.scale() / state.total_weight(),
            // The objective may have been zero at the start.
            nu: (options.penalty * state.scale() / state.measure).max(state.iterate.barrier.nu),
        }
    }
}
