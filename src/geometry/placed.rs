//! Convex bodies in their places.

use super::Convex;
use super::convex::{Extent, is_nowhere_negative};
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Placement, apply, apply_transpose, dot, multiply};
use nalgebra::Vector3;

/// The squared turn of a body up to which a furthest point is nearly one in the other direction.
const NEAR: f64 = 2.5e-3;

/// A body in the base frame.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a, C: Scalar, S: Scalar> {
    /// The body.
    pub convex: &'a Convex<C>,
    /// The placement of its frame; `None` is the base frame.
    pub placement: Option<&'a Placement<S>>,
}

/// The smoothed extent of a body in a direction, in its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OwnExtent<S: Scalar> {
    pub direction: Vector3<S>,
    pub extent: Extent<S>,
}

impl<'a, C: Scalar, S: AlgebraOver<C>> Placed<'a, C, S> {
    /// A direction in the frame of the body.
    pub(super) fn own(&self, direction: &Vector3<S>) -> Vector3<S> {
        self.placement.map_or(*direction, |placement| apply_transpose(&placement.rotation, direction))
    }

    /// The smoothed extent in a direction of length one.
    pub(super) fn extent(&self, direction: &Vector3<S>, width: f64, known: Option<&OwnExtent<S>>) -> OwnExtent<S> {
        let direction = self.own(direction);
        let is_near = |known: &&OwnExtent<S>| {
            let off = direction - known.direction;
            is_nowhere_negative(S::from_f64(NEAR) - dot(&off, &off))
        };
        let point = known.filter(is_near).map(|known| &known.extent.point);
        OwnExtent { direction, extent: self.convex.smoothed(&direction, width, point) }
    }

    /// An extent in the frame of the body, in the base frame.
    pub(super) fn in_base(&self, direction: &Vector3<S>, own: &Extent<S>) -> Extent<S> {
        let Some(Placement { rotation, translation }) = self.placement else {
            return *own;
        };
        Extent {
            value: own.value + dot(direction, translation),
            point: apply(rotation, &own.point) + translation,
            curvature: multiply(&multiply(rotation, &own.curvature), &rotation.transpose()),
        }
    }
}

impl<S: Scalar> OwnExtent<S> {
    /// The extent in a direction nearby to second order, and the squared difference of the directions.
    pub(super) fn towards(&self, direction: &Vector3<S>) -> (Extent<S>, S) {
        let OwnExtent { extent: Extent { value, point, curvature }, .. } = self;
        let off = direction - self.direction;
        let moved = apply(curvature, &off);
        let value = *value + dot(point, &off) + dot(&off, &moved) * S::from_f64(0.5);
        (Extent { value, point: point + moved, curvature: *curvature }, dot(&off, &off))
    }

    /// Takes another one where a number is not negative.
    pub(super) fn take(&mut self, next: &Self, gain: S) {
        let choose = |own: S, other: S| gain.if_negative(own, other);
        self.direction = self.direction.zip_map(&next.direction, choose);
        let (own, next) = (&mut self.extent, &next.extent);
        own.value = choose(own.value, next.value);
        own.point = own.point.zip_map(&next.point, choose);
        own.curvature = own.curvature.zip_map(&next.curvature, choose);
    }
}
