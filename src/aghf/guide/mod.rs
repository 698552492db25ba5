//! How to extend the mathematics, with examples that are compiled and run as tests.

#[doc = include_str!("your_own_jacobian.md")]
pub mod your_own_jacobian {}

#[doc = include_str!("your_own_lagrangian.md")]
pub mod your_own_lagrangian {}

#[doc = include_str!("your_own_constraint.md")]
pub mod your_own_constraint {}
