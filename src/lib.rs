//! Trajectory optimisation with the **Affine Geometric Heat Flow** (AGHF), on rigid-body dynamics that are generic over
//! the scalar, with every analytic derivative checked by three witnesses.
//!
//! The mathematics is that of *Bring the Heat: Rapid Trajectory Optimization with Pseudospectral Techniques and the
//! Affine Geometric Heat Flow Equation* (PHLAME, arXiv 2411.12962). Equation and algorithm numbers are those of the
//! paper and its supplement.
//!
//! # Two methods
//!
//! [`direct`] minimises the control effort, or any [running cost](guide::running_cost), over motions in a polynomial
//! basis, by a primal-dual interior-point method with exact Hessians. Its minimum is the limit of the flow for an
//! infinite penalty. Use it to find motions. [`flow`] is the flow itself, as published and to rest. Use it to study the
//! flow.
//!
//! # The book
//!
//! 1. [Two methods](guide::methods), and which to use when.
//! 2. [The notation](guide::notation) of the paper, the code and Pinocchio.
//! 3. [Verification](verify) of every derivative, and the errors that each witness cannot detect.
//! 4. Extensions: a [constraint](guide::constraint), a [running cost](guide::running_cost), a
//!    [Jacobian](guide::jacobian), a [Lagrangian, metric or drift](guide::lagrangian), a [scalar](guide::scalar), an
//!    [integrator](guide::integrator), a [joint](guide::joint).
//! 5. [Performance](guide::performance), and [a crate of your own](guide::your_crate): its `Cargo.toml`, and how to
//!    keep the code fast.
//! 6. [The limits of the library](guide::limitations).
//!
//! The packages `aghf-scenario` and `aghf-cli` describe first motions, the keys of a scenario and the command line.
//!
//! # The modules
//!
//! Each depends only on those before it: [`scalar`], [`linalg`], [`spatial`], [`geometry`], [`model`], [`dynamics`],
//! [`urdf`], [`curve`], [`certify`], [`constraint`], [`cost`], [`ode`], [`transcription`], [`motion`], [`plan`],
//! [`nlp`], [`direct`], [`flow`], [`verify`]; [`guide`] has the pages of the book.
//!
//! Without default features the crate contains robots, their dynamics and the derivatives of the dynamics. The feature
//! `solvers`, the default, adds the rest. Problems as files and the judge of motions are in the package
//! `aghf-scenario`, the program `aghf` is in `aghf-cli`; both are in the folder `app` of the repository.
//!
//! # Limits
//!
//! The base is fixed, joints have one degree of freedom, and links are rigid. Contact and closed loops are not
//! modelled. [Drives](model::Drive) of the joints have viscous damping, smooth dry friction and rotor inertia.

#[cfg(feature = "solvers")]
pub mod certify;
#[cfg(feature = "solvers")]
pub mod constraint;
#[cfg(feature = "solvers")]
pub mod cost;
#[cfg(feature = "solvers")]
pub mod curve;
#[cfg(feature = "solvers")]
pub mod direct;
pub mod dynamics;
#[doc(hidden)]
pub mod error;
#[cfg(feature = "solvers")]
pub mod flow;
pub mod geometry;
pub mod guide;
#[doc(hidden)]
pub mod input;
#[doc(hidden)]
pub mod linalg;
pub mod model;
#[cfg(feature = "solvers")]
pub mod motion;
#[doc(hidden)]
pub mod names;
#[doc(hidden)]
#[cfg(feature = "solvers")]
pub mod nlp;
#[cfg(feature = "solvers")]
pub mod ode;
#[cfg(feature = "solvers")]
pub mod plan;
pub mod scalar;
pub mod spatial;
#[doc(hidden)]
#[cfg(feature = "solvers")]
pub mod transcription;
pub mod urdf;
#[cfg(feature = "solvers")]
pub mod verify;

pub use error::{Error, Result};

// Their types are part of the public interface: these exports have the versions that fit.
pub use {nalgebra, num_dual, urdf_rs};
