#![doc = include_str!("keys.md")]
#![doc = include_str!("scenario_keys.md")]

/// The code of the README, run as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
mod readme {}

mod builtin;
pub mod certify;
mod file;
mod generate;
pub mod guide;
pub mod judge;
mod keys;
mod load;
mod moveit;
mod options;
mod promise;
mod results;
mod shapes;
mod solve;

pub use aghf::constraint::Quantity;
pub use builtin::builtin_scenarios;
pub use file::{Scenario, sha256};
pub use generate::{FAMILIES, Family, generate, generate_for, generated_scenarios, is_generated};
pub use keys::clearance::{Clearance, Clearances, PairClearance};
pub use keys::flow_parameters::FlowParameters;
pub use keys::goal::{AxisDirection, Goal, PositionBox};
pub use keys::keep::{Kept, PointSpeed};
pub use keys::limits::{Enforced, EnforcedLimits};
pub use keys::losses::{JointNumbers, LossNumbers, Losses};
pub use keys::objective::{Continuous, HorizonBounds, Objective, ObjectiveWeights, PerJoint, Preset, Units};
pub use keys::obstacles::{Obstacle, ObstacleShape, Pose, RobotShape, SelfCollision};
pub use keys::passive::{PASSIVE_TORQUE_SHARE, effort_of_joints};
pub use keys::payload::Payload;
pub use keys::phases::WalkPhase;
pub use keys::rate_limits::{RateLimits, Urdf};
pub use keys::scenario_file::ScenarioFile;
pub use keys::schema::{DescribedOption, described_options, option_keys, scenario_keys, scenario_schema};
pub use keys::stand::{FootLoad, Stand};
pub use keys::start_tolerance::StartTolerance;
pub use keys::turns::Turns;
pub use keys::waypoints::PointOnTheWay;
pub use load::LoadOptions;
pub use moveit::{MoveIt, MoveItHorizon, moveit_fields};
pub use options::{DirectOptions, FlowOptions, Method, RestOptions, SolveOptions};
pub use promise::{Promise, Scope, promise_in_words};
pub use results::curve_file::CurveFile;
pub use results::feasibility::{Acceleration, Feasibility, LimitShare, LimitViolation, Nearest};
pub use results::joint_trajectory::{Header, JointTrajectory, JointTrajectoryPoint, Stamp};
pub use results::provenance::{Provenance, Solved};
pub use results::report::{Record, Solve, SolveReport, Trace};
pub use results::summary::{
    Details, DirectDetails, FlowDetails, HorizonBound, ReachedEnd, RestDetails, Summary, Verdict,
};
pub use shapes::robot_shape::{ShapeParts, link_shapes, parts_of_shapes, shape_parts};
pub use shapes::self_collision::{IgnoredPair, IgnoredPairs, always_overlapping};
pub use solve::custom_terms::SharedCost;
pub use solve::preflight::least_horizon;
pub use solve::tracker::{ScenarioTracker, ScenarioTrackerOptions};
pub use solve::tradeoff::Tradeoff;
pub use solve::walk::{Landing, Walk};
pub use solve::warm_start::MultipliersFile;
