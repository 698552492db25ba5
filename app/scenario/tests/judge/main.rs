//! The judge of trajectories.

#[macro_use]
#[path = "../../../../tests/common/mod.rs"]
mod common;

mod clearance;
mod ends;
mod foot;
mod gantry;
mod hermite;
mod intervals;
mod message;
mod poses;
mod rates;
mod reach;
mod robot;
mod rows;
mod torques;
mod trajectory;
mod verdict;
mod waypoints;
