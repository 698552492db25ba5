//! The results of a sweep: a file that survives interruptions, and tables made from it.

mod columns;
mod ranking;
mod results;

pub use columns::write_parquet;
pub use ranking::{Ranked, best, ranking, ranking_of, ranking_table, write_ranking};
pub use results::{Results, merge, shard_files};
