//! Experiments: grids of parameters, effort against degree, and those of the paper.

mod degree_study;
pub mod reproduce;
pub mod sweep;

pub use degree_study::{Size, SizeRow, by_size, size_table, write_sizes};
