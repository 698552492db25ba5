//! Comparison with other libraries: Pinocchio 4.1 for the dynamics, called through Python, which `tests/run` prepares,
//! and Parry for distances.

#[path = "../common/mod.rs"]
mod common;
mod compare;
mod constraints;
mod corpus;
mod distances;
mod flow;
mod limits;

mod python;
mod random;
