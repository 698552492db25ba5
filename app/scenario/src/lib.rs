#![doc = include_str!("keys.md")]
#![doc = include_str!("scenario_keys.md")]

/// The code of the README, run as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
mod readme {}

mod builtin;
mod by_direct;
mod by_flow;
pub mod certify;
mod clearance;
mod compared_ends;
mod curve_file;
mod durations;
mod feasibility;
mod file;
mod flow_parameters;
mod generate;
mod goal;
mod goal_ends;
mod group;
pub mod guide;
mod joint_limits;
mod joint_trajectory;
mod json;
pub mod judge;
mod keep;
mod limits;
mod load;
mod losses;
mod moveit;
mod never_meeting;
mod notes;
mod objective;
mod obstacles;
mod options;
mod own_terms;
mod passive;
mod patch;
mod payload;
mod period;
mod phases;
mod preflight;
mod provenance;
mod rate_limits;
mod report;
mod robot_shape;
mod scenario_file;
mod scene;
mod schema;
mod search;
mod self_collision;
mod stand;
mod stopping;
mod summary;
mod tracker;
mod tradeoff;
mod turns;
mod units;
mod upgrade;
mod walk;
mod warm_start;
mod waypoints;
mod yaml;

pub use builtin::builtin_scenarios;
pub use clearance::{Clearance, Clearances, PairClearance};
pub use curve_file::CurveFile;
pub use feasibility::{Acceleration, Feasibility, Limit, LimitViolation, Nearest};
pub use file::{Scenario, sha256};
pub use flow_parameters::FlowParameters;
pub use generate::{FAMILIES, Family, generate, generate_for, generated_scenarios, is_generated};
pub use goal::{AxisDirection, Goal, PositionBox};
pub use joint_trajectory::{Header, JointTrajectory, JointTrajectoryPoint, Stamp};
pub use keep::{Kept, PointSpeed};
pub use limits::{Enforced, EnforcedLimits};
pub use load::LoadOptions;
pub use losses::{JointNumbers, LossNumbers, Losses};
pub use moveit::{MoveIt, MoveItHorizon, moveit_fields};
pub use objective::{
    Continuous, HorizonBounds, Objective, ObjectiveWeights, PerJoint, Preset, Units,
};
pub use obstacles::{Obstacle, ObstacleShape, Pose, RobotShape, SelfCollision};
pub use options::{DirectOptions, FlowOptions, Method, RestOptions, SolveOptions};
pub use own_terms::SharedCost;
pub use passive::{PASSIVE_TORQUE_SHARE, effort_of_joints};
pub use payload::Payload;
pub use phases::WalkPhase;
pub use preflight::least_horizon;
pub use provenance::{Provenance, Solved};
pub use rate_limits::{RateLimits, Urdf};
pub use report::{Record, Solve, SolveReport, Trace};
pub use robot_shape::{cover_each, cover_links, cover_shape, too_many_balls};
pub use scenario_file::ScenarioFile;
pub use schema::{DescribedOption, described_options, option_keys, scenario_keys, scenario_schema};
pub use self_collision::{IgnoredPair, IgnoredPairs, always_overlapping};
pub use stand::{FootLoad, Stand};
pub use summary::{
    Details, DirectDetails, FlowDetails, HorizonBound, ReachedEnd, RestDetails, Summary, Verdict,
};
pub use tracker::{ScenarioTracker, ScenarioTrackerOptions};
pub use tradeoff::Tradeoff;
pub use turns::Turns;
pub use walk::{Landing, Walk};
pub use warm_start::MultipliersFile;
pub use waypoints::PointOnTheWay;
