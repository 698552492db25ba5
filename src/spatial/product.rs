//! Products of 3 by 3 matrices, written out: `nalgebra` calls its routine for any size on numbers that are not floating-point.

use crate::scalar::{Over, Scalar};
use nalgebra::{Matrix3, Vector3};

/// $M x$.
#[inline]
pub(crate) fn apply<S: Scalar>(m: &Matrix3<S>, x: &Vector3<S>) -> Vector3<S> {
    let row = |i| m[(i, 0)] * x.x + m[(i, 1)] * x.y + m[(i, 2)] * x.z;
    Vector3::new(row(0), row(1), row(2))
}

/// $M^T x$.
#[inline]
pub(crate) fn apply_transpose<S: Scalar>(m: &Matrix3<S>, x: &Vector3<S>) -> Vector3<S> {
    let row = |i| m[(0, i)] * x.x + m[(1, i)] * x.y + m[(2, i)] * x.z;
    Vector3::new(row(0), row(1), row(2))
}

/// $A B$.
#[inline]
pub(crate) fn multiply<S: Scalar>(a: &Matrix3<S>, b: &Matrix3<S>) -> Matrix3<S> {
    Matrix3::from_fn(|i, j| a[(i, 0)] * b[(0, j)] + a[(i, 1)] * b[(1, j)] + a[(i, 2)] * b[(2, j)])
}

/// $M x$ for constants `x`, which are not promoted.
#[inline]
pub(crate) fn apply_to_constant<C: Copy, S: Over<C>>(m: &Matrix3<S>, x: &Vector3<C>) -> Vector3<S> {
    let row = |i| m[(i, 0)].scale(x[0]) + m[(i, 1)].scale(x[1]) + m[(i, 2)].scale(x[2]);
    Vector3::new(row(0), row(1), row(2))
}
