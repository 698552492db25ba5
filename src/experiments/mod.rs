//! Experiments: parameter sweeps, and benchmarks of planning problems.

pub mod benchmark;
pub mod sweep;
