//! Motion and force vectors and their products.

use super::{cross, dot};
use crate::scalar::Scalar;
use nalgebra::Vector3;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// A spatial motion vector: velocity, acceleration or joint axis. rad/s and m/s, or their rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<S: Scalar> {
    /// Angular part.
    pub angular: Vector3<S>,
    /// Linear part, of the body-fixed point that is at the origin.
    pub linear: Vector3<S>,
}

/// A spatial force vector: force, momentum. N m and N, or their time integrals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force<S: Scalar> {
    /// Moment about the origin.
    pub angular: Vector3<S>,
    /// Linear force.
    pub linear: Vector3<S>,
}

/// Implements the vector space operations of motions and forces.
macro_rules! vector_space {
    ($name:ident) => {
        impl<S: Scalar> $name<S> {
            /// A vector from its angular and its linear part.
            #[must_use]
            pub fn new(angular: Vector3<S>, linear: Vector3<S>) -> Self {
                Self { angular, linear }
            }

            /// The zero vector.
            #[must_use]
            pub fn zero() -> Self {
                Self::new(Vector3::zeros(), Vector3::zeros())
            }
        }

        impl<S: Scalar> Add for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self::new(self.angular + other.angular, self.linear + other.linear)
            }
        }

        impl<S: Scalar> Sub for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self::new(self.angular - other.angular, self.linear - other.linear)
            }
        }

        impl<S: Scalar> AddAssign for $name<S> {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl<S: Scalar> SubAssign for $name<S> {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }

        impl<S: Scalar> Neg for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::new(-self.angular, -self.linear)
            }
        }

        impl<S: Scalar> Mul<S> for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, factor: S) -> Self {
                Self::new(self.angular * factor, self.linear * factor)
            }
        }
    };
}

vector_space!(Motion);
vector_space!(Force);

impl<S: Scalar> Force<S> {
    /// A moment without a linear force.
    #[inline(always)]
    #[must_use]
    pub fn couple(moment: Vector3<S>) -> Self {
        Self::new(moment, Vector3::zeros())
    }
}

impl<S: Scalar> Motion<S> {
    /// Computes $v \times m$, the rate of change of `m` when it moves with velocity `self` (2.31 in the book).
    #[inline(always)]
    #[must_use]
    pub fn cross(&self, m: &Self) -> Self {
        Self::new(cross(&self.angular, &m.angular), cross(&self.angular, &m.linear) + cross(&self.linear, &m.angular))
    }

    /// Computes $v \times^* f$, the rate of change of `f` when it moves with velocity `self` (2.32 in the book).
    #[inline(always)]
    #[must_use]
    pub fn cross_force(&self, f: &Force<S>) -> Force<S> {
        Force::new(cross(&self.angular, &f.angular) + cross(&self.linear, &f.linear), cross(&self.angular, &f.linear))
    }

    /// Computes $m \cdot f$, a power or a generalised force.
    #[inline(always)]
    #[must_use]
    pub fn dot(&self, f: &Force<S>) -> S {
        dot(&self.angular, &f.angular) + dot(&self.linear, &f.linear)
    }
}
