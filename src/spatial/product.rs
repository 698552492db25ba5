//! Products of vectors and 3 by 3 matrices, written out: for other scalars than floating point, `nalgebra` calls its
//! routines for any size, which the compiler does not unroll.

use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{Matrix3, Vector3};

/// Computes $a \times b$.
#[inline(always)]
pub(crate) fn cross<S: Scalar>(a: &Vector3<S>, b: &Vector3<S>) -> Vector3<S> {
    Vector3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// Computes $a \cdot b$.
#[inline(always)]
pub(crate) fn dot<S: Scalar>(a: &Vector3<S>, b: &Vector3<S>) -> S {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Computes $a b^T$.
#[inline(always)]
pub(crate) fn outer<S: Scalar>(a: &Vector3<S>, b: &Vector3<S>) -> Matrix3<S> {
    matrix(|i, j| a[i] * b[j])
}

/// The matrix with these entries.
#[inline(always)]
pub(crate) fn matrix<S: Scalar>(f: impl Fn(usize, usize) -> S) -> Matrix3<S> {
    let (a, b, c) = (f(0, 0), f(0, 1), f(0, 2));
    let (d, e, g) = (f(1, 0), f(1, 1), f(1, 2));
    Matrix3::new(a, b, c, d, e, g, f(2, 0), f(2, 1), f(2, 2))
}

/// The symmetric matrix with these entries on and above the diagonal.
#[inline(always)]
pub(crate) fn symmetric<S: Scalar>(f: impl Fn(usize, usize) -> S) -> Matrix3<S> {
    let (a, b, c) = (f(0, 0), f(0, 1), f(0, 2));
    let (d, e) = (f(1, 1), f(1, 2));
    Matrix3::new(a, b, c, b, d, e, c, e, f(2, 2))
}

/// Computes $M x$.
#[inline(always)]
pub(crate) fn apply<S: Scalar>(m: &Matrix3<S>, x: &Vector3<S>) -> Vector3<S> {
    let row = |i| m[(i, 0)] * x.x + m[(i, 1)] * x.y + m[(i, 2)] * x.z;
    Vector3::new(row(0), row(1), row(2))
}

/// Computes $M^T x$.
#[inline(always)]
pub(crate) fn apply_transpose<S: Scalar>(m: &Matrix3<S>, x: &Vector3<S>) -> Vector3<S> {
    let row = |i| m[(0, i)] * x.x + m[(1, i)] * x.y + m[(2, i)] * x.z;
    Vector3::new(row(0), row(1), row(2))
}

/// Computes $A B$.
#[inline(always)]
pub(crate) fn multiply<S: Scalar>(a: &Matrix3<S>, b: &Matrix3<S>) -> Matrix3<S> {
    matrix(|i, j| a[(i, 0)] * b[(0, j)] + a[(i, 1)] * b[(1, j)] + a[(i, 2)] * b[(2, j)])
}

/// Computes $M x$ for constants `M`, which are not promoted.
#[inline(always)]
pub(crate) fn apply_constant<C: Copy, S: AlgebraOver<C>>(m: &Matrix3<C>, x: &Vector3<S>) -> Vector3<S> {
    let row = |i| x.x.scale(m[(i, 0)]) + x.y.scale(m[(i, 1)]) + x.z.scale(m[(i, 2)]);
    Vector3::new(row(0), row(1), row(2))
}

/// Computes $M^T x$ for constants `M`, which are not promoted.
#[inline(always)]
pub(crate) fn apply_constant_transpose<C: Copy, S: AlgebraOver<C>>(m: &Matrix3<C>, x: &Vector3<S>) -> Vector3<S> {
    let row = |i| x.x.scale(m[(0, i)]) + x.y.scale(m[(1, i)]) + x.z.scale(m[(2, i)]);
    Vector3::new(row(0), row(1), row(2))
}

/// Computes $M x$ for constants `x`, which are not promoted.
#[inline(always)]
pub(crate) fn apply_to_constant<C: Copy, S: AlgebraOver<C>>(m: &Matrix3<S>, x: &Vector3<C>) -> Vector3<S> {
    let row = |i| m[(i, 0)].scale(x[0]) + m[(i, 1)].scale(x[1]) + m[(i, 2)].scale(x[2]);
    Vector3::new(row(0), row(1), row(2))
}
