//! What a user sees of a result: tables and files.

mod files;
mod table;

pub(crate) use files::write_whole;
pub use files::{write_json, write_report, write_text};
pub use table::{check_table, robot_table, scenario_table, summary_table, verdict_table};
pub(crate) use table::{short, table};
