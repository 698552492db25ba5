//! Scenario files, their solves and their verdicts.

#[macro_use]
#[path = "../../../../tests/common/mod.rs"]
mod common;

mod best_known;
mod feasibility;
mod files;
mod generate;
mod generated_limits;
mod limits;
mod locked;
mod objective;
mod own_terms;
mod passive;
mod preflight;
mod published_flow;
mod relaxation;
mod schema;
mod self_collision;
mod solve;
mod surroundings;
mod variants;
mod written;
