//! Dual numbers over any scalar.

use super::{AlgebraOver, Scalar};
use num_traits::{One, Zero};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A number with `N` tangents over any [`Scalar`]: $x + \sum_i \epsilon_i x_i$ with $\epsilon_i \epsilon_j = 0$.
///
/// It is what `num-dual` offers over floating-point numbers, without asking that the scalar has an order: so it runs over
/// a prime field and over SIMD lanes as well. Unlike there, `==` compares the tangents too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<S, const N: usize> {
    /// The value.
    pub re: S,
    /// The tangents.
    pub eps: [S; N],
}

impl<S: Scalar, const N: usize> Jet<S, N> {
    /// A constant.
    #[inline]
    #[must_use]
    pub fn constant(re: S) -> Self {
        Self {
            re,
            eps: [S::zero(); N],
        }
    }

    /// A value and its tangents.
    #[inline]
    #[must_use]
    pub fn new(re: S, eps: [S; N]) -> Self {
        Self { re, eps }
    }

    /// `self * other`, by the product rule.
    #[inline]
    fn product(self, other: Self) -> Self {
        let eps = std::array::from_fn(|i| self.eps[i] * other.re + self.re * other.eps[i]);
        Self::new(self.re * other.re, eps)
    }

    /// `self / other`, with one division.
    #[inline]
    fn quotient(self, other: Self) -> Self {
        let inverse = S::one() / other.re;
        let re = self.re * inverse;
        let eps = std::array::from_fn(|i| (self.eps[i] - re * other.eps[i]) * inverse);
        Self::new(re, eps)
    }

    /// `f(self)` where `f` has the value `re` and the derivative `slope` there.
    #[inline]
    fn chain(self, re: S, slope: S) -> Self {
        Self::new(re, self.eps.map(|e| e * slope))
    }
}

impl<S: Scalar, const N: usize> Add for Jet<S, N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        let eps = std::array::from_fn(|i| self.eps[i] + other.eps[i]);
        Self::new(self.re + other.re, eps)
    }
}

impl<S: Scalar, const N: usize> Sub for Jet<S, N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        let eps = std::array::from_fn(|i| self.eps[i] - other.eps[i]);
        Self::new(self.re - other.re, eps)
    }
}

impl<S: Scalar, const N: usize> Mul for Jet<S, N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.product(other)
    }
}

impl<S: Scalar, const N: usize> Div for Jet<S, N> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        self.quotient(other)
    }
}

impl<S: Scalar, const N: usize> Neg for Jet<S, N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self::new(-self.re, self.eps.map(|e| -e))
    }
}

/// The operators that assign, by those that do not.
macro_rules! assign {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl<S: Scalar, const N: usize> $trait for Jet<S, N> {
            #[inline]
            fn $method(&mut self, other: Self) {
                *self = *self $op other;
            }
        }
    )*};
}

assign!(AddAssign add_assign +, SubAssign sub_assign -, MulAssign mul_assign *, DivAssign div_assign /);

impl<S: Scalar, const N: usize> Zero for Jet<S, N> {
    #[inline]
    fn zero() -> Self {
        Self::constant(S::zero())
    }

    fn is_zero(&self) -> bool {
        self.re.is_zero() && self.eps.iter().all(Zero::is_zero)
    }
}

impl<S: Scalar, const N: usize> One for Jet<S, N> {
    #[inline]
    fn one() -> Self {
        Self::constant(S::one())
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
