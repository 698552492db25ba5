//! The number types of the library.
//!
//! Rigid-body dynamics are polynomials in `sin q`, `cos q`, `v`, `a` and the constants of the model, and rational
//! functions once a mass matrix is inverted: [`Scalar`] requires field operations and `sin_cos`. The friction of joints
//! and distances from shapes also need a square root, and the latter a choice between two numbers by a sign, but no
//! comparison on which a program could branch. The hyperbolic tangent of penalties is in [`Tanh`]. `f32`, `f64`, every
//! `Copy` type of `num-dual` and their nestings implement it; so do SIMD lanes, which choose independently, a prime
//! field, where the root and the sign are formal, and [`TaylorModel`], polynomials with a bound on their error.
//!
//! The constants of a model have a separate type. [`AlgebraOver<C>`] means that a scalar can be multiplied by a
//! constant of type `C` without promoting the constant first: for dual numbers over `f64` constants this is two to
//! three times faster.

mod jet;
mod lanes;
mod numeric;
mod operators;
mod prime_field;
mod taylor_model;

pub use jet::Jet;
pub use lanes::{LANES, Lanes, Wide};
pub use prime_field::PrimeField;
pub use taylor_model::{Ball, TaylorModel};

#[doc(inline)]
pub use crate::impl_scalar_operators;
pub use num_traits::{One, Zero};

use nalgebra::{ClosedAddAssign, ClosedDivAssign, ClosedMulAssign, ClosedSubAssign};
use std::ops::Neg;

/// A number type of the generic dynamics.
///
/// The supertraits are those that `nalgebra` needs for matrices. [`Zero::is_zero`] and `==` of a dual number compare
/// only the real part, so that generic code must not branch on them.
pub trait Scalar:
    Copy
    + nalgebra::Scalar
    + Zero
    + One
    + Neg<Output = Self>
    + ClosedAddAssign
    + ClosedSubAssign
    + ClosedMulAssign
    + ClosedDivAssign
{
    /// Converts a constant.
    fn from_f64(x: f64) -> Self;

    /// Computes sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);

    /// Computes sines and cosines of several angles; `f64` four at a time.
    ///
    /// * `angles`: any number of angles, rad
    /// * `found`: as many pairs, sine first, overwritten
    #[inline(always)]
    fn sin_cos_of_several(angles: &[Self], found: &mut [(Self, Self)]) {
        for (found, angle) in found.iter_mut().zip(angles) {
            *found = angle.sin_cos();
        }
    }

    /// Computes the square root. At zero its derivatives are not finite; code that may reach zero selects another
    /// number by [`if_negative`](Self::if_negative).
    fn sqrt(self) -> Self;

    /// Selects `then` if the real part of the number is negative, and `otherwise` if it is zero, positive or NaN. Each
    /// lane selects independently. The other number has no effect, even if it is not finite.
    fn if_negative(self, then: Self, otherwise: Self) -> Self;

    /// Returns true if the number and all its derivatives are known to be zero, so that products with it can be
    /// skipped. `false`, the default, is always correct.
    #[inline]
    fn vanishes(&self) -> bool {
        false
    }
}

/// A scalar with a hyperbolic tangent, of which the penalties of constraints are made. Lagrangians and costs of the
/// control, which may contain penalties, require it, and so does the flow in its control form. Dynamics and their
/// derivatives, constraints, and the flow by Algorithm B1 and by Theorems B3 and B4 do not.
pub trait Tanh: Scalar {
    /// Computes the hyperbolic tangent.
    fn tanh(self) -> Self;
}

/// A scalar that can be multiplied by the constants `C` of a model.
pub trait AlgebraOver<C>: Scalar {
    /// Converts the constant `c`.
    fn lift(c: C) -> Self;

    /// Computes the product `c * self` without promoting `c`.
    fn scale(self, c: C) -> Self;
}
