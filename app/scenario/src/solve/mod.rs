//! Searches for motions: the ends, the objective and its continuations, and the tracker.

pub(crate) mod by_direct;
pub(crate) mod by_flow;
pub(crate) mod compared_ends;
pub(crate) mod custom_terms;
pub(crate) mod goal_ends;
pub(crate) mod preflight;
pub(crate) mod search;
pub(crate) mod stopping;
pub(crate) mod tracker;
pub(crate) mod tradeoff;
pub(crate) mod units;
pub(crate) mod walk;
pub(crate) mod warm_start;
