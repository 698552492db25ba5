//! What the rest of the library asks of a number.
//!
//! Rigid-body dynamics are polynomials in `sin q`, `cos q`, `v`, `a` and the constants of the model, and rational functions
//! once a mass matrix is inverted: [`Scalar`] asks for field operations and `sin_cos`. Distances from shapes need a square root and a
//! choice between two numbers by a sign beside, and no comparison that a program could branch on. The hyperbolic tangent that penalties
//! need is in [`Tanh`]. `f32`, `f64`, every `Copy` type of `num-dual` and nests of them qualify; so do SIMD lanes, which choose each for
//! itself, and a prime field, where the root and the sign are formal.
//!
//! The constants of a model have a type of their own. [`AlgebraOver<C>`] says that a scalar can be multiplied by a constant of
//! type `C` without promoting the constant first: for dual numbers over `f64` constants this is two to three times faster.

mod jet;
mod lanes;
mod numeric;
mod operators;
mod prime_field;

pub use jet::Jet;
pub use lanes::Lanes;
pub use prime_field::PrimeField;

#[doc(inline)]
pub use crate::impl_scalar_operators;
pub use num_traits::{One, Zero};

use nalgebra::{ClosedAddAssign, ClosedDivAssign, ClosedMulAssign, ClosedSubAssign};
use std::ops::Neg;

/// A number that the generic dynamics compute with.
///
/// The supertraits are what `nalgebra` needs to store and multiply matrices of it. [`Zero::is_zero`] and `==` look only
/// at the real part of a dual number, so generic code must not branch on them.
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
    /// The scalar that stands for a constant.
    fn from_f64(x: f64) -> Self;

    /// Sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);

    /// The square root. At zero its derivatives are not finite, so code that may come there chooses another number by
    /// [`if_negative`](Self::if_negative).
    fn sqrt(self) -> Self;

    /// `then` where the real part of the number is negative, `otherwise` where it is zero, positive or not a number. Each lane chooses
    /// for itself. What is not chosen leaves no trace, whether or not it is finite.
    fn if_negative(self, then: Self, otherwise: Self) -> Self;

    /// Tells whether the number and all its derivatives are known to be zero, so that products with it can be left out. `false` is always
    /// right, and what it is unless overridden.
    #[inline]
    fn vanishes(&self) -> bool {
        false
    }
}

/// A scalar with a hyperbolic tangent, which the penalties of constraints are made of. Lagrangians and costs of the control, which
/// may contain penalties, get it, so the flow in its control form asks for it too. Dynamics and their derivatives, constraints,
/// and the flow by Algorithm B1 and by Theorems B3 and B4 do without.
pub trait Tanh: Scalar {
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
}

/// A scalar that can be multiplied by the constants `C` of a model.
pub trait AlgebraOver<C>: Scalar {
    /// The scalar that stands for the constant `c`.
    fn lift(c: C) -> Self;

    /// The product `c * self`, without promoting `c`.
    fn scale(self, c: C) -> Self;
}
