//! Featherstone's spatial vectors (*Rigid Body Dynamics Algorithms*, 2008, chapter 2), angular part first.
//!
//! Motions and forces live in different spaces and have different types, so that `motion x force` cannot be mistaken for
//! `motion x motion`. All are written at one origin; [`Placement`] moves them between frames.

mod coriolis;
mod inertia;
mod placement;
mod vector;

pub use coriolis::Coriolis;
pub use inertia::Inertia;
pub use placement::Placement;
pub use vector::{Force, Motion};

use crate::scalar::{Over, Scalar};
use nalgebra::{Matrix3, Vector3};

/// The matrix $a_\times$ of the product $b \mapsto a \times b$.
#[must_use]
pub fn cross_matrix<S: Scalar>(a: &Vector3<S>) -> Matrix3<S> {
    let o = S::zero();
    Matrix3::new(o, -a.z, a.y, a.z, o, -a.x, -a.y, a.x, o)
}

/// The product of a matrix and a vector of constants, without promoting the constants.
pub(crate) fn apply_to_constant<C: Copy, S: Over<C>>(
    matrix: &Matrix3<S>,
    v: &Vector3<C>,
) -> Vector3<S> {
    let row = |i| {
        let m = |j: usize| matrix[(i, j)].scale(v[j]);
        m(0) + m(1) + m(2)
    };
    Vector3::new(row(0), row(1), row(2))
}
