//! Constraints and their derivatives.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod active_pair;
mod composition;
mod convex_clearance;
mod derivatives;
mod dynamic;
mod frame_rows;
mod pair_distance;
mod phase;
mod point_speed;
mod power_limits;
mod self_clearance;
mod solid_clearance;
mod stage;
mod standing_foot;
mod time_window;
