//! Models and URDF files.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod build;
mod cover;
mod errors;
mod large;
mod limits;
mod model;
mod notes;
mod robots;
#[cfg(unix)]
mod ros;
mod several_arms;
mod shapes;
mod underactuated;
mod write;
