//! The Coriolis matrix of a body, `B` of the derivative algorithms.

use super::{Force, Inertia, Motion, apply, apply_transpose, cross, dot, matrix};
use crate::scalar::Scalar;
use nalgebra::{Matrix3, Vector3};
use std::ops::{Add, AddAssign};

/// The Coriolis matrix of a body with inertia $I$ and velocity $v$,
///
/// $$ B = \tfrac12 \left( v \times^* I - I\\, v \times + (I v) \bar\times^* \right), $$
///
/// where $f \bar\times^* m = m \times^* f$ (Singh, Russell and Wensing, "Efficient analytical derivatives of rigid-body
/// dynamics using spatial vector algebra", 2022). For a particle of mass $\mu$ at $r$ with velocity $\dot r$ the
/// definition reduces to $B m = (r \times f, f)$ with $f = \mu\\, m_\omega \times \dot r$. Therefore `B` depends only
/// on the angular part of its argument and twelve numbers represent it. It satisfies $\dot I = B + B^T$ and
/// $B v = v \times^* I v$, and it adds up over bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coriolis<S: Scalar> {
    /// The block that maps an angular motion to a moment: $-\sum \mu\\, r_\times \dot r_\times$.
    moment: Matrix3<S>,
    /// The linear momentum $\sum \mu\\, \dot r$.
    momentum: Vector3<S>,
}

impl<S: Scalar> Coriolis<S> {
    /// Computes `B` of a body with inertia `inertia` and velocity `v`, both about the same origin.
    #[inline(always)]
    #[must_use]
    pub fn new(inertia: &Inertia<S>, v: &Motion<S>) -> Self {
        // With r' = v_O + w x r the sum is -[h]x [v_O]x - [w]x S, where S = 1/2 tr(I) 1 - I holds the second moments.
        let h = &inertia.first_moment;
        let bar = &inertia.rotational;
        let half_trace = (bar[(0, 0)] + bar[(1, 1)] + bar[(2, 2)]) * S::from_f64(0.5);
        let second = matrix(|i, j| if i == j { half_trace } else { S::zero() } - bar[(i, j)]);
        let (along, w) = (dot(h, &v.linear), &v.angular);
        let turned = |j| cross(w, &Vector3::new(second[(0, j)], second[(1, j)], second[(2, j)]));
        let turned = [turned(0), turned(1), turned(2)];
        let moment = matrix(|i, j| {
            let hv = v.linear[i] * h[j];
            -turned[j][i] - if i == j { hv - along } else { hv }
        });
        Self { moment, momentum: v.linear * inertia.mass + cross(w, h) }
    }

    /// Computes $B m$.
    #[inline(always)]
    #[must_use]
    pub fn apply(&self, m: &Motion<S>) -> Force<S> {
        Force::new(apply(&self.moment, &m.angular), cross(&m.angular, &self.momentum))
    }

    /// Computes $B^T m$, a couple: a force with this moment and no linear part.
    #[inline(always)]
    #[must_use]
    pub fn apply_transpose(&self, m: &Motion<S>) -> Vector3<S> {
        apply_transpose(&self.moment, &m.angular) + cross(&self.momentum, &m.linear)
    }

    /// Computes $m \times^* B - B\\, m \times$, the rate of change of `B` when the bodies, with their velocities, move
    /// with velocity `m`.
    #[inline(always)]
    #[must_use]
    pub fn carried(&self, m: &Motion<S>) -> Self {
        // [w]x M - M [w]x from the turning, and (u . p) 1 - p u^T from the moment of p, which moves with the linear
        // part u.
        let (w, p, u) = (&m.angular, &self.momentum, &m.linear);
        let column = |j: usize| cross(w, &self.moment.column(j).into_owned());
        let turned = [column(0), column(1), column(2)];
        let row = |i: usize| {
            let row = |j| self.moment[(i, j)];
            cross(&Vector3::new(row(0), row(1), row(2)), w)
        };
        let back = [row(0), row(1), row(2)];
        let along = dot(u, p);
        let moment = matrix(|i, j| {
            let moved = p[i] * u[j];
            turned[j][i] - back[i][j] + if i == j { along - moved } else { -moved }
        });
        Self { moment, momentum: cross(w, p) }
    }
}

impl<S: Scalar> Add for Coriolis<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { moment: self.moment + other.moment, momentum: self.momentum + other.momentum }
    }
}

impl<S: Scalar> AddAssign for Coriolis<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
