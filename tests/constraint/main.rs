//! Constraints and their derivatives.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod composition;
mod derivatives;
mod self_clearance;
mod solids;
mod violations;
