//! The program `aghf` and its parts: commands, tables and files of results, the report page, sweeps and benchmarks.

pub mod benchmark;
pub mod commands;
pub mod doctor;
pub mod export;
pub mod guide;
pub mod output;
pub mod report;
pub mod sweep;
