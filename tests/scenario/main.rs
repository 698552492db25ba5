//! Scenarios and sweeps.

#[path = "../command/mod.rs"]
mod command;

mod best_known;
mod feasibility;
mod files;
mod generate;
mod generated_limits;
mod limits;
mod locked;
mod objective;
mod output;
mod own_terms;
mod passive;
mod preflight;
mod self_collision;
mod solve;
mod surroundings;
mod sweep;
mod sweep_files;
mod sweep_refused;
mod sweep_relax;
mod variants;
mod written;
