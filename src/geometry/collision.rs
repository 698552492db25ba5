//! The collision geometry of a robot: balls that the constraints act on, and the capsules that some of them cover.

use super::{Solid, Sphere};
use crate::error::{Error, Result};
use crate::scalar::Scalar;
use crate::spatial::Placement;
use nalgebra::Vector3;
use std::collections::HashSet;

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

/// Balls in the base frame, with the bodies at `placements`.
///
/// # Errors
/// `placements` has no entry for a body.
pub fn placed_balls(
    balls: &[CollisionSphere],
    placements: &[Placement<f64>],
) -> Result<Vec<Sphere>> {
    let placed = |ball: &CollisionSphere| {
        Ok(Sphere {
            centre: in_base(ball.body, &ball.centre, placements)?,
            radius: ball.radius,
        })
    };
    balls.iter().map(placed).collect()
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
    /// The indices of the balls of each [set](Self::with_sets), none of which is empty; none without sets.
    pub sets: Vec<Vec<usize>>,
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
            capsules,
            ..Self::default()
        })
    }

    /// The balls in the base frame, as [`placed_balls`] computes them.
    ///
    /// # Errors
    /// `placements` has no entry for a body.
    pub fn placed(&self, placements: &[Placement<f64>]) -> Result<Vec<Sphere>> {
        placed_balls(&self.balls, placements)
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

    /// Divides the balls of each link into sets, about as many as each has balls, those of a set far from each other: a
    /// constraint then needs one row per pair of sets. The next ball, from the largest on, goes to the set whose
    /// nearest ball is furthest. Cost O(the square of the number of balls of a link).
    #[must_use]
    pub fn with_sets(mut self) -> Self {
        let ids = self.link_ids();
        let mut of_links: Vec<Vec<usize>> = Vec::new();
        for (i, id) in ids.into_iter().enumerate() {
            of_links.resize(of_links.len().max(id + 1), Vec::new());
            of_links[id].push(i);
        }
        let sphere = |i: usize| Sphere {
            centre: self.balls[i].centre,
            radius: self.balls[i].radius,
        };
        let mut all = Vec::new();
        for mut own in of_links {
            own.sort_by(|i, j| self.balls[*j].radius.total_cmp(&self.balls[*i].radius));
            let mut sets = vec![Vec::new(); (own.len() as f64).sqrt().ceil() as usize];
            for i in own {
                let nearest = |set: &Vec<usize>| {
                    let gaps = set.iter().map(|j| sphere(i).gap(&sphere(*j)));
                    gaps.fold(f64::INFINITY, f64::min)
                };
                // The first of equals.
                let best = sets.iter().rev().enumerate();
                let best = best.max_by(|(_, a), (_, b)| nearest(a).total_cmp(&nearest(b)));
                let last = sets.len() - 1;
                if let Some(best) = best.map(|(back, _)| last - back) {
                    sets[best].push(i);
                }
            }
            all.extend(sets);
        }
        self.sets = all;
        self
    }

    /// A number for the link of each ball, the same for the same link.
    fn link_ids(&self) -> Vec<usize> {
        let mut known: Vec<&String> = Vec::new();
        let mut id = |link| match known.iter().rposition(|k| *k == link) {
            Some(id) => id,
            None => {
                known.push(link);
                known.len() - 1
            }
        };
        self.links.iter().map(&mut id).collect()
    }

    /// The pairs of balls on different bodies and links, without those of `ignored` pairs of links, sorted by pairs of
    /// bodies; none if the balls belong to no links. Cost O(number of balls squared).
    #[must_use]
    pub fn pairs(&self, ignored: &[[String; 2]]) -> Vec<[usize; 2]> {
        let all: Vec<usize> = (0..self.links.len()).collect();
        self.pairs_among(&all, ignored)
    }

    /// The pairs of sets, as [`pairs`](Self::pairs) lists those of balls.
    #[must_use]
    pub fn set_pairs(&self, ignored: &[[String; 2]]) -> Vec<[usize; 2]> {
        let first: Vec<usize> = self.sets.iter().map(|set| set[0]).collect();
        self.pairs_among(&first, ignored)
    }

    /// The pairs of the given balls, as indices in the list of these.
    fn pairs_among(&self, of: &[usize], ignored: &[[String; 2]]) -> Vec<[usize; 2]> {
        let ids = self.link_ids();
        let id = |link: &String| self.links.iter().position(|l| l == link).map(|i| ids[i]);
        let named = ignored.iter().flat_map(|[c, d]| [[c, d], [d, c]]);
        let ignored: HashSet<_> = named.map(|pair| pair.map(id)).collect();
        let body = |i: usize| self.balls[of[i]].body;
        let all = (0..of.len()).flat_map(|i| (i + 1..of.len()).map(move |j| [i, j]));
        let mut pairs: Vec<_> = all
            .filter(|[i, j]| {
                let [a, b] = [i, j].map(|i| ids[of[*i]]);
                body(*i) != body(*j) && a != b && !ignored.contains(&[Some(a), Some(b)])
            })
            .collect();
        pairs.sort_by_key(|pair| pair.map(body));
        pairs
    }
}
