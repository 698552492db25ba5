#![doc = include_str!("keys.md")]

mod builtin;
mod feasibility;
mod file;
mod generate;
mod objective;
mod options;
mod outcome;
mod summary;
mod surroundings;
pub mod sweep;

pub use builtin::builtin_scenarios;
pub use feasibility::{Feasibility, Limit, LimitViolation};
pub use file::{
    EnforcedLimits, FlowParameters, HalfSpaceObstacle, RobotShape, Scenario, ScenarioFile,
    SphereObstacle, load_robot, load_robot_with,
};
pub use generate::{FAMILIES, Family, generate, generated_scenarios};
pub use objective::{HorizonBounds, PerJoint, RunningCostWeights};
pub use options::{Method, SolveOptions};
pub use outcome::{Outcome, Record, solve};
pub use summary::{Details, FlowDetails, RelaxDetails, Summary};
pub use surroundings::Surroundings;
