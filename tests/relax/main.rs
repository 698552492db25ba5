//! The relaxation: minima, constraints, running costs and free ends.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod constrained;
mod free_end;
mod minima;
mod objective;
mod running_cost;
mod segments;
