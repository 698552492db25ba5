//! Differentiation by dual numbers of any kind.

use crate::error::Result;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{DMatrix, DVector};

/// A number with one tangent, $x + \epsilon x'$ with $\epsilon^2 = 0$.
pub trait DualNumber: Scalar {
    /// The type of the real part and of the tangent.
    type Base: Scalar;

    /// The dual number with these parts.
    fn from_parts(real: Self::Base, tangent: Self::Base) -> Self;

    /// The real part.
    fn real(self) -> Self::Base;

    /// The tangent.
    fn tangent(self) -> Self::Base;
}

/// A number type with dual numbers over it, and over these again.
pub trait Differentiable: Scalar {
    /// The dual numbers over it.
    type Dual: DualNumber<Base = Self> + Differentiable;
}

/// A [`Differentiable`] number type that can be multiplied by the constants `C` of a model, together with its dual
/// numbers.
pub trait DifferentiableOver<C>:
    AlgebraOver<C> + Differentiable<Dual: AlgebraOver<C> + Differentiable<Dual: AlgebraOver<C>>>
{
}

impl<C, S> DifferentiableOver<C> for S where
    S: AlgebraOver<C> + Differentiable<Dual: AlgebraOver<C> + Differentiable<Dual: AlgebraOver<C>>>
{
}

/// Nested first-order dual numbers over `S`.
pub type SecondDual<S> = <<S as Differentiable>::Dual as Differentiable>::Dual;

/// Dual numbers with these real parts and tangents.
pub fn dual<S: Differentiable>(real: &[S], tangent: &[S]) -> Vec<S::Dual> {
    let parts = real.iter().zip(tangent);
    parts.map(|(x, d)| S::Dual::from_parts(*x, *d)).collect()
}

/// Dual numbers with the tangent zero.
pub fn constant<S: Differentiable>(x: &[S]) -> Vec<S::Dual> {
    dual(x, &vec![S::zero(); x.len()])
}

/// A vector from a slice.
pub fn vector<S: Scalar>(x: &[S]) -> DVector<S> {
    DVector::from_column_slice(x)
}

/// The entries of a matrix in column-major order.
pub fn entries<S: Scalar>(matrix: &DMatrix<S>) -> DVector<S> {
    vector(matrix.as_slice())
}

/// The unit vector `index` of `n`.
pub fn unit<S: Scalar>(n: usize, index: usize) -> Vec<S> {
    let mut unit = vec![S::zero(); n];
    unit[index] = S::one();
    unit
}

/// Computes the derivative of `f` at `x` along `direction`.
///
/// # Errors
/// Those of `f`.
pub fn rate<S: Differentiable>(
    x: &[S],
    direction: &[S],
    f: impl Fn(&[S::Dual]) -> Result<DVector<S::Dual>>,
) -> Result<DVector<S>> {
    Ok(f(&dual(x, direction))?.map(DualNumber::tangent))
}

/// Computes the Jacobian of `f` at `x`: rows are those of `f`, one evaluation per column.
///
/// # Errors
/// Those of `f`.
pub fn jacobian<S: Differentiable>(x: &[S], f: impl Fn(&[S::Dual]) -> Result<DVector<S::Dual>>) -> Result<DMatrix<S>> {
    let column = |j| rate(x, &unit(x.len(), j), &f);
    let columns: Result<Vec<_>> = (0..x.len()).map(column).collect();
    Ok(DMatrix::from_columns(&columns?))
}

/// Computes the gradient of a scalar function `f` at `x`, as a column.
///
/// # Errors
/// Those of `f`.
pub fn gradient<S: Differentiable>(x: &[S], f: impl Fn(&[S::Dual]) -> Result<S::Dual>) -> Result<DVector<S>> {
    let row = jacobian(x, |x| Ok(DVector::from_element(1, f(x)?)))?;
    Ok(row.row(0).transpose())
}
