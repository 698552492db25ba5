//! Constraints and their derivatives.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod composition;
mod derivatives;
mod violations;
