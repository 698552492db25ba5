//! The collision geometry of a robot: balls that the constraints act on, and the capsules that they cover, or convex
//! bodies within them.

use super::{BallTree, Convex, ConvexPiece, Solid, Sphere};
#[cfg(feature = "solvers")]
use super::{Placed, separation::overlap};
use crate::error::{Error, Result};
use crate::scalar::Scalar;
use crate::spatial::Placement;
use nalgebra::Vector3;
use std::collections::{HashMap, HashSet};

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
        for (what, value, good) in [("spacing", spacing, spacing > 0.0), ("radius", self.radius, self.radius >= 0.0)] {
            if !(good && value.is_finite()) {
                let condition = format!("it is {value}, which no capsule can have");
                return Err(Error::input("capsule", what, condition));
            }
        }
        let [from, to] = self.ends;
        let (length, pieces) = (self.length(), self.pieces(spacing));
        let half = if pieces > 0.0 { 0.5 * length / pieces } else { 0.0 };
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
    pub fn nearest_ball(&self, placements: &[Placement<f64>], solid: &Solid) -> Result<Option<Sphere>> {
        let [from, to] = self.ends;
        let ends = [in_base(self.body, &from, placements)?, in_base(self.body, &to, placements)?];
        let ball = |centre| Sphere { centre, radius: self.radius };
        Ok(solid.nearest_on_segment(&ends).map(ball))
    }
}

/// The placement of a body in the base frame.
pub(super) fn placement_of(body: Option<usize>, placements: &[Placement<f64>]) -> Result<Placement<f64>> {
    let Some(body) = body else {
        return Ok(Placement::identity());
    };
    placements.get(body).copied().ok_or(Error::Length {
        what: "placements",
        expected: body + 1,
        found: placements.len(),
    })
}

/// The position of a point of a body in the base frame.
fn in_base(body: Option<usize>, point: &Vector3<f64>, placements: &[Placement<f64>]) -> Result<Vector3<f64>> {
    let placement = placement_of(body, placements)?;
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
    /// The convex pieces of each mesh that the balls cover, in the order of the shapes and in their frames.
    pub pieces: Vec<Vec<ConvexPiece>>,
    /// The convex body that each ball contains, in the frame of its body; empty if the balls are the robot.
    pub parts: Vec<Convex>,
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
                let same = |b: &&mut CollisionSphere| b.body == ball.body && b.centre == ball.centre;
                match balls.iter_mut().find(same) {
                    Some(known) => known.radius = known.radius.max(ball.radius),
                    None => balls.push(ball),
                }
            }
        }
        Ok(Self { balls, capsules, ..Self::default() })
    }

    /// The balls in the base frame, with the bodies at `placements`.
    ///
    /// # Errors
    /// `placements` has no entry for a body.
    pub fn placed(&self, placements: &[Placement<f64>]) -> Result<Vec<Sphere>> {
        let placed = |ball: &CollisionSphere| {
            Ok(Sphere { centre: in_base(ball.body, &ball.centre, placements)?, radius: ball.radius })
        };
        self.balls.iter().map(placed).collect()
    }

    /// The [nearest ball](Capsule::nearest_ball) of each capsule; `None` without capsules, and for a shape without a
    /// closed form.
    #[cfg(feature = "solvers")]
    pub(super) fn nearest_balls(&self, placements: &[Placement<f64>], solid: &Solid) -> Result<Option<Vec<Sphere>>> {
        if self.capsules.is_empty() {
            return Ok(None);
        }
        let nearest = self.capsules.iter();
        let nearest = nearest.map(|c| c.nearest_ball(placements, solid).transpose());
        nearest.collect::<Option<Result<_>>>().transpose()
    }

    /// Adds a convex body in the frame of a body of the robot, with the name of its link and a ball about it.
    pub fn add(&mut self, link: &str, body: Option<usize>, part: Convex) {
        let Sphere { centre, radius } = part.ball();
        self.balls.push(CollisionSphere { body, centre, radius });
        self.links.push(link.to_owned());
        self.parts.push(part);
    }

    /// The balls of each link as a tree; of each body if the balls belong to no links.
    #[must_use]
    pub fn trees(&self) -> Vec<BallTree> {
        let all = self.by_links().into_iter();
        all.map(|own| BallTree::new(&self.balls, own)).collect()
    }

    /// The least gap of two links, m, by their trees, with the bodies at `placements`, if it is less than `most`;
    /// infinite otherwise.
    ///
    /// # Errors
    /// `placements` has no entry for a body.
    #[cfg(feature = "solvers")]
    pub fn gap_within(&self, trees: [&BallTree; 2], placements: &[Placement<f64>], most: f64) -> Result<f64> {
        self.least_gap(trees, placements, most, |bodies| super::gap(bodies).distance)
    }

    /// The least gap of two links if it is less than `most`, with that of two convex bodies by `gap_of`.
    #[cfg(feature = "solvers")]
    fn least_gap(
        &self,
        trees: [&BallTree; 2],
        placements: &[Placement<f64>],
        most: f64,
        gap_of: impl Fn(&[Placed<'_, f64, f64>; 2]) -> f64,
    ) -> Result<f64> {
        let [tree, other] = trees;
        let places = [placement_of(tree.body, placements)?, placement_of(other.body, placements)?];
        let ball = |side: usize, node: usize| {
            let Sphere { centre, radius } = trees[side].nodes[node].bound;
            Sphere { centre: places[side].point(&centre), radius }
        };
        let part = |side: usize, node: usize| {
            let convex = self.parts.get(trees[side].nodes[node].leaf?)?;
            Some(Placed { convex, placement: Some(&places[side]) })
        };
        let gap = |[i, j]: [usize; 2]| ball(0, i).gap(&ball(1, j));
        let (mut least, mut found) = (most, f64::INFINITY);
        tree.search_pairs(other, gap, f64::lt, |[i, j], gap| {
            let is_near = *gap < least;
            if is_near && tree.below_pair(other, [i, j]).is_none() {
                let exact = match [part(0, i), part(1, j)] {
                    [Some(a), Some(b)] => gap_of(&[a, b]),
                    _ => *gap,
                };
                if exact < least {
                    (least, found) = (exact, exact);
                }
            }
            is_near
        });
        Ok(found)
    }

    /// Returns true if two links overlap or touch, by their trees, with the bodies at `placements`.
    ///
    /// # Errors
    /// `placements` has no entry for a body.
    #[cfg(feature = "solvers")]
    pub fn overlap(&self, trees: [&BallTree; 2], placements: &[Placement<f64>]) -> Result<bool> {
        let gap_of =
            |bodies: &[Placed<'_, f64, f64>; 2]| if overlap(bodies) { f64::NEG_INFINITY } else { f64::INFINITY };
        Ok(self.least_gap(trees, placements, f64::MIN_POSITIVE, gap_of)? <= 0.0)
    }

    /// The link of a tree; `None` if the balls belong to no links.
    #[must_use]
    pub fn link_of(&self, tree: &BallTree) -> Option<&str> {
        let ball = tree.nodes.iter().find_map(|node| node.leaf)?;
        self.links.get(ball).map(String::as_str)
    }

    /// The indices of the balls of each link and body, in the order of the first ones.
    fn by_links(&self) -> Vec<Vec<usize>> {
        let mut known = HashMap::new();
        let mut all: Vec<Vec<usize>> = Vec::new();
        for (i, ball) in self.balls.iter().enumerate() {
            let count = known.len();
            let at = *known.entry((self.links.get(i), ball.body)).or_insert(count);
            all.resize(all.len().max(at + 1), Vec::new());
            all[at].push(i);
        }
        all
    }

    /// The pairs of balls on different bodies and links, without those of `ignored` pairs of links, sorted by pairs of
    /// bodies; none if the balls belong to no links. Cost O(number of balls squared).
    #[must_use]
    pub fn pairs(&self, ignored: &[[String; 2]]) -> Vec<[usize; 2]> {
        let all: Vec<usize> = (0..self.links.len()).collect();
        self.pairs_among(&all, ignored)
    }

    /// The pairs of [trees](Self::trees), as [`pairs`](Self::pairs) lists those of balls.
    #[must_use]
    pub fn tree_pairs(&self, ignored: &[[String; 2]]) -> Vec<[usize; 2]> {
        let first: Vec<usize> = self.by_links().iter().map(|own| own[0]).collect();
        self.pairs_among(&first, ignored)
    }

    /// The pairs of the given balls, as indices in the list of these.
    fn pairs_among(&self, of: &[usize], ignored: &[[String; 2]]) -> Vec<[usize; 2]> {
        if self.links.is_empty() {
            return Vec::new();
        }
        let named = ignored.iter().flat_map(|[a, b]| [[a, b], [b, a]]);
        let ignored: HashSet<_> = named.collect();
        let ball = |i: &usize| (self.balls[of[*i]].body, &self.links[of[*i]]);
        let all = (0..of.len()).flat_map(|i| (i + 1..of.len()).map(move |j| [i, j]));
        let mut pairs: Vec<_> = all
            .filter(|[i, j]| {
                let ((body, a), (other, b)) = (ball(i), ball(j));
                body != other && a != b && !ignored.contains(&[a, b])
            })
            .collect();
        pairs.sort_by_key(|pair| pair.map(|i| ball(&i).0));
        pairs
    }
}
