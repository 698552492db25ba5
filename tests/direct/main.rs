//! The direct method: minima, constraints, running costs and free ends.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod composition;
mod constrained;
mod free_end;
mod goal;
mod interrupt;
mod minima;
mod multistart;
mod objective;
mod own_cost;
mod running_cost;
mod segments;
mod stage;
