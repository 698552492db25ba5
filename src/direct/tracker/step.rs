//! The result of a step.

use super::Command;

/// The result of a step.
#[derive(Debug)]
pub struct Step<'t> {
    /// The outcome of the motion so far.
    pub outcome: Outcome,
    /// The command for now.
    pub command: &'t Command,
    /// The safety of the plan that the command follows.
    pub safety: Safety,
    /// The largest distance of a joint from the plan, rad or m.
    pub deviation: f64,
    /// The number of iterations of the search.
    pub iterations: usize,
    /// True if the plan is a new one.
    pub replaced: bool,
    /// True if the deadline ended the search of this step.
    pub cut_off: bool,
    /// True if further iterations would change nothing.
    pub converged: bool,
}

/// The outcome of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The motion continues, or has no plan to the goal yet.
    Working,
    /// The plan has ended at the goal; the command holds it there.
    Finished,
}

/// The safety of the rest of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Safety {
    /// The rest keeps all current rows, to its end.
    Kept,
    /// The rest violates a row.
    Violated {
        /// The row that is violated most, as in [`Violation::row`](crate::motion::Violation).
        row: usize,
        /// The violation of the row, see [`Constraints::excess`](crate::constraint::Constraints::excess).
        by: f64,
        /// The time until then, s.
        after: f64,
    },
    /// The robot is farther from the plan than the
    /// [largest deviation](super::TrackerOptions::largest_deviation).
    Left,
}
