//! Sweeps: their files, their runs and their tables.

mod files;
mod refused;
mod relax;
mod run;
