//! Scenario files, their solves and their verdicts.

#[macro_use]
#[path = "../../../../tests/common/mod.rs"]
mod common;

mod builtin;
mod by_flow;
mod clearance;
mod compared_ends;
mod custom_terms;
mod direct;
mod durations;
mod feasibility;
mod file;
mod goal;
mod goal_ends;
mod group;
mod joined;
mod joint_limits;
mod keep;
mod limits;
mod load;
mod locked;
mod losses;
mod moveit;
mod moveit_fields;
mod objective;
mod passive;
mod payload;
mod period;
mod phases;
mod preflight;
mod promise;
mod published_flow;
mod rate_limits;
mod refused;
mod report;
mod schema;
mod search;
mod self_collision;
mod stand;
mod start_tolerance;
mod stopping;
mod surroundings;
mod tracker;
mod tradeoff;
mod turns;
mod units;
mod upgrade;
mod walk;
mod warm_start;
mod waypoints;
mod written;

#[path = "../generate"]
mod generate {
    mod limits;
    pub mod seeds;
}
