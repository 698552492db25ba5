#![doc = include_str!("../README.md")]

pub mod cli;
pub mod constraint;
pub mod curve;
pub mod dynamics;
pub mod error;
pub mod experiments;
pub mod flow;
pub mod guide;
pub mod linalg;
pub mod model;
pub mod motion;
pub mod names;
pub mod ode;
pub mod output;
pub mod relax;
pub mod scalar;
pub mod scenario;
pub mod spatial;
pub mod urdf;
pub mod verify;

pub use error::{Error, Result};
