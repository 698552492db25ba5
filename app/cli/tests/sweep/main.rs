//! Sweeps: their files, their runs and their tables.

mod direct;
mod files;
mod refused;
mod results;
mod run;
