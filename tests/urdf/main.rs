//! Models and URDF files.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod cover;
mod errors;
mod large;
mod limits;
mod model;
mod notes;
mod robots;
mod several_arms;
mod shapes;
mod underactuated;
mod write;
