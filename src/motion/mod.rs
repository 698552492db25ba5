//! What a motion is: the boundary value problem, the control that a curve takes, and whether that control does it.

mod control;
mod problem;
mod simulate;

pub(crate) use control::samples_at;
pub use control::{Sample, control_at, sample};
pub use problem::{Guess, Problem};
pub use simulate::{Feedback, Simulation, replay_error, simulate, simulate_with};
