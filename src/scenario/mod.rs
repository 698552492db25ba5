//! Problems as files, and what came of solving them.

mod builtin;
mod file;
mod outcome;
mod summary;

pub use builtin::builtin_scenarios;
pub use file::{FlowParameters, Scenario, ScenarioFile, SphereObstacle, load_robot};
pub use outcome::{Method, Outcome, Record, SolveOptions, solve};
pub use summary::{Details, FlowDetails, RelaxDetails, Summary};
