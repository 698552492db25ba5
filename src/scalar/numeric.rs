//! `f32`, `f64` and the types of `num-dual` as scalars.

use super::{AlgebraOver, Scalar, Tanh};
use num_dual::{Dual, Dual2, DualNum, DualNumFloat, DualSVec, HyperDual};
use num_traits::{Float, NumCast, Zero};
use std::any::Any;

/// Rounds a constant to the floating-point type of a dual number; both existing types (`f32`, `f64`) accept any `f64`.
fn primitive<F: DualNumFloat>(x: f64) -> F {
    NumCast::from(x).unwrap_or_else(F::nan)
}

/// The angle, in rad, beyond which the fast computation of sines and cosines loses digits.
const LARGE: f64 = 1e9;

/// Sines and cosines of four `f64`, in less than the time of two single ones; `None` for other types. Each angle has
/// the same result whatever the others are.
#[inline(always)]
fn sin_cos_f64x4<T: Copy + 'static>(angles: T) -> Option<(T, T)> {
    let angles: &[f64; 4] = (&angles as &dyn Any).downcast_ref()?;
    let (sin, cos) = wide::f64x4::from(*angles).sin_cos();
    let (mut sin, mut cos) = (sin.to_array(), cos.to_array());
    let small = |angle: &f64| angle.abs() < LARGE;
    if !angles.iter().all(small) {
        for (k, angle) in angles.iter().enumerate() {
            if !small(angle) {
                (sin[k], cos[k]) = angle.sin_cos();
            }
        }
    }
    let back = |x: &dyn Any| x.downcast_ref().copied();
    Some((back(&sin)?, back(&cos)?))
}

impl<D: DualNum + Copy> Scalar for D {
    #[inline]
    fn from_f64(x: f64) -> Self {
        D::from(primitive::<D::Primitive>(x))
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let mut found = [(self, self)];
        Self::sin_cos_of_several(&[self], &mut found);
        found[0]
    }

    #[inline(always)]
    fn sin_cos_of_several(angles: &[Self], found: &mut [(Self, Self)]) {
        for (found, angles) in found.chunks_mut(4).zip(angles.chunks(4)) {
            let mut four = [D::zero(); 4];
            four[..angles.len()].copy_from_slice(angles);
            let fast = sin_cos_f64x4(four);
            for (k, found) in found.iter_mut().enumerate() {
                *found = match fast {
                    Some((sin, cos)) => (sin[k], cos[k]),
                    None => DualNum::sin_cos(&angles[k]),
                };
            }
        }
    }

    #[inline]
    fn sqrt(self) -> Self {
        DualNum::sqrt(&self)
    }

    #[inline]
    fn if_negative(self, then: Self, otherwise: Self) -> Self {
        if self.re() < D::Primitive::zero() { then } else { otherwise }
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
        // `num-dual` divides sinh by cosh, which is not a number once they overflow. Beyond this bound the hyperbolic
        // tangent is one to the last bit, and its derivatives vanish beside that.
        let re = self.re();
        if Float::abs(re) > primitive::<D::Primitive>(20.0) { D::from(Float::signum(re)) } else { DualNum::tanh(&self) }
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
