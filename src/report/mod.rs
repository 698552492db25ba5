//! What a user sees of a result: tables and files.

mod files;
pub mod prove;
mod table;

pub use files::{write_json, write_outcome, write_text};
pub use table::{check_table, robot_table, summary_table, verdict_table};
