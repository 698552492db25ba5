//! The command line.

#[path = "../command/mod.rs"]
mod command;

mod bad_input;
mod benchmark;
mod bounds;
mod check;
mod eval;
mod import;
mod import_refused;
mod input;
mod judge;
mod output;
mod readme;
mod robots;
mod scenarios;
mod signals;
mod solve;
mod sweep;
mod view;
