//! Constraints and their derivatives.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod derivatives;
mod violations;
