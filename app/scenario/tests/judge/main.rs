//! The judge of trajectories.

#[macro_use]
#[path = "../../../../tests/common/mod.rs"]
mod common;

mod bounds;
mod clearances;
mod robot;
mod table;
mod verdict;
