//! `f32`, `f64` and the types of `num-dual` as scalars.

use super::{AlgebraOver, Scalar, Tanh};
use num_dual::{Dual, Dual2, DualNum, DualNumFloat, DualSVec, HyperDual};
use num_traits::{Float, NumCast, Zero};

/// Rounds a constant to the floating-point type of a dual number; both existing types (`f32`, `f64`) accept any `f64`.
fn primitive<F: DualNumFloat>(x: f64) -> F {
    NumCast::from(x).unwrap_or_else(F::nan)
}

impl<D: DualNum + Copy> Scalar for D {
    #[inline]
    fn from_f64(x: f64) -> Self {
        D::from(primitive::<D::Primitive>(x))
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        DualNum::sin_cos(&self)
    }

    #[inline]
    fn sqrt(self) -> Self {
        DualNum::sqrt(&self)
    }

    #[inline]
    fn if_negative(self, then: Self, otherwise: Self) -> Self {
        if self.re() < D::Primitive::zero() {
            then
        } else {
            otherwise
        }
    }

    /// `num-dual` reports only the real part, so that only numbers without derivatives can be known to vanish.
    #[inline]
    fn vanishes(&self) -> bool {
        D::NDERIV == 0 && self.is_zero()
    }
}

impl<D: DualNum + Copy> Tanh for D {
    #[inline]
    fn tanh(self) -> Self {
        // `num-dual` divides sinh by cosh, which is not a number once they overflow. Beyond this bound the hyperbolic tangent
        // is one to the last bit, and its derivatives vanish beside that.
        let re = self.re();
        if Float::abs(re) > primitive::<D::Primitive>(20.0) {
            D::from(Float::signum(re))
        } else {
            DualNum::tanh(&self)
        }
    }
}

impl<D: DualNum + Copy> AlgebraOver<f64> for D {
    #[inline]
    fn lift(c: f64) -> Self {
        Scalar::from_f64(c)
    }

    #[inline]
    fn scale(self, c: f64) -> Self {
        self * primitive::<D::Primitive>(c)
    }
}

/// Implements [`AlgebraOver`] for a type over itself, for models whose constants have this type, as after
/// [`Model::cast`](crate::model::Model::cast).
macro_rules! over_itself {
    ($type:ty $(, $parameter:ident $(: $bound:ident)?)* $(; const $n:ident)?) => {
        impl<$($parameter $(: $bound + Copy)?,)* $(const $n: usize)?> AlgebraOver<$type> for $type {
            #[inline]
            fn lift(c: Self) -> Self {
                c
            }

            #[inline]
            fn scale(self, c: Self) -> Self {
                self * c
            }
        }
    };
}

over_itself!(f32);
over_itself!(Dual<T>, T: DualNum);
over_itself!(Dual2<T>, T: DualNum);
over_itself!(HyperDual<T>, T: DualNum);
over_itself!(DualSVec<T, N>, T: DualNum; const N);
