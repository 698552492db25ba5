//! The examples are programs that run, and the guide to a crate of one's own says what this one needs.

#[path = "../command/mod.rs"]
mod command;
mod programs;
mod your_crate;
