//! Problems as files, and what came of solving them.

mod builtin;
mod file;
mod outcome;

pub use builtin::builtin_scenarios;
pub use file::{
    FlowParameters, Scenario, ScenarioFile, SphereObstacle, load_robot, load_robot_with,
};
pub use outcome::{Method, Outcome, SolveOptions, Summary, solve};
