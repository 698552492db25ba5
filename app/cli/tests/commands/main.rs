//! The command line.

#[path = "../command/mod.rs"]
mod command;

mod benchmark;
mod certify;
mod check;
mod doctor;
mod doctor_numbers;
mod eval;
mod export;
mod ik;
mod import;
mod input;
mod judge;
mod output;
mod pages;
mod pairs;
mod readme;
mod refused;
mod robots;
mod scenarios;
mod signals;
mod solve;
mod sweep;
mod tradeoff;
mod view;
