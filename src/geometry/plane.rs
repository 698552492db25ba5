//! The plane that separates two convex bodies best.

use super::Convex;
use super::convex::{Extent, is_nowhere_negative};
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Placement, apply, apply_transpose, cross_matrix, dot, multiply, outer};
use nalgebra::{Matrix3, Vector3};

/// The largest number of steps.
const MAX_STEPS: usize = 40;

/// The squared length of a step below which the normal is found, after a step to first order of the points and to
/// second order of the gap.
const TOLERANCE: f64 = 1e-10;

/// The squared length of a step below which the normal is found if derivatives are needed too.
const FINE: f64 = 1e-20;

/// The squared length of a step below which the normal of the first smoothing is found.
const ROUGH: f64 = 1e-4;

/// The longest step, rad.
const LONGEST: f64 = 0.5;

/// The least curvature of the gap over directions, relative to the lengths that it has: where the bodies overlap, the
/// gap may have no maximum nearby.
const LEAST: f64 = 1e-3;

/// The widths of the smoothing of bodies, m: the first one finds the best plane where they overlap, and with the second
/// one the gap is up to about as much less than the distance.
#[cfg(feature = "solvers")]
pub(crate) const WIDTHS: [f64; 2] = [0.03, 0.002];

/// The number of further steps of numbers with derivatives.
const FOLLOWING: usize = 3;

/// A body in the base frame.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a, C: Scalar, S: Scalar> {
    /// The body.
    pub convex: &'a Convex<C>,
    /// The placement of its frame; `None` is the base frame.
    pub placement: Option<&'a Placement<S>>,
}

/// The end of a search for a plane.
#[derive(Clone, Copy, Debug)]
pub enum Until<S> {
    /// A gap as large as this, m, or the largest one.
    Gap(S),
    /// The largest gap, to rounding.
    Value,
    /// The largest gap, with its derivatives.
    Derivatives,
}

/// The plane with the largest gap between two bodies.
#[derive(Clone, Copy, Debug)]
pub struct Plane<S: Scalar> {
    /// Its unit normal, from the second body to the first one.
    pub normal: Vector3<S>,
    /// The gap between the bodies along the normal, m: smoothed, without their radii, negative where they overlap.
    pub gap: S,
    /// The average of the nearest points of the first body, m, and the same of the second one.
    pub points: [Vector3<S>; 2],
    /// The Hessian of the smoothed extent of the first body, and that of both, m.
    curvatures: [Matrix3<S>; 2],
    /// True if the normal follows the bodies, false for that of a half-space.
    is_free: bool,
}

impl<'a, C: Scalar, S: AlgebraOver<C>> Placed<'a, C, S> {
    /// The smoothed extent in a direction of length one.
    fn extent(&self, direction: &Vector3<S>, width: f64) -> Extent<S> {
        let Some(Placement { rotation, translation }) = self.placement else {
            return self.convex.smoothed(direction, width);
        };
        let own = self.convex.smoothed(&apply_transpose(rotation, direction), width);
        Extent {
            value: own.value + dot(direction, translation),
            point: apply(rotation, &own.point) + translation,
            curvature: multiply(&multiply(rotation, &own.curvature), &rotation.transpose()),
        }
    }
}

/// A basis of the plane across a unit vector.
fn tangents<S: Scalar>(n: &Vector3<S>) -> [Vector3<S>; 2] {
    let sign = n.z.if_negative(-S::one(), S::one());
    let a = -S::one() / (sign + n.z);
    let b = n.x * n.y * a;
    [Vector3::new(S::one() + sign * n.x * n.x * a, sign * b, -sign * n.x), Vector3::new(b, sign + n.y * n.y * a, -n.y)]
}

/// Returns true for numbers with derivatives, for which the root of zero does not vanish.
fn has_derivatives<S: Scalar>() -> bool {
    !S::zero().sqrt().vanishes()
}

/// A vector of length one with the same direction.
fn unit<S: Scalar>(v: &Vector3<S>) -> Vector3<S> {
    v * (S::one() / dot(v, v).sqrt())
}

impl<S: Scalar> Plane<S> {
    /// The plane with this normal.
    fn new<C: Scalar>([a, b]: &[Placed<'_, C, S>; 2], normal: Vector3<S>, width: f64) -> Self
    where
        S: AlgebraOver<C>,
    {
        let (first, second) = (a.extent(&-normal, width), b.extent(&normal, width));
        Self {
            normal,
            gap: -first.value - second.value,
            points: [first.point, second.point],
            curvatures: [first.curvature, first.curvature + second.curvature],
            is_free: true,
        }
    }

    /// The best plane between two bodies, or one with a gap that is enough, by Newton's method on the sphere: from a
    /// direction from the second body to the first one, where they overlap also with extents that are smoothed with the
    /// first of the widths and then with the second one; or from the normal of a plane nearby, if there is a gap.
    ///
    /// Where there is one, no other plane has a maximum of the gap. Where the bodies overlap, others may have, so that
    /// the plane is one that does not depend on that nearby.
    pub fn between<C: Scalar>(
        bodies: &[Placed<'_, C, S>; 2],
        (off, hint): (impl Fn() -> Vector3<S>, Option<&Vector3<S>>),
        [first, width]: [f64; 2],
        until: Until<S>,
    ) -> Self
    where
        S: AlgebraOver<C>,
    {
        let (last, enough) = match until {
            Until::Gap(enough) => (TOLERANCE, Some(enough)),
            Until::Value => (TOLERANCE, None),
            Until::Derivatives => (FINE, None),
        };
        let from = |normal: &Vector3<S>, width: f64, tolerance: f64| {
            let mut plane = Self::new(bodies, unit(normal), width);
            plane.improve(bodies, width, tolerance, enough);
            plane
        };
        let anew = || {
            let off = off();
            let mut plane = from(&off, width, last);
            if !is_nowhere_negative(plane.gap) {
                let other = from(&from(&off, first, ROUGH).normal, width, last);
                let gain = other.gap - plane.gap;
                plane.take(&other, gain);
            }
            plane
        };
        let Some(hint) = hint else {
            return anew();
        };
        let mut plane = from(hint, width, last);
        if !is_nowhere_negative(plane.gap) {
            let overlap = -plane.gap;
            plane.take(&anew(), overlap);
        }
        plane
    }

    /// The plane of a half-space $n \cdot p \le \delta$ and the gap between it and a body.
    #[must_use]
    pub fn of_half_space<C: Scalar>(body: &Placed<'_, C, S>, n: &Vector3<S>, offset: S, width: f64) -> Self
    where
        S: AlgebraOver<C>,
    {
        let Extent { value, point, curvature } = body.extent(&-n, width);
        Self { normal: *n, gap: -value - offset, points: [point; 2], curvatures: [curvature; 2], is_free: false }
    }

    fn improve<C: Scalar>(&mut self, bodies: &[Placed<'_, C, S>; 2], width: f64, tolerance: f64, enough: Option<S>)
    where
        S: AlgebraOver<C>,
    {
        let limit = S::from_f64(LONGEST);
        let mut longest = limit;
        // Derivatives follow the real part by some steps.
        let mut left = if has_derivatives::<S>() { FOLLOWING } else { 0 };
        for _ in 0..MAX_STEPS {
            if enough.is_some_and(|enough| is_nowhere_negative(self.gap - enough)) {
                break;
            }
            let (basis, inverse) = self.inverse();
            let ascent = self.points[0] - self.points[1];
            let [x, y] = [dot(&basis[0], &ascent), dot(&basis[1], &ascent)];
            let mut step = basis[0] * (inverse[0] * x + inverse[1] * y) + basis[1] * (inverse[1] * x + inverse[2] * y);
            let square = dot(&step, &step);
            let over = longest * longest - square;
            let guarded = over.if_negative(square, S::one());
            let shorter = longest / guarded.sqrt();
            step *= over.if_negative(shorter, S::one());
            if is_nowhere_negative(S::from_f64(tolerance) - dot(&step, &step)) {
                if left == 0 {
                    self.finish(&step, &ascent);
                    break;
                }
                left -= 1;
            }
            let next = Self::new(bodies, unit(&(self.normal + step)), width);
            // Rounding is no loss.
            let gain = next.gap - self.gap + S::from_f64(1e-14);
            let longer = longest * S::from_f64(2.0);
            let longer = (longer - limit).if_negative(longer, limit);
            longest = gain.if_negative(longest * S::from_f64(0.25), longer);
            self.take(&next, gain);
        }
    }

    /// Takes a short step without another evaluation.
    fn finish(&mut self, step: &Vector3<S>, ascent: &Vector3<S>) {
        let [first, both] = &self.curvatures;
        self.gap += dot(step, ascent) * S::from_f64(0.5);
        let moved = [apply(first, step), apply(&(both - first), step)];
        self.points[0] -= moved[0];
        self.points[1] += moved[1];
        self.normal = unit(&(self.normal + step));
    }

    /// Takes another plane where a number is not negative.
    fn take(&mut self, next: &Self, gain: S) {
        let choose = |own: &S, other: &S| gain.if_negative(*own, *other);
        self.gap = choose(&self.gap, &next.gap);
        self.normal = self.normal.zip_map(&next.normal, |a, b| choose(&a, &b));
        for (own, next) in self.points.iter_mut().zip(&next.points) {
            *own = own.zip_map(next, |a, b| choose(&a, &b));
        }
        for (own, next) in self.curvatures.iter_mut().zip(&next.curvatures) {
            *own = own.zip_map(next, |a, b| choose(&a, &b));
        }
    }

    /// A basis across the normal, and the inverse of the negative Hessian of the gap over directions in it, with a
    /// positive curvature at least.
    fn inverse(&self) -> ([Vector3<S>; 2], [S; 3]) {
        let basis = tangents(&self.normal);
        let [_, both] = &self.curvatures;
        let length = dot(&self.normal, &(self.points[0] - self.points[1]));
        let bent = basis.each_ref().map(|t| apply(both, t));
        let (p, q, r) =
            (dot(&basis[0], &bent[0]) + length, dot(&basis[0], &bent[1]), dot(&basis[1], &bent[1]) + length);
        let half = S::from_f64(0.5);
        let (middle, off) = ((p + r) * half, (p - r) * half);
        let root = (off * off + q * q + S::from_f64(1e-30)).sqrt();
        let size = length.if_negative(-length, length) + S::from_f64(LEAST);
        let missing = S::from_f64(LEAST) * size - (middle - root);
        let shift = missing.if_negative(S::zero(), missing);
        let (p, r) = (p + shift, r + shift);
        let determinant = S::one() / (p * r - q * q);
        (basis, [r * determinant, -q * determinant, p * determinant])
    }

    /// The blocks of the second derivative of the gap in the motion of the first body as seen from the second one, 6 by
    /// 6: with $Y \xi = v + \omega \times a + C (\omega \times n)$ for the average `a` of its nearest points and the
    /// Hessian `C` of its extent, and the inverse `N` of the negative Hessian over directions,
    /// $K = Y^T ([n_\times, 0] + N Y)$.
    #[must_use]
    pub fn coupling(&self) -> [[Matrix3<S>; 2]; 2] {
        let (basis, [xx, xy, yy]) = self.inverse();
        let [t, u] = &basis;
        let inverse =
            if self.is_free { outer(&(t * xx + u * xy), t) + outer(&(t * xy + u * yy), u) } else { Matrix3::zeros() };
        let turn = cross_matrix(&self.normal);
        let angular = -cross_matrix(&self.points[0]) - multiply(&self.curvatures[0], &turn);
        let below = turn + multiply(&inverse, &angular);
        let across = angular.transpose();
        [[multiply(&across, &below), multiply(&across, &inverse)], [below, inverse]]
    }
}
