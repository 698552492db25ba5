//! Trajectory optimisation with the **Affine Geometric Heat Flow** (AGHF), on rigid-body dynamics that are generic over
//! the scalar, with every analytic derivative checked by three witnesses.
//!
//! The mathematics is that of *Bring the Heat: Rapid Trajectory Optimization with Pseudospectral Techniques and the
//! Affine Geometric Heat Flow Equation* (PHLAME, arXiv 2411.12962). Equation and algorithm numbers are those of the
//! paper and its supplement.
//!
//! # Two methods
//!
//! [`relax`] minimises the control effort, or any [running cost](guide::running_cost), over motions in a polynomial
//! basis, by Newton's method with exact Hessians and an interior-point method for limits and clearances. Its minimum is
//! the limit of the flow for an infinite penalty. Use it to find motions. [`flow`] is the flow itself, as published and
//! to rest. Use it to study the flow.
//!
//! # The book
//!
//! 1. [Two methods](guide::methods), and which to use when.
//! 2. [A first motion](guide::first_motion): from a URDF to a plot.
//! 3. [Asking for more](guide::asking_for_more): limits, obstacles, running costs, horizons; [all keys of a
//!    scenario](mod@scenario).
//! 4. [The notation](guide::notation) of the paper, the code and Pinocchio.
//! 5. [Verification](verify) of every derivative, and what each witness cannot see.
//! 6. Extensions: a [constraint](guide::constraint), a [running cost](guide::running_cost), a
//!    [Jacobian](guide::jacobian), a [Lagrangian, metric or drift](guide::lagrangian), a [scalar](guide::scalar), an
//!    [integrator](guide::integrator), a [joint](guide::joint).
//! 7. [The command line](guide::command_line), [many solves](guide::sweeps), [the variants of the flow](guide::variants).
//! 8. [Performance](guide::performance), and [a crate of your own](guide::your_crate): its `Cargo.toml`, and how to keep
//!    the code fast.
//! 9. [The limits of the library](guide::limitations).
//!
//! # The modules
//!
//! Each depends only on those before it: [`scalar`], [`linalg`], [`spatial`], [`geometry`], [`model`], [`dynamics`],
//! [`names`], [`urdf`], [`curve`], [`constraint`], [`ode`], [`motion`], [`flow`], [`plan`], [`relax`], [`verify`],
//! [`scenario`], [`judge`], [`output`], [`report`], [`experiments`], [`cli`]; [`guide`] has the pages of the book.
//!
//! Without default features the crate contains robots, their dynamics and the derivatives of the dynamics. The feature
//! `solvers` adds everything up to [`verify`]; `output` adds scenarios, sweeps and reports; `cli`, the default, adds
//! the command line.
//!
//! # Limits
//!
//! The base is fixed, joints have one degree of freedom, and links are rigid. Contact, friction, damping and closed
//! loops are not modelled.

/// The code of the README, run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

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
pub use {nalgebra, num_dual, urdf_rs};
