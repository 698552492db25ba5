//! The motion: the boundary value problem, the control along a curve, the simulation of that control, and the
//! violations of constraints.

mod control;
mod interrupt;
mod path;
mod problem;
mod row_values;
mod simulate;
mod violations;

pub use control::samples_at;
pub use control::{Sample, control_at, sample};
#[cfg(feature = "solvers")]
pub(crate) use interrupt::Watch;
pub use interrupt::{Interrupt, Stopped};
pub(crate) use path::{Path, PathMemory, curve_of, path_of, states_at_nodes};
pub use problem::{Guess, Problem};
pub use simulate::{Feedback, Simulation, replay_error, simulate, simulate_with};
pub use violations::largest_torques;
pub use violations::passive_share;
pub(crate) use violations::{LargestRows, Motion};
pub use violations::{Violation, violations};
