//! What a user sees of a result: tables and files.

mod degrees;
mod files;
pub mod prove;
pub mod reproduce;
pub mod sweep;
mod table;

pub use degrees::{Size, SizeRow, by_size, size_table, write_sizes};
pub use files::{write_json, write_outcome, write_text};
pub use table::{check_table, robot_table, scenario_table, summary_table, verdict_table};
