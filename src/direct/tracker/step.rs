//! The result of a step.

use super::Command;

/// The result of a step.
#[derive(Debug)]
pub struct Step<'t> {
    /// Whether the motion has ended at the goal.
    pub outcome: Outcome,
    /// The command for now.
    pub command: &'t Command,
    /// Whether the plan that the command follows keeps all rows.
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

/// Whether a motion has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The motion goes on, or a goal is not planned for yet.
    Working,
    /// The plan has ended at the goal; the command holds it there.
    Finished,
}

/// Whether the rest of a plan keeps all rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Safety {
    /// It keeps all current rows, at all times.
    Kept,
    /// It violates a row.
    Violated {
        /// The row that is violated most, as in [`Violation::row`].
        row: usize,
        /// The violation, in the unit of the row.
        by: f64,
        /// The time until then, s.
        after: f64,
    },
    /// The robot is farther from the plan than the [largest deviation](TrackerOptions::largest_deviation).
    Left,
}
