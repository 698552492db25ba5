//! The command line.

#[path = "../command/mod.rs"]
mod command;

mod bad_input;
mod benchmark;
mod bounds;
mod check;
mod eval;
mod files;
mod import;
mod import_refused;
mod input;
mod judge;
mod listings;
mod readme;
mod report;
mod robots;
mod signals;
mod solve;
mod sweep;
