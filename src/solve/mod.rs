//! From a problem to a trajectory: the flow, what control it takes, and whether that control does it.

mod control;
mod flow;
mod integrate;
mod problem;
pub mod relax;
mod simulate;

pub use control::{Effort, Sample, control_at, measure, sample};
pub use flow::{
    FlowFailure, FlowOutcome, FlowRecord, FlowSettings, FlowSolution, flow, flow_constrained,
    flow_with, output_count,
};
pub use integrate::{Failure, NonFinite, Ode, STEP_LIMIT, Statistics, Tolerance, integrate};
pub use problem::{Guess, Problem};
pub use relax::{
    Adapted, FreeHorizon, Iteration, RelaxSettings, RelaxSolution, Requirements, RunningCost,
    relax, relax_constrained, relax_constrained_with, relax_with,
};
pub use simulate::{Feedback, Simulation, replay_error, simulate};
