//! Balls that cover a shape.
//!
//! A shape is divided into cells about as long as the spacing, and each cell gets a ball about its middle that contains
//! it, so that a point outside the balls is outside the shape.

use super::{Shape, Solid, Sphere};
use crate::error::{Error, Result, plain};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::{PI, TAU};

/// The largest number of balls that cover one shape.
const MOST_BALLS: f64 = 1e5;

/// Balls that cover a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// The balls.
    pub balls: Vec<Sphere>,
    /// The largest distance of a point of a ball from the shape, m. Exact for primitive shapes, a bound for meshes.
    pub excess: f64,
}

impl Solid<f64> {
    /// Covers the solid by balls, in the frame in which it is placed. See [`Shape::cover`].
    ///
    /// # Errors
    /// Those of [`Shape::cover`].
    pub fn cover(&self, spacing: f64) -> Result<Cover> {
        let mut cover = self.shape.cover(spacing)?;
        for ball in &mut cover.balls {
            ball.centre = self.placement.rotation * ball.centre + self.placement.translation;
        }
        Ok(cover)
    }
}

impl Shape<f64> {
    /// Covers the shape and its interior by balls. With `h` for `spacing`, their excess is
    ///
    /// - for a sphere zero: it is its own cover;
    /// - for a box at most $(\sqrt 3 / 2) h$: it is divided into cells with edges of at most `h`;
    /// - for a capsule of radius $\rho$ at most $\sqrt{\rho^2 + h^2 / 4} - \rho$: the centres are at most `h` apart
    ///   along the segment, its ends included;
    /// - for a cylinder at most $(\sqrt 5 / 2) h$: it is divided into slices of thickness at most `h`, these into a
    ///   disc of radius at most `h` and rings of at most that width, and rings into sectors of at most that length. A
    ///   cylinder with a radius of at most `h` is therefore covered by balls on its axis.
    ///
    /// The number of balls is of the order of the volume over $h^3$.
    ///
    /// # Errors
    /// `spacing` or a length of the shape is not positive and finite (a half-space has none), or more than 1e5 balls
    /// are needed.
    pub fn cover(&self, spacing: f64) -> Result<Cover> {
        check(spacing, self.half_lengths().as_slice())?;
        let mut cover = Cover {
            balls: Vec::new(),
            excess: 0.0,
        };
        match *self {
            Self::Sphere { radius } => cover.add(Vector3::zeros(), radius, radius),
            Self::Cuboid { half_extents } => {
                let counts = half_extents.map(|half| pieces(2.0 * half, spacing));
                check_number(counts.product(), spacing)?;
                let cell = half_extents.component_div(&counts);
                for x in middles(half_extents.x, counts.x) {
                    for y in middles(half_extents.y, counts.y) {
                        for z in middles(half_extents.z, counts.z) {
                            let centre = Vector3::new(x, y, z);
                            let depth = (half_extents - centre.abs()).min();
                            cover.add(centre, cell.norm(), depth);
                        }
                    }
                }
            }
            Self::Capsule {
                radius,
                half_length,
            } => {
                let count = pieces(2.0 * half_length, spacing);
                check_number(count + 1.0, spacing)?;
                let half = half_length / count;
                for i in 0..=count as usize {
                    let centre = Vector3::z() * (2.0 * half * i as f64 - half_length);
                    cover.add(centre, radius.hypot(half), radius);
                }
            }
            Self::Cylinder {
                radius,
                half_length,
            } => {
                let slices = pieces(2.0 * half_length, spacing);
                let rings = pieces(radius, spacing);
                // The sectors of a ring of mean radius `r` are about `2 pi r / spacing`; over all rings their number is
                // this.
                check_number(slices * (1.0 + PI * radius / spacing * rings), spacing)?;
                let (half, cells) = (half_length / slices, disc(radius, rings, spacing));
                for z in middles(half_length, slices) {
                    for (centre, flat) in &cells {
                        let depth = (half_length - z.abs()).min(radius - centre.norm());
                        cover.add(centre.push(z), flat.hypot(half), depth);
                    }
                }
            }
            // A half-space is refused above: it has no length.
            _ => {
                let condition = format!("a {} has no cover", self.name());
                return Err(Error::input("cover by balls", "shape", condition));
            }
        }
        Ok(cover)
    }
}

impl Cover {
    /// Adds a ball about a point at depth `depth` in the shape. If a convex shape contains a ball of that radius about
    /// the centre, every point of a larger concentric ball is at most the difference of the radii away from the shape.
    fn add(&mut self, centre: Vector3<f64>, radius: f64, depth: f64) {
        self.balls.push(Sphere { centre, radius });
        self.excess = self.excess.max(radius - depth);
    }
}

/// Discs that cover a disc about the origin: one in the middle, and one per sector of `rings - 1` rings.
fn disc(radius: f64, rings: f64, spacing: f64) -> Vec<(Vector2<f64>, f64)> {
    let width = radius / rings;
    let mut cells = vec![(Vector2::zeros(), width)];
    for ring in 1..rings as usize {
        let inner = width * ring as f64;
        let (outer, middle) = (inner + width, inner + 0.5 * width);
        let sectors = pieces(TAU * outer, spacing).max(3.0);
        let (sin, cos) = (PI / sectors).sin_cos();
        // The farthest points of a sector from its middle are its corners.
        let corner = |r: f64| (r * cos - middle).hypot(r * sin);
        let reach = corner(inner).max(corner(outer));
        for sector in 0..sectors as usize {
            let (sin, cos) = (TAU * sector as f64 / sectors).sin_cos();
            cells.push((Vector2::new(cos, sin) * middle, reach));
        }
    }
    cells
}

/// The smallest number of equal pieces of a length that are no longer than `spacing`.
fn pieces(length: f64, spacing: f64) -> f64 {
    (length / spacing).ceil().max(1.0)
}

/// The middles of `count` equal pieces of $[-h, h]$.
fn middles(half: f64, count: f64) -> impl Iterator<Item = f64> {
    (0..count as usize).map(move |i| half * ((2 * i + 1) as f64 / count - 1.0))
}

/// Refuses a spacing or lengths that are not positive and finite.
pub(super) fn check(spacing: f64, lengths: &[f64]) -> Result<()> {
    let named = lengths.iter().map(|x| ("length", x));
    for (what, x) in [("spacing", &spacing)].into_iter().chain(named) {
        if !(x.is_finite() && *x > 0.0) {
            let condition = format!("it is {}, a positive number is needed", plain(*x));
            return Err(Error::input("cover by balls", what, condition));
        }
    }
    Ok(())
}

/// Refuses an implausible number of balls.
pub(super) fn check_number(balls: f64, spacing: f64) -> Result<()> {
    if balls <= MOST_BALLS {
        return Ok(());
    }
    let [spacing, balls, most] = [spacing, balls, MOST_BALLS].map(plain);
    let condition = format!(
        "it is {spacing}, which takes {balls} balls for one shape, at most {most} are allowed"
    );
    Err(Error::input("cover by balls", "spacing", condition))
}
