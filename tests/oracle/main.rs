//! The third witness: Pinocchio 4.1, other people's library, asked through Python. `tests/run` prepares it.

#[path = "../common/mod.rs"]
mod common;
mod compare;
mod constraints;
mod corpus;
mod flow;
mod limits;

mod python;
mod random;
