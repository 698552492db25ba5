//! Numbers for lanes that are to have the values of `f64` alone, bit for bit.

use aghf::impl_scalar_operators;
use aghf::scalar::{AlgebraOver, Scalar, Tanh};

/// An `f64` whose sines and cosines in lanes are those of one number. Those of four `f64` are computed at once, and may differ in the last
/// bit (see [`aghf::scalar::Lanes`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exact(pub f64);

impl_scalar_operators! {
    #[inline(always)]
    impl [] for Exact {
        zero() => Self(0.0),
        one() => Self(1.0),
        is_zero(a) => a.0 == 0.0,
        neg(a) => Self(-a.0),
        add(a, b) => Self(a.0 + b.0),
        sub(a, b) => Self(a.0 - b.0),
        mul(a, b) => Self(a.0 * b.0),
        div(a, b) => Self(a.0 / b.0),
    }
}

impl Scalar for Exact {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Self(x)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = Scalar::sin_cos(self.0);
        (Self(sin), Self(cos))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(Scalar::sqrt(self.0))
    }

    #[inline(always)]
    fn if_negative(self, then: Self, otherwise: Self) -> Self {
        if self.0 < 0.0 { then } else { otherwise }
    }

    #[inline(always)]
    fn vanishes(&self) -> bool {
        self.0.vanishes()
    }
}

impl Tanh for Exact {
    #[inline(always)]
    fn tanh(self) -> Self {
        Self(Tanh::tanh(self.0))
    }
}

impl AlgebraOver<f64> for Exact {
    #[inline(always)]
    fn lift(c: f64) -> Self {
        Self(c)
    }

    #[inline(always)]
    fn scale(self, c: f64) -> Self {
        Self(c * self.0)
    }
}
