//! Numbers of twice the precision of `f64`, as a witness.

use aghf::impl_scalar_operators;
use aghf::scalar::{AlgebraOver, Scalar, Zero};

/// An unevaluated sum of two `f64`: about 32 digits (Dekker; Hida, Li and Bailey, "Library for double-double and
/// quad-double arithmetic", 2007).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Double(f64, f64);

/// The exact sum.
fn sum(a: f64, b: f64) -> Double {
    let s = a + b;
    let c = s - a;
    Double(s, (a - (s - c)) + (b - c))
}

impl Double {
    /// The nearest `f64`.
    pub fn rounded(self) -> f64 {
        self.0 + self.1
    }

    fn plus(self, other: Self) -> Self {
        let (high, low) = (sum(self.0, other.0), sum(self.1, other.1));
        let first = sum(high.0, high.1 + low.0);
        sum(first.0, first.1 + low.1)
    }

    fn times(self, other: Self) -> Self {
        let high = self.0 * other.0;
        let error = self.0.mul_add(other.0, -high);
        sum(high, error + (self.0 * other.1 + self.1 * other.0))
    }

    fn over(self, other: Self) -> Self {
        let mut quotient = Self::from(self.0 / other.0);
        for _ in 0..2 {
            let rest = self.plus(-(quotient.times(other)));
            quotient = quotient.plus(Self::from(rest.0 / other.0));
        }
        quotient
    }
}

impl From<f64> for Double {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

impl_scalar_operators! {
    impl [] for Double {
        zero() => Self(0.0, 0.0),
        one() => Self(1.0, 0.0),
        is_zero(a) => a.0 == 0.0,
        neg(a) => Self(-a.0, -a.1),
        add(a, b) => a.plus(b),
        sub(a, b) => a.plus(-b),
        mul(a, b) => a.times(b),
        div(a, b) => a.over(b),
    }
}

impl Scalar for Double {
    fn from_f64(x: f64) -> Self {
        Self::from(x)
    }

    /// By the series of an eighth of a power of two of the angle, and doubling.
    fn sin_cos(self) -> (Self, Self) {
        let small = self.times(Self::from(2.0_f64.powi(-10)));
        let square = small * small;
        let one = Self::from(1.0);
        let nested = |odd: f64| {
            (1..=8).rev().fold(one, |sum, k| {
                let n = 2.0 * f64::from(k) + odd;
                one - square * sum / Self::from(n * (n - 1.0))
            })
        };
        // One less the cosine keeps its digits.
        let mut sin = small * nested(1.0);
        let mut versine = square
            * (1..=8).rev().fold(one, |sum, k| {
                let n = 2.0 * f64::from(k) + 2.0;
                one - square * sum / Self::from(n * (n - 1.0))
            })
            / Self::from(2.0);
        for _ in 0..10 {
            let cos = one - versine;
            (sin, versine) = ((sin + sin) * cos, (sin + sin) * sin);
        }
        (sin, one - versine)
    }

    fn sqrt(self) -> Self {
        let root = Self::from(self.0.sqrt());
        (root + self / root) / Self::from(2.0)
    }

    fn if_negative(self, then: Self, otherwise: Self) -> Self {
        if self.0 < 0.0 { then } else { otherwise }
    }
}

impl AlgebraOver<f64> for Double {
    fn lift(c: f64) -> Self {
        Self::from(c)
    }

    fn scale(self, c: f64) -> Self {
        self * Self::from(c)
    }
}

#[test]
fn an_angle_has_the_sine_of_a_table() {
    let (sin, cos) = Double::from(1.0).sin_cos();
    for (found, wanted) in [(sin, 0.841_470_984_807_896_5), (cos, 0.540_302_305_868_139_8)] {
        assert!((found - Double::from(wanted)).rounded().abs() < 6e-17);
    }
    let (s, c) = Double::from(2.5).sin_cos();
    assert!((s * s + c * c - Double::from(1.0)).rounded().abs() < 1e-29);
    assert!(Double::zero().is_zero());
}
