//! Sweeps: scenarios solved with every combination of parameters, stored so that they resume, and ranked.

mod definition;
mod identity;
mod ranking;
mod results;
mod row;
mod run;

pub use definition::{ParameterSet, Parameters, Shard, Sweep, SweepFile, builtin_sweeps};
pub use ranking::{Ranked, best, ranking, ranking_of, ranking_table, write_ranking};
pub use results::{Results, merge, shard_files, write_rows};
pub use row::{Row, RowOutcome};
pub use run::run;
