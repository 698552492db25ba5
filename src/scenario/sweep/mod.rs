//! Grid searches over the parameters of a method, as in the paper's Tables IX to XIII.

mod definition;
mod identity;
mod row;
mod run;

pub use definition::{ParameterSet, Parameters, Shard, Sweep, SweepFile, builtin_sweeps};
pub use row::{Row, RowOutcome};
pub use run::run;
