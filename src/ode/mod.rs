//! Integrators of ordinary differential equations.

mod bdf;

pub use bdf::{Failure, NonFinite, Ode, STEP_LIMIT, Statistics, Tolerance, integrate};
