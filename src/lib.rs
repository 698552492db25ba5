//! Trajectory optimisation with the Affine Geometric Heat Flow (AGHF), in which every analytic derivative is proved
//! against automatic differentiation.
//!
//! Data flows one way through the modules, each knowing only those before it:
//! [`scalar`], [`spatial`], [`model`], [`dynamics`], [`aghf`](mod@aghf), [`pseudospectral`], [`solve`], [`scenario`],
//! [`report`], [`cli`].

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

pub use error::{Error, Result};
