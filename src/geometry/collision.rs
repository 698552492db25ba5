//! The collision geometry of a robot: balls that the constraints act on, and the capsules that some of them cover.

use super::{Solid, Sphere};
use crate::error::{Error, Result};
use crate::scalar::Scalar;
use crate::spatial::Placement;
use nalgebra::Vector3;

/// A ball on a body, in m; with radius zero it is a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionSphere<C: Scalar = f64> {
    /// The body; `None` is the base.
    pub body: Option<usize>,
    /// Its centre in the body.
    pub centre: Vector3<C>,
    /// Its radius.
    pub radius: C,
}

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

    /// The ball of the capsule that is nearest to a solid, in the base frame; `None` for a shape without a closed form
    /// ([`Solid::nearest_on_segment`](super::Solid::nearest_on_segment)). `placements` are those of all bodies.
    ///
    /// # Errors
    /// `placements` has no entry for the body.
    pub fn nearest_ball(
        &self,
        placements: &[Placement<f64>],
        solid: &Solid,
    ) -> Result<Option<Sphere>> {
        let [from, to] = self.ends;
        let ends = [
            in_base(self.body, &from, placements)?,
            in_base(self.body, &to, placements)?,
        ];
        let ball = |centre| Sphere {
            centre,
            radius: self.radius,
        };
        Ok(solid.nearest_on_segment(&ends).map(ball))
    }
}

/// The position of a point of a body in the base frame.
fn in_base(
    body: Option<usize>,
    point: &Vector3<f64>,
    placements: &[Placement<f64>],
) -> Result<Vector3<f64>> {
    let Some(body) = body else {
        return Ok(*point);
    };
    let placement = placements.get(body).ok_or(Error::Length {
        what: "placements",
        expected: body + 1,
        found: placements.len(),
    })?;
    Ok(placement.rotation * point + placement.translation)
}

/// The collision geometry of a robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollisionGeometry {
    /// The balls.
    pub balls: Vec<CollisionSphere>,
    /// The name of the link of each ball; empty if the balls belong to no links.
    pub links: Vec<String>,
    /// The capsules that the balls cover; empty if the robot consists of the balls.
    pub capsules: Vec<Capsule>,
}

impl CollisionGeometry {
    /// Covers capsules by balls at most `spacing` apart, m; balls shared by several capsules appear once.
    ///
    /// # Errors
    /// Those of [`Capsule::balls`].
    pub fn of_capsules(capsules: Vec<Capsule>, spacing: f64) -> Result<Self> {
        let mut balls: Vec<CollisionSphere> = Vec::new();
        for capsule in &capsules {
            // Capsules of one body share the ball at its joint.
            for ball in capsule.balls(spacing)? {
                let same =
                    |b: &&mut CollisionSphere| b.body == ball.body && b.centre == ball.centre;
                match balls.iter_mut().find(same) {
                    Some(known) => known.radius = known.radius.max(ball.radius),
                    None => balls.push(ball),
                }
            }
        }
        Ok(Self {
            balls,
            links: Vec::new(),
            capsules,
        })
    }

    /// The balls in the base frame, with the bodies at `placements`.
    ///
    /// # Errors
    /// `placements` has no entry for a body.
    pub fn placed(&self, placements: &[Placement<f64>]) -> Result<Vec<Sphere>> {
        let placed = |ball: &CollisionSphere| {
            Ok(Sphere {
                centre: in_base(ball.body, &ball.centre, placements)?,
                radius: ball.radius,
            })
        };
        self.balls.iter().map(placed).collect()
    }

    /// The [nearest ball](Capsule::nearest_ball) of each capsule; `None` without capsules, and for a shape without a
    /// closed form.
    pub(super) fn nearest_balls(
        &self,
        placements: &[Placement<f64>],
        solid: &Solid,
    ) -> Result<Option<Vec<Sphere>>> {
        if self.capsules.is_empty() {
            return Ok(None);
        }
        let nearest = self.capsules.iter();
        let nearest = nearest.map(|c| c.nearest_ball(placements, solid).transpose());
        nearest.collect::<Option<Result<_>>>().transpose()
    }

    /// The pairs of balls on different bodies and links, without those of `ignored` pairs of links, sorted by pairs of
    /// bodies; none if the balls belong to no links. Cost O(number of balls squared).
    #[must_use]
    pub fn pairs(&self, ignored: &[[String; 2]]) -> Vec<[usize; 2]> {
        let links = &self.links;
        let ignore = |a: &String, b: &String| {
            let same = |[c, d]: &[String; 2]| (c == a && d == b) || (c == b && d == a);
            a == b || ignored.iter().any(same)
        };
        let body = |i: usize| self.balls[i].body;
        let of_links = (0..links.len()).flat_map(|i| (i + 1..links.len()).map(move |j| [i, j]));
        let mut pairs: Vec<_> = of_links
            .filter(|[i, j]| body(*i) != body(*j) && !ignore(&links[*i], &links[*j]))
            .collect();
        pairs.sort_by_key(|pair| pair.map(body));
        pairs
    }
}
