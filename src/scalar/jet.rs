//! Dual numbers over any scalar.

use super::{AlgebraOver, Scalar, Tanh, Zero, impl_scalar_operators};

/// A number with `N` tangents over any [`Scalar`]: $x + \sum_i \epsilon_i x_i$ with $\epsilon_i \epsilon_j = 0$.
///
/// It has the functions of `num-dual`'s dual numbers over floating point, but does not require an ordered scalar, so
/// that it also works over a prime field and SIMD lanes. Unlike there, `==` compares the tangents too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<S, const N: usize> {
    /// The value.
    pub re: S,
    /// The tangents.
    pub eps: [S; N],
}

impl<S: Scalar, const N: usize> Jet<S, N> {
    /// A constant, with zero tangents.
    #[inline]
    #[must_use]
    pub fn constant(re: S) -> Self {
        Self { re, eps: [S::zero(); N] }
    }

    /// A number from its value and its tangents.
    #[inline]
    #[must_use]
    pub fn new(re: S, eps: [S; N]) -> Self {
        Self { re, eps }
    }

    /// Computes `self * other` by the product rule.
    #[inline]
    fn product(self, other: Self) -> Self {
        let eps = std::array::from_fn(|i| self.eps[i] * other.re + self.re * other.eps[i]);
        Self::new(self.re * other.re, eps)
    }

    /// Computes `self / other` with one division.
    #[inline]
    fn quotient(self, other: Self) -> Self {
        let inverse = S::one() / other.re;
        let re = self.re * inverse;
        let eps = std::array::from_fn(|i| (self.eps[i] - re * other.eps[i]) * inverse);
        Self::new(re, eps)
    }

    /// Computes `f(self)` from the value `re` and the derivative `slope` of `f`.
    #[inline]
    fn chain(self, re: S, slope: S) -> Self {
        Self::new(re, self.eps.map(|e| e * slope))
    }
}

impl_scalar_operators! {
    #[inline]
    impl [S: Scalar, const N: usize] for Jet<S, N> {
        zero() => Self::constant(S::zero()),
        one() => Self::constant(S::one()),
        is_zero(a) => a.re.is_zero() && a.eps.iter().all(Zero::is_zero),
        neg(a) => Self::new(-a.re, a.eps.map(|e| -e)),
        add(a, b) => Self::new(a.re + b.re, std::array::from_fn(|i| a.eps[i] + b.eps[i])),
        sub(a, b) => Self::new(a.re - b.re, std::array::from_fn(|i| a.eps[i] - b.eps[i])),
        mul(a, b) => a.product(b),
        div(a, b) => a.quotient(b),
    }
}

impl<S: Scalar, const N: usize> Scalar for Jet<S, N> {
    #[inline]
    fn from_f64(x: f64) -> Self {
        Self::constant(S::from_f64(x))
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.re.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    #[inline]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, S::one() / (root + root))
    }

    #[inline]
    fn if_negative(self, then: Self, otherwise: Self) -> Self {
        let eps = std::array::from_fn(|i| self.re.if_negative(then.eps[i], otherwise.eps[i]));
        Self::new(self.re.if_negative(then.re, otherwise.re), eps)
    }

    #[inline]
    fn vanishes(&self) -> bool {
        self.re.vanishes() && self.eps.iter().all(S::vanishes)
    }
}

impl<S: Tanh, const N: usize> Tanh for Jet<S, N> {
    #[inline]
    fn tanh(self) -> Self {
        let tanh = self.re.tanh();
        self.chain(tanh, S::one() - tanh * tanh)
    }
}

impl<C, S: AlgebraOver<C>, const N: usize> AlgebraOver<C> for Jet<S, N>
where
    C: Copy,
{
    #[inline]
    fn lift(c: C) -> Self {
        Self::constant(S::lift(c))
    }

    #[inline]
    fn scale(self, c: C) -> Self {
        Self::new(self.re.scale(c), self.eps.map(|e| e.scale(c)))
    }
}
