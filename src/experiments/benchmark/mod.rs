//! A benchmark of planning problems: each is solved and judged, family by family.
//!
//! [`problems`] finds what there is in a folder, scenarios or scenes and requests of MoveIt; [`run`] solves them one by one on one core and writes
//! a line for each, so that a run that was interrupted goes on where it was; [`families`] sums up.

mod problems;
mod run;
mod summary;

pub use problems::{Problem, problems};
pub use run::{End, Row, run, settings_of};
pub use summary::{Family, families, table};
