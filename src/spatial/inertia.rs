//! The spatial inertia of a rigid body, or of several that move together.

use super::{Force, Motion, Placement, apply, apply_to_constant, cross, cross_matrix, dot, symmetric};
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{Matrix3, Matrix6, Vector3};
use std::ops::{Add, AddAssign};

/// A spatial inertia about the origin, ten numbers (2.63 in Featherstone's book).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia<S: Scalar> {
    /// Mass, kg.
    pub mass: S,
    /// First moment $h = m c$: mass times the centre of mass, kg m.
    pub first_moment: Vector3<S>,
    /// Rotational inertia $\bar I$ about the origin (not the centre of mass), kg m^2, symmetric.
    pub rotational: Matrix3<S>,
}

impl<S: Scalar> Inertia<S> {
    /// Zero inertia.
    #[must_use]
    pub fn zero() -> Self {
        Self { mass: S::zero(), first_moment: Vector3::zeros(), rotational: Matrix3::zeros() }
    }

    /// Builds the inertia from the mass, the centre of mass `com` and the rotational inertia about `com`.
    #[must_use]
    pub fn from_com(mass: S, com: Vector3<S>, rotational: Matrix3<S>) -> Self {
        let c = cross_matrix(&com);
        Self { mass, first_moment: com * mass, rotational: rotational - c * c * mass }
    }

    /// Computes the momentum $I m$ of a body with this inertia and velocity `m`.
    #[inline(always)]
    #[must_use]
    pub fn apply(&self, m: &Motion<S>) -> Force<S> {
        let h = &self.first_moment;
        Force::new(
            apply(&self.rotational, &m.angular) + cross(h, &m.linear),
            m.linear * self.mass - cross(h, &m.angular),
        )
    }

    /// Transforms the inertia of a body from frame B to frame A, where `placement` is that of B in A (2.66).
    #[must_use]
    #[inline(always)]
    pub fn placed<T: AlgebraOver<S>>(&self, placement: &Placement<T>) -> Inertia<T> {
        let (r, p) = (&placement.rotation, &placement.translation);
        let mass = T::lift(self.mass);
        let h = apply_to_constant(r, &self.first_moment);
        let column = |j| apply_to_constant(r, &self.rotational.column(j).into_owned());
        let half = [column(0), column(1), column(2)];
        // [a]x [b]x = b a^T - (a . b) 1, and the moved centre is h + m p.
        let moved = h + p * mass;
        let trace = dot(p, &h) + dot(&moved, p);
        let rotational = symmetric(|i, j| {
            let turned = half[0][i] * r[(j, 0)] + half[1][i] * r[(j, 1)] + half[2][i] * r[(j, 2)];
            let outer = p[i] * h[j] + moved[i] * p[j];
            turned + if i == j { trace - outer } else { -outer }
        });
        Inertia { mass, first_moment: moved, rotational }
    }

    /// The 6 by 6 matrix, angular rows first.
    #[must_use]
    pub fn to_matrix(&self) -> Matrix6<S> {
        let h = cross_matrix(&self.first_moment);
        let mut matrix = Matrix6::zeros();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.rotational);
        matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(&h);
        matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(&-h);
        matrix.fixed_view_mut::<3, 3>(3, 3).fill_diagonal(self.mass);
        matrix
    }
}

impl<S: Scalar> Add for Inertia<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            rotational: self.rotational + other.rotational,
        }
    }
}

impl<S: Scalar> AddAssign for Inertia<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
