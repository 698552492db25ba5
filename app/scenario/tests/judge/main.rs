//! The judge of trajectories.

#[macro_use]
#[path = "../../../../tests/common/mod.rs"]
mod common;

mod clearance;
mod cubic;
mod foot;
mod gantry;
mod message;
mod poses;
mod reach;
mod robot;
mod rows;
mod trajectory;
mod verdict;
mod waypoints;
