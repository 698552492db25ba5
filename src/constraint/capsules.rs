//! Links as capsules, and balls that cover them.

use super::{CollisionSphere, HalfSpace, Sphere};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::spatial::Placement;
use nalgebra::Vector3;
use std::collections::HashSet;

/// A capsule of a body: all points within a radius of a segment, in m. A segment of length zero makes it a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// The body; `None` is the base.
    pub body: Option<usize>,
    /// The ends of the segment in the body.
    pub ends: [Vector3<f64>; 2],
    /// The radius, m.
    pub radius: f64,
}

impl Capsule {
    /// Capsules along the whole arm: from the origin of each joint to those of the joints and of the fixed links on its
    /// body, such as an end effector. A body without such points away from the origin of its joint gets a ball there.
    #[must_use]
    pub fn along_links(model: &Model, radius: f64) -> Vec<Self> {
        let mut capsules = Vec::new();
        for body in 0..model.dof() {
            let body = Some(body);
            let joints = model.joints().iter().filter(|j| j.parent() == body);
            let joints = joints.map(|j| j.origin().translation);
            let frames = model.frames().iter().filter(|f| f.body == body);
            let frames = frames.map(|f| f.placement.translation);
            let (mut ends, mut known) = (Vec::new(), HashSet::new());
            for end in joints.chain(frames) {
                // Zero has two signs.
                let bits: [u64; 3] = end.map(|x| (x + 0.0).to_bits()).into();
                if end != Vector3::zeros() && known.insert(bits) {
                    ends.push(end);
                }
            }
            if ends.is_empty() {
                ends.push(Vector3::zeros());
            }
            capsules.extend(ends.into_iter().map(|end| Self {
                body,
                ends: [Vector3::zeros(), end],
                radius,
            }));
        }
        capsules
    }

    /// Balls that cover the capsule, their centres equally spaced along the segment, ends included, at most `spacing`
    /// apart. With `h` the distance of neighbours their radius is $\sqrt{\rho^2 + (h / 2)^2}$, because a point of the
    /// capsule is at most $h / 2$ along the segment from a centre and $\rho$ off it. A point outside the balls is
    /// therefore outside the capsule.
    ///
    /// # Errors
    /// `spacing` is not positive and finite, or the radius is negative or not finite.
    pub fn balls(&self, spacing: f64) -> Result<Vec<CollisionSphere>> {
        for (what, value, good) in [
            ("spacing", spacing, spacing > 0.0),
            ("radius", self.radius, self.radius >= 0.0),
        ] {
            if !(good && value.is_finite()) {
                let condition = format!("it is {value}, which no capsule can have");
                return Err(Error::input("capsule", what, condition));
            }
        }
        let [from, to] = self.ends;
        let (length, pieces) = (self.length(), self.pieces(spacing));
        let half = if pieces > 0.0 {
            0.5 * length / pieces
        } else {
            0.0
        };
        let ball = |i: u32| CollisionSphere {
            body: self.body,
            centre: from + (to - from) * (f64::from(i) / pieces.max(1.0)),
            radius: self.radius.hypot(half),
        };
        // The cast saturates.
        Ok((0..=pieces as u32).map(ball).collect())
    }

    fn length(&self) -> f64 {
        (self.ends[1] - self.ends[0]).norm()
    }

    /// The number of intervals between balls at this spacing, one less than the number of balls.
    pub fn pieces(&self, spacing: f64) -> f64 {
        (self.length() / spacing).ceil()
    }

    /// Computes the exact distance from the capsule to a sphere, in m; negative in an overlap. `placements` are those
    /// of all bodies.
    ///
    /// # Errors
    /// `placements` has no entry for the body.
    pub fn clearance(&self, placements: &[Placement<f64>], sphere: &Sphere) -> Result<f64> {
        let [from, to] = self.in_base(placements)?;
        let (along, off) = (to - from, sphere.centre - from);
        let squared = along.norm_squared();
        let nearest = if squared > 0.0 {
            (off.dot(&along) / squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        Ok((off - along * nearest).norm() - self.radius - sphere.radius)
    }

    /// Computes the exact depth of the capsule inside a half-space, in m; negative if it protrudes.
    ///
    /// # Errors
    /// `placements` has no entry for the body.
    pub fn height(&self, placements: &[Placement<f64>], half_space: &HalfSpace) -> Result<f64> {
        let heights = self
            .in_base(placements)?
            .map(|end| half_space.normal.dot(&end));
        Ok(heights[0].min(heights[1]) - half_space.offset - self.radius)
    }

    /// The ends of the segment in the base frame.
    fn in_base(&self, placements: &[Placement<f64>]) -> Result<[Vector3<f64>; 2]> {
        let Some(body) = self.body else {
            return Ok(self.ends);
        };
        let placement = placements.get(body).ok_or(Error::Length {
            what: "placements",
            expected: body + 1,
            found: placements.len(),
        })?;
        Ok(self
            .ends
            .map(|p| placement.rotation * p + placement.translation))
    }
}
