//! Problems as files, and what came of solving them.

mod builtin;
mod feasibility;
mod file;
mod generate;
mod outcome;
mod surroundings;
pub mod sweep;

pub use builtin::builtin_scenarios;
pub use feasibility::{Feasibility, Limit, LimitViolation};
pub use file::{
    EnforcedLimits, FlowParameters, HalfSpaceObstacle, RobotShape, Scenario, ScenarioFile,
    SphereObstacle, load_robot, load_robot_with,
};
pub use generate::{FAMILIES, Family, generate, generated_scenarios};
pub use outcome::{Method, Outcome, SolveOptions, Summary, solve};
pub use surroundings::Surroundings;
