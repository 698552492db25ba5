//! How to extend the mathematics, with examples that are compiled and run as tests.

#[doc = include_str!("jacobian.md")]
pub mod jacobian {}

#[doc = include_str!("lagrangian.md")]
pub mod lagrangian {}

#[doc = include_str!("constraint.md")]
pub mod constraint {}
