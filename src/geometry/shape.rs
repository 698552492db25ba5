//! Convex shapes and their placements.

use crate::scalar::Scalar;
use crate::spatial::Placement;
use nalgebra::Vector3;

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
}

/// A shape with a placement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid<C: Scalar = f64> {
    /// The placement of the frame of the shape.
    pub placement: Placement<C>,
    /// The shape.
    pub shape: Shape<C>,
}
