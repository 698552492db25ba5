//! Balls that cover a shape.

use super::mesh::{Triangle, cover_triangles};
use super::{Shape, Solid, Sphere};
use crate::error::{Error, Result, plain};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// The largest number of balls that cover a capsule.
const MAX_BALLS: f64 = 1e5;

/// The share of the excess by which the prism sticks out that stands for a cylinder.
const PRISM: f64 = 0.1;

/// Balls that cover a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// The balls.
    pub balls: Vec<Sphere>,
    /// A bound on the distance of the points of the balls from the shape, m.
    pub excess: f64,
}

impl Solid<f64> {
    /// Covers the solid by balls, in the frame in which it is placed. See [`Shape::cover`].
    ///
    /// # Errors
    /// Those of [`Shape::cover`].
    pub fn cover(&self, excess: f64) -> Result<Cover> {
        let mut cover = self.shape.cover(excess)?;
        for ball in &mut cover.balls {
            ball.centre = self.placement.rotation * ball.centre + self.placement.translation;
        }
        Ok(cover)
    }
}

impl Shape<f64> {
    /// Covers the shape and its interior by balls, no point of which is further than `excess` in m from it.
    ///
    /// A sphere is its own cover. A capsule of radius $\rho$ gets balls on its segment, ends included, of radius
    /// $\sqrt{\rho^2 + h^2 / 4} \le \rho + \epsilon$ with `h` the distance of neighbours and $\epsilon$ the excess. A
    /// box is covered as the [triangles](cover_triangles) of its faces, and a cylinder as those of a prism about it
    /// that sticks out by a tenth of the excess.
    ///
    /// # Errors
    /// `excess` or a length of the shape is not positive and finite (a half-space has none), more than 1e5 balls are
    /// needed for a capsule, or those of [`cover_triangles`].
    pub fn cover(&self, excess: f64) -> Result<Cover> {
        let lengths = self.half_lengths();
        let lengths = lengths.iter().map(|x| ("length", *x));
        check(&[("excess", excess)])?;
        check(&lengths.collect::<Vec<_>>())?;
        match *self {
            Self::Sphere { radius } => {
                Ok(Cover { balls: vec![Sphere { centre: Vector3::zeros(), radius }], excess: 0.0 })
            }
            Self::Cuboid { half_extents: h } => {
                let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
                cover_triangles(&prism(&corners.map(|(x, y)| [x * h.x, y * h.y]), h.z), excess)
            }
            Self::Capsule { radius, half_length } => {
                let spacing = 2.0 * (excess * (2.0 * radius + excess)).sqrt();
                let pieces = (2.0 * half_length / spacing).ceil();
                if pieces + 1.0 > MAX_BALLS {
                    let [number, most] = [pieces + 1.0, MAX_BALLS].map(plain);
                    let condition = format!("it takes {number} balls for a capsule, at most {most} are allowed");
                    return refused("excess", condition);
                }
                let half = half_length / pieces;
                let radius_of_balls = radius.hypot(half);
                let ball = |i: u32| Sphere {
                    centre: Vector3::z() * (2.0 * half * f64::from(i) - half_length),
                    radius: radius_of_balls,
                };
                Ok(Cover { balls: (0..=pieces as u32).map(ball).collect(), excess: radius_of_balls - radius })
            }
            Self::Cylinder { radius, half_length } => {
                // The sides touch the cylinder, and the edges are at this distance from its axis.
                let most = radius + PRISM * excess;
                let sides = (PI / (radius / most).acos()).ceil().max(3.0);
                let edge = radius / (PI / sides).cos();
                let corner = |i: u32| {
                    let (sin, cos) = (TAU * f64::from(i) / sides).sin_cos();
                    [edge * cos, edge * sin]
                };
                let corners: Vec<_> = (0..sides as u32).map(corner).collect();
                let cover = cover_triangles(&prism(&corners, half_length), (1.0 - PRISM) * excess)?;
                Ok(Cover { excess, ..cover })
            }
            // It is refused above: it has no length.
            Self::HalfSpace => refused("shape", format!("a {} has no cover", self.name())),
        }
    }
}

/// The triangles of the surface of a prism along `z` about the origin, over a convex polygon.
fn prism(corners: &[[f64; 2]], half_length: f64) -> Vec<Triangle> {
    let at = |i: usize, side: f64| {
        let [x, y] = corners[i % corners.len()];
        Vector3::new(x, y, side * half_length)
    };
    let sides = (0..corners.len()).flat_map(|i| {
        let [a, b] = [i, i + 1].map(|i| [-1.0, 1.0].map(|side| at(i, side)));
        [[a[0], b[0], b[1]], [a[0], b[1], a[1]]]
    });
    let ends = (1..corners.len() - 1).flat_map(|i| {
        let end = |side| [0, i, i + 1].map(|i| at(i, side));
        [end(-1.0), end(1.0)]
    });
    sides.chain(ends).collect()
}

/// Refuses numbers that are not positive and finite.
pub(super) fn check(named: &[(&str, f64)]) -> Result<()> {
    for (what, x) in named {
        if !(x.is_finite() && *x > 0.0) {
            let condition = format!("it is {} and must be a positive number", plain(*x));
            return refused(what, condition);
        }
    }
    Ok(())
}

pub(super) fn refused<T>(element: &str, condition: String) -> Result<T> {
    Err(Error::input("cover by balls", element, condition))
}
