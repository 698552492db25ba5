//! Featherstone's spatial vectors (*Rigid Body Dynamics Algorithms*, 2008, chapter 2), angular part first.
//!
//! Motions and forces are in different spaces and have different types, so that `motion x force` cannot be confused
//! with `motion x motion`. All are expressed at one origin; [`Placement`] moves them between frames.

mod articulated;
mod coriolis;
mod inertia;
mod placement;
mod product;
mod vector;

pub use articulated::ArticulatedInertia;
pub use coriolis::Coriolis;
pub use inertia::Inertia;
#[cfg(feature = "solvers")]
pub(crate) use placement::placed_point;
pub use placement::{Placement, rotation_of_z_to, unit_vector};
pub(crate) use product::{
    apply, apply_constant, apply_constant_transpose, apply_to_constant, apply_transpose, cross, dot, matrix, multiply,
    outer, symmetric,
};
pub use vector::{Force, Motion};

use crate::scalar::Scalar;
use nalgebra::{Matrix3, Vector3};

/// The matrix $a_\times$ of the product $b \mapsto a \times b$.
#[must_use]
pub fn cross_matrix<S: Scalar>(a: &Vector3<S>) -> Matrix3<S> {
    let o = S::zero();
    Matrix3::new(o, -a.z, a.y, a.z, o, -a.x, -a.y, a.x, o)
}
