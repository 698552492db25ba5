//! The field with $2^{61} - 1$ elements, over which identities are proved.

use super::{AlgebraOver, One, Scalar, Tanh, impl_scalar_operators};
use std::fmt;

/// An element of $GF(p)$ with the Mersenne prime $p = 2^{61} - 1$. Arithmetic is exact and `==` means equal.
///
/// Rigid-body dynamics are rational functions of their inputs once the sine and cosine of an angle are two numbers with
/// $s^2 + c^2 = 1$. Two different rational functions of degree `d` agree at a random point of the field with
/// probability at most `d / p` (Schwartz and Zippel), so agreement at one point is a proof up to that.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct PrimeField(u64);

impl PrimeField {
    /// The number of elements: the prime $2^{61} - 1$.
    pub const ORDER: u64 = (1 << 61) - 1;

    /// The residue class of an integer.
    #[must_use]
    pub fn new(x: u64) -> Self {
        Self(x % Self::ORDER)
    }

    /// The representative from 0 to `ORDER - 1`.
    #[must_use]
    pub fn residue(self) -> u64 {
        self.0
    }

    /// Computes $x^e$.
    #[must_use]
    pub fn power(self, mut exponent: u64) -> Self {
        let (mut base, mut result) = (self, Self::one());
        while exponent > 0 {
            if exponent & 1 == 1 {
                result *= base;
            }
            base *= base;
            exponent >>= 1;
        }
        result
    }

    /// Computes $x^{-1} = x^{p - 2}$ (Fermat); zero, which has no inverse, gives zero.
    #[must_use]
    pub fn inverse(self) -> Self {
        self.power(Self::ORDER - 2)
    }
}

impl fmt::Debug for PrimeField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

impl_scalar_operators! {
    #[inline]
    #[allow(clippy::suspicious_arithmetic_impl, reason = "a quotient is a product with the inverse")]
    impl [] for PrimeField {
        zero() => Self(0),
        one() => Self(1),
        is_zero(a) => a.0 == 0,
        neg(a) => Self(0) - a,
        add(a, b) => {
            let sum = a.0 + b.0;
            Self(if sum >= Self::ORDER { sum - Self::ORDER } else { sum })
        },
        sub(a, b) => Self(if a.0 >= b.0 { a.0 - b.0 } else { a.0 + (Self::ORDER - b.0) }),
        mul(a, b) => {
            let product = u128::from(a.0) * u128::from(b.0);
            // 2^61 is 1, so the high bits are added to the low ones.
            let low = (product as u64) & Self::ORDER;
            let high = (product >> 61) as u64;
            Self(low) + Self(high)
        },
        div(a, b) => a * b.inverse(),
    }
}

impl Scalar for PrimeField {
    /// Exact: a finite `f64` is an integer times a power of two, and two has an inverse. A number that is not finite
    /// has no image and gives zero; such a constant never reaches a model.
    fn from_f64(x: f64) -> Self {
        debug_assert!(x.is_finite(), "{x} is no element of a field");
        let bits = x.abs().to_bits();
        let (exponent, fraction) = (bits >> 52, bits & ((1 << 52) - 1));
        let (integer, power) = match exponent {
            0 => (fraction, -1074),
            0x7ff => (0, 0),
            _ => (fraction | (1 << 52), exponent as i64 - 1075),
        };
        // 2^61 is 1, so only the power modulo 61 matters.
        let magnitude = Self::new(integer) * Self(1 << power.rem_euclid(61));
        if x.is_sign_negative() { -magnitude } else { magnitude }
    }

    /// The rational point of the circle with the parameter `self`: $s = 2t / (1 + t^2)$, $c = (1 - t^2) / (1 + t^2)$.
    fn sin_cos(self) -> (Self, Self) {
        let square = self * self;
        let inverse = (Self::one() + square).inverse();
        ((self + self) * inverse, (Self::one() - square) * inverse)
    }

    /// A formal function, because half of the elements have no root: any value is admissible that is zero only at zero,
    /// if the derivative is $1 / (2 \sqrt x)$, which [`Jet`](super::Jet) provides. Here it is $x + x^3$, because
    /// $x^2 = -1$ has no solution.
    fn sqrt(self) -> Self {
        self + self * self * self
    }

    /// The residues above half of the order count as negative, like $-1, -2, \dots$: about half of all elements.
    #[inline]
    fn if_negative(self, then: Self, otherwise: Self) -> Self {
        if self.0 > Self::ORDER / 2 { then } else { otherwise }
    }

    #[inline]
    fn vanishes(&self) -> bool {
        self.0 == 0
    }
}

impl Tanh for PrimeField {
    /// A formal function: any value is admissible if the derivative is $1 - \tanh^2$, which [`Jet`](super::Jet)
    /// provides.
    fn tanh(self) -> Self {
        (self + self) * (Self::one() + self * self).inverse()
    }
}

impl AlgebraOver<PrimeField> for PrimeField {
    #[inline]
    fn lift(c: Self) -> Self {
        c
    }

    #[inline]
    fn scale(self, c: Self) -> Self {
        self * c
    }
}
