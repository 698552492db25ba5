//! Convex shapes, their placements, and the signed distances of points from them.

use super::corner::{Bent, beyond, corner, excess, length};
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Placement, apply_constant, apply_constant_transpose, matrix, rotation_of_z_to};
use nalgebra::{Matrix3, Vector3};

/// A shape about the origin of its own frame, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<C: Scalar = f64> {
    /// A ball.
    Sphere {
        /// Radius.
        radius: C,
    },
    /// A box with edges along the axes.
    Cuboid {
        /// Half of its edge lengths.
        half_extents: Vector3<C>,
    },
    /// A cylinder along the `z` axis.
    Cylinder {
        /// Radius.
        radius: C,
        /// Half of its length.
        half_length: C,
    },
    /// All points within a radius of a segment of the `z` axis.
    Capsule {
        /// Radius.
        radius: C,
        /// Half of the length of the segment, without the caps.
        half_length: C,
    },
    /// All points with $z \le 0$, such as the ground below a floor.
    HalfSpace,
}

/// A ball, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere<C: Scalar = f64> {
    /// Its centre.
    pub centre: Vector3<C>,
    /// Its radius.
    pub radius: C,
}

impl Sphere {
    /// The distance from another ball, in m; negative where they overlap.
    #[must_use]
    pub fn gap(&self, other: &Self) -> f64 {
        (self.centre - other.centre).norm() - self.radius - other.radius
    }
}

/// A shape with a placement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid<C: Scalar = f64> {
    /// The placement of the frame of the shape.
    pub placement: Placement<C>,
    /// The shape.
    pub shape: Shape<C>,
}

impl Shape<f64> {
    /// Converts the lengths to another type.
    #[must_use]
    pub fn cast<C: Scalar>(&self) -> Shape<C> {
        let of = C::from_f64;
        match *self {
            Self::Sphere { radius } => Shape::Sphere { radius: of(radius) },
            Self::Cuboid { half_extents } => Shape::Cuboid { half_extents: half_extents.map(of) },
            Self::Cylinder { radius, half_length } => {
                Shape::Cylinder { radius: of(radius), half_length: of(half_length) }
            }
            Self::Capsule { radius, half_length } => {
                Shape::Capsule { radius: of(radius), half_length: of(half_length) }
            }
            Self::HalfSpace => Shape::HalfSpace,
        }
    }
}

impl Solid {
    /// The half-space $n \cdot p \le \delta$ in m, such as the ground; the normal `n` is a vector of any length but
    /// zero into the free space, and $\delta$ the offset along the unit normal.
    #[must_use]
    pub fn half_space(normal: &Vector3<f64>, offset: f64) -> Self {
        let rotation = rotation_of_z_to(normal);
        Self { placement: Placement::new(rotation, rotation.column(2) * offset), shape: Shape::HalfSpace }
    }

    /// The point of a segment that is nearest to the solid, in closed form: for spheres and half-spaces; `None` for
    /// other shapes.
    #[must_use]
    pub fn nearest_on_segment(&self, [from, to]: &[Vector3<f64>; 2]) -> Option<Vector3<f64>> {
        let along = to - from;
        let fraction = match self.shape {
            Shape::Sphere { .. } => {
                let off = self.placement.translation - from;
                (off.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
            }
            Shape::HalfSpace if self.distance(to) < self.distance(from) => 1.0,
            Shape::HalfSpace => 0.0,
            _ => return None,
        };
        Some(from + along * fraction)
    }
}

/// The signed distance of a point from a surface, with its derivatives in the point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance<S: Scalar> {
    /// The distance in m, negative inside.
    pub value: S,
    /// The gradient: the unit normal of the surface, away from the shape.
    pub normal: Vector3<S>,
    /// The Hessian in 1/m: the curvature of the surface at that distance.
    pub curvature: Matrix3<S>,
}

impl<C: Scalar> Shape<C> {
    /// The name of the shape.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Cuboid { .. } => "box",
            Self::Cylinder { .. } => "cylinder",
            Self::Capsule { .. } => "capsule",
            Self::HalfSpace => "half-space",
        }
    }

    /// Half of the lengths of the shape along its axes, in m: that of a capsule along `z` without the caps; zero for a
    /// half-space, which has no end.
    #[must_use]
    pub fn half_lengths(&self) -> Vector3<C> {
        match *self {
            Self::Sphere { radius } => Vector3::repeat(radius),
            Self::Cuboid { half_extents } => half_extents,
            Self::Cylinder { radius, half_length } | Self::Capsule { radius, half_length } => {
                Vector3::new(radius, radius, half_length)
            }
            Self::HalfSpace => Vector3::zeros(),
        }
    }

    /// Computes the signed distance of the point `p`, in the frame of the shape, from its surface, in m, negative
    /// inside.
    #[inline]
    #[must_use]
    pub fn distance<S: AlgebraOver<C>>(&self, p: &Vector3<S>) -> S {
        match self {
            Self::Sphere { radius } => length([p.x, p.y, p.z]) - S::lift(*radius),
            Self::Cuboid { half_extents: h } => corner([beyond(p.x, h.x), beyond(p.y, h.y), beyond(p.z, h.z)]),
            Self::Cylinder { radius, half_length } => {
                let off = length([p.x, p.y]) - S::lift(*radius);
                corner([off, beyond(p.z, *half_length)])
            }
            Self::Capsule { radius, half_length } => {
                let along = excess(beyond(p.z, *half_length));
                length([p.x, p.y, along]) - S::lift(*radius)
            }
            Self::HalfSpace => p.z,
        }
    }

    /// Computes [`distance`](Self::distance) with its gradient and its Hessian in `p`.
    #[inline]
    #[must_use]
    pub fn distance_derivatives<S: AlgebraOver<C>>(&self, p: &Vector3<S>) -> Distance<S> {
        let (one, zero) = (S::one(), S::zero());
        let sign = p.map(|x| x.if_negative(-one, one));
        match self {
            Self::Sphere { radius } => {
                Bent::length([p.x, p.y, p.z], [one; 3]).distance(S::lift(*radius), &sign.map(|_| one))
            }
            Self::Cuboid { half_extents: h } => {
                Bent::corner([beyond(p.x, h.x), beyond(p.y, h.y), beyond(p.z, h.z)]).distance(zero, &sign)
            }
            Self::Cylinder { radius, half_length } => {
                let off = Bent::length([p.x, p.y], [one; 2]);
                let q = [off.value - S::lift(*radius), beyond(p.z, *half_length)];
                let outer = Bent::corner(q);
                let n = [off.gradient[0], off.gradient[1], sign.z];
                let part = |i: usize| usize::from(i == 2);
                Distance {
                    value: outer.value,
                    normal: Vector3::from_fn(|i, _| outer.gradient[part(i)] * n[i]),
                    curvature: matrix(|i, j| {
                        let bent = outer.hessian[part(i)][part(j)] * n[i] * n[j];
                        if i < 2 && j < 2 { bent + outer.gradient[0] * off.hessian[i][j] } else { bent }
                    }),
                }
            }
            Self::Capsule { radius, half_length } => {
                let along = beyond(p.z, *half_length);
                let moves = [one, one, along.if_negative(zero, one)];
                let sign = Vector3::new(one, one, sign.z);
                Bent::length([p.x, p.y, excess(along)], moves).distance(S::lift(*radius), &sign)
            }
            Self::HalfSpace => {
                Distance { value: p.z, normal: Vector3::new(zero, zero, one), curvature: Matrix3::from_element(zero) }
            }
        }
    }
}

impl<C: Scalar> Solid<C> {
    /// Computes the signed distance of the point `p` from the surface, in m, negative inside.
    #[inline]
    #[must_use]
    pub fn distance<S: AlgebraOver<C>>(&self, p: &Vector3<S>) -> S {
        self.shape.distance(&self.in_shape(p))
    }

    /// Computes [`distance`](Self::distance) with its gradient and its Hessian in `p`.
    #[inline]
    #[must_use]
    pub fn distance_derivatives<S: AlgebraOver<C>>(&self, p: &Vector3<S>) -> Distance<S> {
        let local = self.shape.distance_derivatives(&self.in_shape(p));
        let rotation = &self.placement.rotation;
        // R H R^T, where H is symmetric: R times the rows of R H.
        let turned = |m: &Matrix3<S>| {
            let column = |j| apply_constant(rotation, &m.column(j).into_owned());
            let columns = [column(0), column(1), column(2)];
            matrix(|i, j| columns[i][j])
        };
        Distance {
            value: local.value,
            normal: apply_constant(rotation, &local.normal),
            curvature: turned(&turned(&local.curvature)),
        }
    }

    /// The point `p` in the frame of the shape.
    #[inline]
    fn in_shape<S: AlgebraOver<C>>(&self, p: &Vector3<S>) -> Vector3<S> {
        let from = p - self.placement.translation.map(S::lift);
        apply_constant_transpose(&self.placement.rotation, &from)
    }
}
