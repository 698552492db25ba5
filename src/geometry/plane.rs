//! The plane that separates two convex bodies best.

use super::Placed;
use super::convex::{Extent, is_nowhere_negative};
use super::placed::OwnExtent;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{apply, cross_matrix, dot, multiply, outer};
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

/// The squared turn of a body up to which its extents in other directions follow from the known one.
const KNOWN: f64 = 1e-10;

/// The largest number of steps by known extents.
const KNOWN_STEPS: usize = 4;

/// The number of further steps of numbers with derivatives.
const FOLLOWING: usize = 3;

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
    /// The extents that were computed last, in the frames of the bodies.
    own: [OwnExtent<S>; 2],
    /// True if the normal follows the bodies, false for that of a half-space.
    is_free: bool,
}

/// A plane between two bodies, from which the search for that between the same bodies in other places begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneHint<S: Scalar> {
    normal: Vector3<S>,
    own: [OwnExtent<S>; 2],
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
    fn new<C: Scalar>(
        bodies: &[Placed<'_, C, S>; 2],
        normal: Vector3<S>,
        width: f64,
        known: Option<&[OwnExtent<S>; 2]>,
    ) -> Self
    where
        S: AlgebraOver<C>,
    {
        let [a, b] = bodies;
        let [first, second] = [0, 1].map(|i| known.map(|known| &known[i]));
        let own = [a.extent(&-normal, width, first), b.extent(&normal, width, second)];
        Self::with(bodies, normal, own, own.each_ref().map(|own| &own.extent))
    }

    /// The plane with this normal and these extents in the frames of the bodies, of which some were computed.
    fn with<C: Scalar>(
        [a, b]: &[Placed<'_, C, S>; 2],
        normal: Vector3<S>,
        own: [OwnExtent<S>; 2],
        [first, second]: [&Extent<S>; 2],
    ) -> Self
    where
        S: AlgebraOver<C>,
    {
        let (first, second) = (a.in_base(&-normal, first), b.in_base(&normal, second));
        Self {
            normal,
            gap: -first.value - second.value,
            points: [first.point, second.point],
            curvatures: [first.curvature, first.curvature + second.curvature],
            own,
            is_free: true,
        }
    }

    /// The plane with this normal by the extents of another one, and the larger squared turn of a body since.
    fn expanded<C: Scalar>(bodies: &[Placed<'_, C, S>; 2], normal: Vector3<S>, own: &[OwnExtent<S>; 2]) -> (Self, S)
    where
        S: AlgebraOver<C>,
    {
        let [a, b] = bodies;
        let (first, turned) = own[0].towards(&a.own(&-normal));
        let (second, other) = own[1].towards(&b.own(&normal));
        let turned = (turned - other).if_negative(other, turned);
        (Self::with(bodies, normal, *own, [&first, &second]), turned)
    }

    /// The best plane by known extents, or a normal near the best one if they are those of other directions.
    fn known<C: Scalar>(
        bodies: &[Placed<'_, C, S>; 2],
        hint: &PlaneHint<S>,
        tolerance: f64,
    ) -> std::result::Result<Self, Vector3<S>>
    where
        S: AlgebraOver<C>,
    {
        let mut normal = hint.normal;
        for _ in 0..KNOWN_STEPS {
            let (mut plane, turned) = Self::expanded(bodies, normal, &hint.own);
            let (step, ascent) = plane.step(S::from_f64(LONGEST));
            normal = unit(&(normal + step));
            if !is_nowhere_negative(S::from_f64(KNOWN) - turned) {
                break;
            }
            if is_nowhere_negative(S::from_f64(tolerance) - dot(&step, &step)) {
                plane.finish(&step, &ascent);
                return Ok(plane);
            }
        }
        Err(normal)
    }

    /// Where a search for a plane nearby begins.
    #[must_use]
    pub fn hint(&self) -> PlaneHint<S> {
        PlaneHint { normal: self.normal, own: self.own }
    }

    /// The best plane between two bodies, or one with a gap that is enough, by Newton's method on the sphere: from that
    /// between the same bodies nearby, or from a direction from the second body to the first one, where they overlap
    /// also with extents that are smoothed with the first of the widths and then with the second one.
    ///
    /// Where there is a gap, no other plane has a maximum of it. Where the bodies overlap, others may have: the plane
    /// does not depend on that nearby, or, if that is to be followed, is near it, so that the gap is smooth along a
    /// search, unless that across the direction is better.
    pub fn between<C: Scalar>(
        bodies: &[Placed<'_, C, S>; 2],
        (off, hint): (impl Fn() -> Vector3<S>, Option<(&PlaneHint<S>, bool)>),
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
        let from = |normal: &Vector3<S>, width: f64, tolerance: f64, known: Option<&[OwnExtent<S>; 2]>| {
            let mut plane = Self::new(bodies, unit(normal), width, known);
            plane.improve(bodies, width, tolerance, enough);
            plane
        };
        let anew = || {
            let off = off();
            let mut plane = from(&off, width, last, None);
            if !is_nowhere_negative(plane.gap) {
                let other = from(&from(&off, first, ROUGH, None).normal, width, last, None);
                let gain = other.gap - plane.gap;
                plane.take(&other, gain);
            }
            plane
        };
        let Some((hint, is_followed)) = hint else {
            return anew();
        };
        let nearby = Self::known(bodies, hint, last);
        let mut plane = nearby.unwrap_or_else(|normal| from(&normal, width, last, Some(&hint.own)));
        if is_nowhere_negative(plane.gap) {
            return plane;
        }
        if !is_followed {
            let overlap = -plane.gap;
            plane.take(&anew(), overlap);
            return plane;
        }
        let mut other = Self::new(bodies, unit(&off()), width, None);
        if !is_nowhere_negative(plane.gap - other.gap) {
            other.improve(bodies, width, last, enough);
            let gain = other.gap - plane.gap;
            plane.take(&other, gain);
        }
        plane
    }

    /// The plane of a half-space $n \cdot p \le \delta$ and the gap between it and a body.
    #[must_use]
    pub fn of_half_space<C: Scalar>(body: &Placed<'_, C, S>, n: &Vector3<S>, offset: S, width: f64) -> Self
    where
        S: AlgebraOver<C>,
    {
        let own = body.extent(&-n, width, None);
        let Extent { value, point, curvature } = body.in_base(&-n, &own.extent);
        let (gap, points, curvatures) = (-value - offset, [point; 2], [curvature; 2]);
        Self { normal: *n, gap, points, curvatures, own: [own; 2], is_free: false }
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
            let (step, ascent) = self.step(longest);
            if is_nowhere_negative(S::from_f64(tolerance) - dot(&step, &step)) {
                if left == 0 {
                    self.finish(&step, &ascent);
                    break;
                }
                left -= 1;
            }
            let next = Self::new(bodies, unit(&(self.normal + step)), width, Some(&self.own));
            // Rounding is no loss.
            let gain = next.gap - self.gap + S::from_f64(1e-14);
            let longer = longest * S::from_f64(2.0);
            let longer = (longer - limit).if_negative(longer, limit);
            longest = gain.if_negative(longest * S::from_f64(0.25), longer);
            self.take(&next, gain);
        }
    }

    /// Newton's step of the normal, at most as long as this, rad, and the difference of the points.
    fn step(&self, longest: S) -> (Vector3<S>, Vector3<S>) {
        let (basis, inverse) = self.inverse();
        let ascent = self.points[0] - self.points[1];
        let [x, y] = [dot(&basis[0], &ascent), dot(&basis[1], &ascent)];
        let step = basis[0] * (inverse[0] * x + inverse[1] * y) + basis[1] * (inverse[1] * x + inverse[2] * y);
        let square = dot(&step, &step);
        let over = longest * longest - square;
        let guarded = over.if_negative(square, S::one());
        let shorter = longest / guarded.sqrt();
        (step * over.if_negative(shorter, S::one()), ascent)
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
        for (own, next) in self.own.iter_mut().zip(&next.own) {
            own.take(next, gain);
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
