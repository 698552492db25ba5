//! The presentation of results: tables and files.

mod certification;
mod evaluation;
mod files;
mod folder;
mod json;
mod judgement;
mod results_file;
mod rows;
mod table;
mod tradeoff;
mod trajectory;
mod walk;

pub use certification::{certification_text, table_difference_text};
pub use evaluation::{Evaluation, evaluate};
pub(crate) use files::write_whole;
pub use files::{remove_unfinished, write_text};
pub use folder::{OutputFolder, refuse_existing};
pub use json::write_json;
pub use judgement::{judgement_table, verdict};
pub(crate) use results_file::line_error;
pub use results_file::{ResultsFile, complete_lines};
pub use rows::csv_of;
pub(crate) use rows::{cost_of, csv_cell, minimised, one_line};
pub use table::{check_table, configurations_table, robot_table, scenario_table, summary_table, verdict_table};
pub(crate) use table::{short, summary_rows, table};
pub use tradeoff::{TradeoffRow, tradeoff_rows, tradeoff_table, write_tradeoff};
pub(crate) use trajectory::failure_comment;
pub use trajectory::{REPORT_FILES, Sampling, write_report, write_table, write_trajectory};
pub use walk::walk_table;
