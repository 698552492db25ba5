//! The direct method: minima, constraints and free ends; running costs; the transcription.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod composition;
mod constrained;
mod fixed_ends;
mod free_end;
mod goal;
mod interrupt;
mod minima;
mod multistart;
mod options;
mod parts;
mod period;
mod running_cost;
mod segments;
mod stage;
mod tracker;
mod waypoint;

#[path = "../cost"]
mod cost {
    mod chain_rule;
    mod composition;
    mod in_phases;
    mod packed_hessian;
    mod point_cost;
}

#[path = "../linalg"]
mod linalg {
    mod block_tridiagonal;
}

#[path = "../transcription"]
mod transcription {
    mod equality_gradients;
    mod horizons;
    mod objective;
    mod proximity_cache;
}
