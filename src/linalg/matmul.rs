//! Products of matrices.

use crate::scalar::Scalar;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;
use std::any::Any;

/// Computes the product $A B$ of an `m` by `k` and a `k` by `n` matrix into `out`, `m` by `n`. Cost O(m k n).
///
/// Over `f64` it uses `faer`, and over every other scalar `nalgebra`, which takes up to twice as long if one dimension
/// is small. The two round differently: entries differ by at most a few times `k` units of rounding of $|A|\\, |B|$.
///
/// # Panics
/// The shapes do not match.
pub fn multiply<S: Scalar>(a: &DMatrix<S>, b: &DMatrix<S>, out: &mut DMatrix<S>) {
    let [x, y]: [&dyn Any; 2] = [a, b];
    let z: &mut dyn Any = out;
    if let (Some(a), Some(b), Some(out)) =
        (x.downcast_ref::<DMatrix<f64>>(), y.downcast_ref::<DMatrix<f64>>(), z.downcast_mut::<DMatrix<f64>>())
    {
        let [a, b] = [a, b].map(|m| MatRef::from_column_major_slice(m.as_slice(), m.nrows(), m.ncols()));
        let (rows, columns) = out.shape();
        let out = MatMut::from_column_major_slice_mut(out.as_mut_slice(), rows, columns);
        matmul(out, Accum::Replace, a, b, 1.0, Par::Seq);
    } else {
        out.gemm(S::one(), a, b, S::zero());
    }
}
