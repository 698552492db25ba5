//! How to ask the relaxation for another motion, with an example that is compiled and run as a test.

#[doc = include_str!("your_own_running_cost.md")]
pub mod your_own_running_cost {}
