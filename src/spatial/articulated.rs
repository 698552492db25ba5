//! The inertia of a body with moving bodies attached to it.

use super::{Force, Inertia, Motion, apply, apply_transpose, cross_matrix, matrix, symmetric};
use crate::scalar::Scalar;
use nalgebra::Matrix3;
use std::ops::AddAssign;

/// The articulated-body inertia $I^A$ (7.1 in Featherstone's book), about the origin: a symmetric 6 by 6 matrix, whose
/// blocks are those of table 2.5. Unlike those of an [`Inertia`] they are independent of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArticulatedInertia<S: Scalar> {
    /// The block that maps an angular acceleration to a moment, symmetric.
    rotational: Matrix3<S>,
    /// The block that maps a linear acceleration to a moment.
    coupling: Matrix3<S>,
    /// The block that maps a linear acceleration to a force, symmetric.
    mass: Matrix3<S>,
}

impl<S: Scalar> ArticulatedInertia<S> {
    /// The inertia of a single body.
    #[inline(always)]
    #[must_use]
    pub fn new(inertia: &Inertia<S>) -> Self {
        Self {
            rotational: inertia.rotational,
            coupling: cross_matrix(&inertia.first_moment),
            mass: matrix(|i, j| if i == j { inertia.mass } else { S::zero() }),
        }
    }

    /// Computes $I^A m$, the force that the acceleration `m` requires.
    #[inline(always)]
    #[must_use]
    pub fn apply(&self, m: &Motion<S>) -> Force<S> {
        Force::new(
            apply(&self.rotational, &m.angular) + apply(&self.coupling, &m.linear),
            apply_transpose(&self.coupling, &m.angular) + apply(&self.mass, &m.linear),
        )
    }

    /// Computes $I^A - \gamma\\, u u^T$, the inertia beyond a joint that moves freely, with the force $u = I^A S$ and
    /// $\gamma = 1 / (S^T u)$ (7.2.1 in the book).
    #[inline(always)]
    #[must_use]
    pub fn without(&self, u: &Force<S>, gamma: S) -> Self {
        let scaled = *u * gamma;
        Self {
            rotational: symmetric(|i, j| self.rotational[(i, j)] - scaled.angular[i] * u.angular[j]),
            coupling: matrix(|i, j| self.coupling[(i, j)] - scaled.angular[i] * u.linear[j]),
            mass: symmetric(|i, j| self.mass[(i, j)] - scaled.linear[i] * u.linear[j]),
        }
    }
}

impl<S: Scalar> AddAssign for ArticulatedInertia<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.rotational += other.rotational;
        self.coupling += other.coupling;
        self.mass += other.mass;
    }
}
