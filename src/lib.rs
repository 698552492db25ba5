#![doc = include_str!("../README.md")]

pub mod aghf;
pub mod cli;
pub mod dynamics;
pub mod error;
pub mod model;
pub mod pseudospectral;
pub mod report;
pub mod scalar;
pub mod scenario;
pub mod solve;
pub mod spatial;

pub use aghf::check;
pub use error::{Error, Result};
