//! Sweeps: scenarios solved with every combination of options and of keys of the scenario, with resumable results and a
//! ranking.

mod definition;
mod file;
mod grid;
mod motions;
mod page;
mod ranking;
mod results;
mod row;
mod run;
mod shard;

pub use definition::{ParameterSet, Problem, Sweep, builtin_sweeps};
pub use file::SweepFile;
pub use grid::{Grid, Parameter};
pub use motions::Motions;
pub use page::sweep_page;
pub use ranking::{Ranked, best, ranking, ranking_table, write_ranking};
pub use results::{Results, merge, shard_files, write_rows};
pub use row::{Row, RowOutcome};
pub(crate) use run::caught;
pub use run::run;
pub use shard::Shard;
