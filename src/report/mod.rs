//! What a user sees of a result: tables and files.

mod files;
pub mod prove;
pub mod reproduce;
mod table;

pub use files::{write_json, write_outcome};
pub use table::{check_table, robot_table, summary_table, verdict_table};
