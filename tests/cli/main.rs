//! The command line.

#[path = "../command/mod.rs"]
mod command;

mod bad_input;
mod check;
mod eval;
mod files;
mod robots;
mod solve;
mod sweep;
