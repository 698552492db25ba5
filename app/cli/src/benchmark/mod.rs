//! A benchmark of planning problems, each solved and judged, by family.
//!
//! [`problems()`] finds the problems in a folder, scenarios or MoveIt's scenes and requests; [`run()`] solves them one
//! by one on one core and writes one line per problem, so that an interrupted run is resumed; [`families`] summarises
//! the results.

mod problems;
mod run;
mod summary;

pub use problems::{Problem, problems};
pub use run::{End, Row, run};
pub use summary::{Family, families, table};
