//! Polynomials with a bound on their error, which enclose functions.

use super::{AlgebraOver, Scalar, impl_scalar_operators};

/// The relative rounding error of one operation of `f64`.
const UNIT: f64 = f64::EPSILON / 2.0;

/// One more than the relative rounding error of a sum of up to 2^8 products of numbers that are not negative.
const UP: f64 = 1.0 + 512.0 * UNIT;

/// More than the absolute error of sums of up to 2^12 products that underflow.
const TINY: f64 = f64::MIN_POSITIVE;

/// The assumed largest error of the sine and cosine of `f64`; libraries of C are within half of it.
const SIN_COS_ERROR: f64 = 2.0 * f64::EPSILON;

/// The number of terms of the series of a sine, a root or a reciprocal.
const TERMS: u32 = 8;

/// A polynomial of degree `N - 1` in $s \in [-1, 1]$ with a bound on its error, which encloses a function:
/// $|f(s) - \sum_{k < N} c_k s^k| \le r$. With `N = 1` it is an interval, by its middle and its radius.
///
/// The result of every operation encloses those of all functions in its operands, computed exactly: the radius bounds
/// the terms of higher degree and the errors of rounding. A sum or product of coefficients with `n` terms has an error
/// of at most $\gamma_n = n u / (1 - n u)$ of that of their absolute values, with $u = 2^{-53}$ (Higham, *Accuracy and
/// Stability of Numerical Algorithms*, 3.1), and radii, sums of numbers that are not negative, are multiplied by a
/// number above one plus their own error. Where nothing is known the radius is infinite or NaN: a comparison by which a
/// bound is proved must fail for NaN.
///
/// Like [`Jet`](super::Jet) it goes through the dynamics as any scalar does: `rnea` over a polynomial motion gives
/// enclosures of torques at all times of an interval. The constants of a model, `f64`, count as exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaylorModel<const N: usize> {
    coefficients: [f64; N],
    radius: f64,
}

/// An interval, by its middle and its radius.
pub type Ball = TaylorModel<1>;

impl<const N: usize> TaylorModel<N> {
    /// A constant without error.
    #[inline]
    #[must_use]
    pub fn constant(x: f64) -> Self {
        let mut coefficients = [0.0; N];
        coefficients[0] = x;
        Self { coefficients, radius: 0.0 }
    }

    /// The polynomial with these coefficients, any number of them, and a bound on its error: those beyond degree
    /// `N - 1` become part of the radius.
    #[must_use]
    pub fn new(polynomial: &[f64], radius: f64) -> Self {
        let mut coefficients = [0.0; N];
        let kept = polynomial.len().min(N);
        coefficients[..kept].copy_from_slice(&polynomial[..kept]);
        let beyond: f64 = polynomial[kept..].iter().map(|c| c.abs()).sum();
        Self { coefficients, radius: (radius + beyond) * UP }
    }

    /// The coefficients, from degree zero.
    #[must_use]
    pub fn coefficients(&self) -> &[f64; N] {
        &self.coefficients
    }

    /// The bound on the error.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// A bound on the absolute value.
    #[inline]
    #[must_use]
    pub fn magnitude(&self) -> f64 {
        (self.size() + self.radius) * UP
    }

    /// A bound on the distance from the constant coefficient.
    #[inline]
    #[must_use]
    pub fn variation(&self) -> f64 {
        let sum: f64 = self.coefficients[1..].iter().map(|c| c.abs()).sum();
        (sum + self.radius) * UP
    }

    /// The sum of the absolute values of the coefficients, rounded.
    #[inline(always)]
    fn size(&self) -> f64 {
        self.coefficients.iter().map(|c| c.abs()).sum()
    }

    /// Adds to the radius the error of one rounding of each coefficient.
    #[inline(always)]
    fn rounded(mut self) -> Self {
        self.radius = (self.radius + UNIT * self.size()) * UP + TINY;
        self
    }

    /// The same without the constant coefficient.
    fn without_constant(mut self) -> Self {
        self.coefficients[0] = 0.0;
        self
    }

    /// The same with a larger radius.
    fn widened(mut self, by: f64) -> Self {
        self.radius = (self.radius + by) * UP;
        self
    }

    #[inline(always)]
    fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        for c in &mut self.coefficients {
            *c = f(*c);
        }
        self
    }

    /// Computes the quotient with an exact number.
    #[must_use]
    pub fn divided_by(self, x: f64) -> Self {
        let mut quotient = self.map(|c| c / x);
        quotient.radius /= x.abs();
        quotient.rounded()
    }

    #[inline(always)]
    fn product(self, other: Self) -> Self {
        let (a, b) = (&self.coefficients, &other.coefficients);
        let mut coefficients = [0.0; N];
        // The sums of the absolute values of the coefficients of `b` from degree N - 1 - i on.
        let mut beyond = 0.0;
        let mut truncated = 0.0;
        for i in 0..N {
            for j in 0..N - i {
                coefficients[i + j] += a[i] * b[j];
            }
            truncated += a[i].abs() * beyond;
            beyond += b[N - 1 - i].abs();
        }
        let size = self.size();
        let rounding = (N as f64 + 2.0) * UNIT * size * beyond;
        let errors = size * other.radius + self.radius * (beyond + other.radius);
        Self { coefficients, radius: (truncated + rounding + errors) * UP + TINY }
    }

    /// Computes the nested series $1 + x f_1 (1 + x f_2 (1 + \dots))$ with `2 TERMS` factors
    /// `[numerator, denominator]`, both exact.
    fn series(x: Self, factor: impl Fn(u32) -> [f64; 2]) -> Self {
        let one = Self::constant(1.0);
        (1..=2 * TERMS).rev().fold(one, |sum, k| {
            let [numerator, denominator] = factor(k);
            let term = (x * sum).scale(numerator).divided_by(denominator);
            one + term
        })
    }

    /// The deviation from the constant coefficient relative to it, with a bound on it below one; `None` if zero may be
    /// among the values.
    fn relative(self) -> Option<(Self, f64)> {
        let relative = self.without_constant().divided_by(self.coefficients[0]);
        let size = relative.magnitude();
        (size < 0.999).then_some((relative, size))
    }

    /// A bound on the sum of the powers of `size`, below one, that a [`series`](Self::series) leaves out.
    fn rest(size: f64) -> f64 {
        // The powers are computed with relative errors of far less than the factor.
        1.01 * size.powi(2 * TERMS as i32 + 1) / (1.0 - size)
    }

    /// Encloses nothing, because nothing is known.
    fn unknown() -> Self {
        Self { coefficients: [0.0; N], radius: f64::INFINITY }
    }

    fn reciprocal(self) -> Self {
        let Some((x, size)) = self.relative() else {
            return Self::unknown();
        };
        let series = Self::series(x, |_| [-1.0, 1.0]).widened(Self::rest(size));
        series.divided_by(self.coefficients[0])
    }

    /// Encloses both.
    fn hull(self, other: Self) -> Self {
        let (a, b) = (self.scale(0.5), other.scale(0.5));
        // The difference is rounded too. A maximum would lose a radius that is NaN.
        (a + b).widened((a - b).magnitude())
    }
}

impl_scalar_operators! {
    #[inline(always)]
    impl [const N: usize] for TaylorModel<N> {
        zero() => Self::constant(0.0),
        one() => Self::constant(1.0),
        is_zero(a) => a == Self::constant(0.0),
        neg(a) => a.map(|c| -c),
        add(a, b) => {
            let mut sum = a;
            for k in 0..N {
                sum.coefficients[k] += b.coefficients[k];
            }
            sum.radius += b.radius;
            sum.rounded()
        },
        sub(a, b) => a + (-b),
        mul(a, b) => a.product(b),
        div(a, b) => a.product(b.reciprocal()),
    }
}

impl<const N: usize> Scalar for TaylorModel<N> {
    #[inline]
    fn from_f64(x: f64) -> Self {
        Self::constant(x)
    }

    /// By the series about the constant coefficient. A radius of at most one is assumed of the deviation from it;
    /// beyond, both values are between minus one and one.
    fn sin_cos(self) -> (Self, Self) {
        let turn = self.without_constant();
        let size = turn.magnitude();
        let ball = |x: f64, radius: f64| Self::constant(x).widened(radius);
        // NaN too.
        if !(size <= 1.0 && self.coefficients[0].is_finite()) {
            return (ball(0.0, 1.0), ball(0.0, 1.0));
        }
        let square = turn * turn;
        // 1 - x^2 / (n (n - 1)) (1 - x^2 / ((n - 2) (n - 3)) (1 - ...)) from n = 2 TERMS, or one more, down.
        let one = Self::constant(1.0);
        let nested = |odd: u32| {
            (1..=TERMS).rev().fold(one, |sum, k| {
                let n = f64::from(2 * k + odd);
                one - (square * sum).divided_by(n * (n - 1.0))
            })
        };
        // Less than the first term left out, as the signs alternate: 18! is above 6.4e15.
        let rest = size.powi(2 * TERMS as i32 + 2) / 6e15;
        let (cos_turn, sin_turn) = (nested(0).widened(rest), (turn * nested(1)).widened(rest));
        let (sin, cos) = self.coefficients[0].sin_cos();
        let (sin, cos) = (ball(sin, SIN_COS_ERROR), ball(cos, SIN_COS_ERROR));
        (sin * cos_turn + cos * sin_turn, cos * cos_turn - sin * sin_turn)
    }

    /// By the binomial series about the constant coefficient; unknown if zero may be among the values.
    fn sqrt(self) -> Self {
        let middle = self.coefficients[0];
        let Some((x, size)) = self.relative().filter(|_| middle > 0.0) else {
            return Self::unknown();
        };
        // The coefficients of the series are below one.
        let series = Self::series(x, |k| [1.5 - f64::from(k), f64::from(k)]);
        series.widened(Self::rest(size)).scale(middle.sqrt()).widened(2.0 * UNIT * middle.sqrt())
    }

    /// Encloses both numbers if the sign is not known.
    fn if_negative(self, then: Self, otherwise: Self) -> Self {
        let variation = self.variation();
        if self.coefficients[0] + variation < 0.0 {
            then
        } else if self.coefficients[0] - variation >= 0.0 {
            otherwise
        } else {
            then.hull(otherwise)
        }
    }
}

impl<const N: usize> AlgebraOver<f64> for TaylorModel<N> {
    #[inline(always)]
    fn lift(c: f64) -> Self {
        Self::constant(c)
    }

    #[inline(always)]
    fn scale(self, c: f64) -> Self {
        let mut scaled = self.map(|x| x * c);
        scaled.radius *= c.abs();
        scaled.rounded()
    }
}
