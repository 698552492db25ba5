#![doc = include_str!("../README.md")]

#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "solvers")]
pub mod constraint;
#[cfg(feature = "solvers")]
pub mod curve;
pub mod dynamics;
pub mod error;
#[cfg(feature = "output")]
pub mod experiments;
#[cfg(feature = "solvers")]
pub mod flow;
pub mod geometry;
#[cfg(feature = "output")]
pub mod guide;
mod input;
#[cfg(feature = "output")]
pub mod judge;
pub mod linalg;
pub mod model;
#[cfg(feature = "solvers")]
pub mod motion;
pub mod names;
#[cfg(feature = "solvers")]
pub mod ode;
#[cfg(feature = "output")]
pub mod output;
#[cfg(feature = "solvers")]
pub mod plan;
#[cfg(feature = "solvers")]
pub mod relax;
#[cfg(feature = "output")]
pub mod report;
pub mod scalar;
#[cfg(feature = "output")]
pub mod scenario;
pub mod spatial;
pub mod urdf;
#[cfg(feature = "solvers")]
pub mod verify;

pub use error::{Error, Result};

// Their types are in what is public here: whoever takes them from here has the versions that fit.
pub use {nalgebra, num_dual};
