//! Sweeps: scenarios solved with every combination of parameters, stored so that they resume, and ranked.

mod columns;
mod definition;
mod identity;
mod ranking;
mod results;
mod row;
mod run;

pub use columns::write_parquet;
pub use definition::{ParameterSet, Parameters, Shard, Sweep, SweepFile, builtin_sweeps};
pub use ranking::{Ranked, best, ranking, ranking_of, ranking_table, write_ranking};
pub use results::{Results, merge, shard_files};
pub use row::{Row, RowOutcome};
pub use run::run;
