//! Lengths and corners, of which the distances from shapes are made, with their derivatives.

use super::Distance;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::matrix;
use nalgebra::Vector3;

/// The length in m below which a distance is replaced by that from a plane: far below any relevant size, and far above
/// the size at which $1 / d^3$ overflows.
pub const FLAT: f64 = 1e-12;

/// Computes $|x| - h$.
#[inline]
pub(super) fn beyond<C: Scalar, S: AlgebraOver<C>>(x: S, half: C) -> S {
    x.if_negative(-x, x) - S::lift(half)
}

/// The positive part of a number.
#[inline]
pub(super) fn excess<S: Scalar>(q: S) -> S {
    q.if_negative(S::zero(), q)
}

#[inline]
fn sum_of_squares<S: Scalar, const K: usize>(v: &[S; K]) -> S {
    v.iter().fold(S::zero(), |sum, v| sum + *v * *v)
}

/// A number that is negative if the length with this square is below [`FLAT`].
#[inline]
fn short<S: Scalar>(square: S) -> S {
    square - S::from_f64(FLAT * FLAT)
}

/// Computes $|v|$, or the first entry if the length is below [`FLAT`].
#[inline]
pub(super) fn length<S: Scalar, const K: usize>(v: [S; K]) -> S {
    let square = sum_of_squares(&v);
    short(square).if_negative(v[0], square.sqrt())
}

/// The distance from the corner $q \le 0$: inside, from the nearest of the sides; outside, from all sides that `q` is
/// beyond.
#[inline]
pub(super) fn corner<S: Scalar, const K: usize>(q: [S; K]) -> S {
    let mut most = q[0];
    for q in &q[1..] {
        most = (most - *q).if_negative(*q, most);
    }
    let outside = sum_of_squares(&q.map(excess)).sqrt();
    (most - S::from_f64(FLAT)).if_negative(most, outside)
}

/// A function of `K` numbers that is linear in one region and a length in another, with its derivatives.
pub(super) struct Bent<S: Scalar, const K: usize> {
    pub value: S,
    pub gradient: [S; K],
    pub hessian: [[S; K]; K],
}

impl<S: Scalar, const K: usize> Bent<S, K> {
    /// Computes $|v|$ for numbers `v` whose derivatives are `moves`, one or zero; the linear function with the given
    /// value and gradient if `flat` is negative.
    #[inline]
    fn new(v: [S; K], moves: [S; K], flat: S, (value, gradient): (S, [S; K])) -> Self {
        let length = sum_of_squares(&v).sqrt();
        let inverse = S::one() / length;
        let n = v.map(|v| v * inverse);
        let hessian = |i: usize, j: usize| {
            let own = if i == j { moves[i] } else { S::zero() };
            flat.if_negative(S::zero(), (own - n[i] * n[j]) * inverse)
        };
        Self {
            value: flat.if_negative(value, length),
            gradient: std::array::from_fn(|i| flat.if_negative(gradient[i], n[i])),
            hessian: std::array::from_fn(|i| std::array::from_fn(|j| hessian(i, j))),
        }
    }

    /// Computes [`length`] of numbers whose derivatives are `moves`.
    #[inline]
    pub fn length(v: [S; K], moves: [S; K]) -> Self {
        let first = std::array::from_fn(|i| if i == 0 { S::one() } else { S::zero() });
        Self::new(v, moves, short(sum_of_squares(&v)), (v[0], first))
    }

    /// Computes [`corner`].
    #[inline]
    pub fn corner(q: [S; K]) -> Self {
        let (zero, one) = (S::zero(), S::one());
        let mut most = q[0];
        let mut nearest = std::array::from_fn(|i| if i == 0 { one } else { zero });
        for i in 1..K {
            let less = most - q[i];
            most = less.if_negative(q[i], most);
            for (j, side) in nearest.iter_mut().enumerate() {
                *side = less.if_negative(if i == j { one } else { zero }, *side);
            }
        }
        let moves = q.map(|q| q.if_negative(zero, one));
        let inside = most - S::from_f64(FLAT);
        Self::new(q.map(excess), moves, inside, (most, nearest))
    }
}

impl<S: Scalar> Bent<S, 3> {
    /// Converts to the distance from a surface at `radius`, in coordinates that differ by the signs `sign`.
    #[inline]
    pub fn distance(self, radius: S, sign: &Vector3<S>) -> Distance<S> {
        Distance {
            value: self.value - radius,
            normal: Vector3::from_fn(|i, _| self.gradient[i] * sign[i]),
            curvature: matrix(|i, j| self.hessian[i][j] * sign[i] * sign[j]),
        }
    }
}
