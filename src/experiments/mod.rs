//! Experiments: parameter sweeps, effort against degree, the paper's experiments, and benchmarks of planning problems.

pub mod benchmark;
mod degree_study;
pub mod reproduce;
pub mod sweep;

pub use degree_study::{Size, SizeRow, by_size, size_page, size_table, write_sizes};
