//! The keys of a scenario, each group with its meaning and its checks.

pub(crate) mod clearance;
pub(crate) mod durations;
pub(crate) mod flow_parameters;
pub(crate) mod goal;
pub(crate) mod group;
pub(crate) mod joint_limits;
pub(crate) mod json;
pub(crate) mod keep;
pub(crate) mod limits;
pub(crate) mod losses;
pub(crate) mod notes;
pub(crate) mod objective;
pub(crate) mod obstacles;
pub(crate) mod passive;
pub(crate) mod patch;
pub(crate) mod payload;
pub(crate) mod period;
pub(crate) mod phases;
pub(crate) mod rate_limits;
pub(crate) mod scenario_file;
pub(crate) mod schema;
pub(crate) mod stand;
pub(crate) mod turns;
pub(crate) mod upgrade;
pub(crate) mod waypoints;
pub(crate) mod yaml;
