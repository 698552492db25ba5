//! The distances that links keep from obstacles and from each other, and bounds on how much a motion changes them.

use crate::constraint::{
    AnyConstraint, Bound, CollisionSphere, ConvexClearance, ConvexPart, Other as Beside, SelfClearance,
};
use crate::geometry::{BallTree, Shape, Solid, Sphere, Until};
use crate::model::{JointKind, Model};
use crate::scalar::{LANES, Scalar, Wide};
use crate::spatial::{Placement, dot, placed_point};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// The part of a distance, m, or of a position that may be lost to rounding at the ends of a path.
const ROUNDING: f64 = 1e-9;

/// The pairs of constraints, and their bounds of positions.
#[derive(Debug, Default)]
pub(super) struct Distances<'a> {
    links: Vec<BallTree>,
    /// The centres of balls around them at several configurations.
    centres: Vec<Vector3<Wide>>,
    pairs: Vec<Pair<'a>>,
    /// With the largest value of each row that counts as free.
    bounds: Vec<(Bound, f64)>,
}

/// A link and an obstacle or another link.
#[derive(Debug)]
struct Pair<'a> {
    link: usize,
    other: Other,
    /// The row of the pair if it is one of convex bodies, which the balls of the links contain.
    row: Option<(&'a ConvexClearance, usize)>,
    /// The distance that counts as free, m, and by how much more than the constraint requires.
    kept: f64,
    margin: f64,
    /// The largest change of the distance with the motion of each joint, m/rad or 1.
    reaches: Vec<f64>,
    /// The same with the motion along a line, m.
    speed: f64,
    /// The sum of the radii of balls around both, m; that of a half-space has none.
    radius: f64,
}

/// The other part of a pair.
#[derive(Debug)]
enum Other {
    Solid(Solid),
    Link(usize),
}

/// The findings about a pair at several configurations.
pub(super) struct Look {
    /// A bit for each configuration at which the pair is nearer than the distance that was asked for.
    pub near: u8,
    /// True if the pair is not free at one of them.
    pub hit: bool,
}

impl Look {
    /// Takes the distance of two nodes; returns false if those below have no effect.
    #[inline]
    fn take(&mut self, distance: &Wide, reach: f64, is_leaf: bool) -> bool {
        let mut should_continue = false;
        for (lane, d) in distance.0.iter().enumerate() {
            let is_near = self.near >> lane & 1 == 1;
            if d.is_nan() || *d < if is_near { 0.0 } else { reach } {
                should_continue = true;
                if is_leaf {
                    self.near |= 1 << lane;
                    self.hit |= d.is_nan() || *d < 0.0;
                }
            }
        }
        should_continue && !self.hit
    }
}

impl<'a> Distances<'a> {
    /// Collects the pairs of constraints for a robot that has all their bodies; returns true if other rows remain.
    pub fn new(model: &Model, parts: &[&'a AnyConstraint]) -> (Self, bool) {
        let (mut own, mut others) = (Self::default(), false);
        for part in parts {
            match part {
                AnyConstraint::Spheres(rows) => {
                    let solids = rows.spheres.iter().map(|sphere| Solid {
                        placement: Placement::new(Placement::identity().rotation, sphere.centre),
                        shape: Shape::Sphere { radius: sphere.radius },
                    });
                    own.add_solids(&rows.balls, &solids.collect::<Vec<_>>());
                }
                AnyConstraint::Solids(rows) => own.add_solids(&rows.balls, &rows.solids),
                AnyConstraint::SelfCollision(rows) => own.add_pairs(rows),
                AnyConstraint::Convex(rows) => {
                    let first = own.links.len();
                    let ball = |part: &ConvexPart| {
                        let Sphere { centre, radius } = part.ball;
                        BallTree::new(&[CollisionSphere { body: part.body, centre, radius }], vec![0])
                    };
                    own.links.extend(rows.parts.iter().map(ball));
                    for (row, pair) in rows.pairs.iter().enumerate() {
                        let other = match pair.other {
                            Beside::Solid(k) => Other::Solid(rows.solids[k].0),
                            Beside::Part(j) => Other::Link(first + j),
                        };
                        own.add(first + pair.part, other, pair.margin, Some((rows, row)));
                    }
                }
                AnyConstraint::Bounds(rows) => {
                    let positions = rows.0.iter().filter(|bound| bound.entry < model.dof());
                    own.bounds.extend(positions.map(|bound| (*bound, 0.0)));
                }
                // At rest there is no speed.
                AnyConstraint::Speed(_) => {}
                // Projections keep sets with equalities.
                AnyConstraint::Frame(rows) => {
                    others |= !rows.rows.iter().any(|row| row.is_equality);
                }
                AnyConstraint::Other(_) => others = true,
            }
        }
        let reaches: Vec<_> = own.links.iter().map(|link| reaches(model, link)).collect();
        for pair in &mut own.pairs {
            pair.radius = own.links[pair.link].nodes[0].bound.radius
                + match pair.other {
                    Other::Solid(solid) => match solid.shape {
                        Shape::HalfSpace => f64::INFINITY,
                        Shape::Capsule { radius, half_length } => radius + half_length,
                        shape => shape.half_lengths().norm(),
                    },
                    Other::Link(other) => own.links[other].nodes[0].bound.radius,
                };
            pair.reaches.clone_from(&reaches[pair.link]);
            if let Other::Link(other) = pair.other {
                for (own, other) in pair.reaches.iter_mut().zip(&reaches[other]) {
                    // A joint that moves both does not change their distance.
                    *own = if *own > 0.0 && *other > 0.0 { 0.0 } else { *own + other };
                }
            }
        }
        (own, others)
    }

    fn add(&mut self, link: usize, other: Other, kept: f64, row: Option<(&'a ConvexClearance, usize)>) {
        self.pairs.push(Pair { link, other, row, kept, margin: 0.0, reaches: Vec::new(), speed: 0.0, radius: 0.0 });
    }

    /// Adds the pairs of each body and each solid.
    fn add_solids(&mut self, balls: &[CollisionSphere], solids: &[Solid]) {
        let mut bodies = BTreeMap::<_, Vec<usize>>::new();
        for (i, ball) in balls.iter().enumerate() {
            bodies.entry(ball.body).or_default().push(i);
        }
        for own in bodies.into_values() {
            self.links.push(BallTree::new(balls, own));
            for solid in solids {
                self.add(self.links.len() - 1, Other::Solid(*solid), 0.0, None);
            }
        }
    }

    /// Adds pairs of balls, those with the same partners together: if one of them is in a pair, so are all.
    fn add_pairs(&mut self, rows: &SelfClearance) {
        let mut partners = vec![Vec::new(); rows.balls.len()];
        for [i, j] in &rows.pairs {
            partners[*i].push(*j);
            partners[*j].push(*i);
        }
        partners.iter_mut().for_each(|own| own.sort_unstable());
        let mut classes = BTreeMap::<_, Vec<usize>>::new();
        for (i, (ball, partners)) in rows.balls.iter().zip(partners).enumerate() {
            classes.entry((ball.body, partners)).or_default().push(i);
        }
        let mut class_of = vec![0; rows.balls.len()];
        for own in classes.into_values() {
            for i in &own {
                class_of[*i] = self.links.len();
            }
            self.links.push(BallTree::new(&rows.balls, own));
        }
        let pairs = rows.pairs.iter().map(|pair| pair.map(|i| class_of[i]));
        let mut pairs: Vec<_> = pairs.map(|[i, j]| [i.min(j), i.max(j)]).collect();
        pairs.sort_unstable();
        pairs.dedup();
        for [i, j] in pairs {
            self.add(i, Other::Link(j), 0.0, None);
        }
    }

    /// The number of pairs.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// Requires every pair and joint to keep `margin` more, or as much as at the configurations `q` if that is less.
    pub fn keep(&mut self, margin: f64, q: &[Wide], placements: &[Placement<Wide>]) {
        let least = |x: Wide| x.0.iter().copied().fold(f64::INFINITY, f64::min);
        for k in 0..self.pairs.len() {
            self.pairs[k].margin = 0.0;
            let mut has = margin + ROUNDING;
            self.search(k, placements, f64::INFINITY, |distance, is_leaf| {
                let distance = least(*distance);
                let is_near = distance < has;
                if is_near && is_leaf {
                    has = distance;
                }
                is_near
            });
            self.pairs[k].margin = has - ROUNDING;
        }
        for (bound, most) in &mut self.bounds {
            let has = least(-bound.row(q[bound.entry])) - ROUNDING;
            *most = -has.min(margin);
        }
    }

    /// Returns true if all joints are within their bounds.
    pub fn is_inside(&self, q: &[Wide]) -> bool {
        self.bounds.iter().all(|(bound, most)| {
            let row = bound.row(q[bound.entry]);
            row.0.iter().all(|row| row <= most)
        })
    }

    /// Takes the configurations at which [`look`](Self::look) looks.
    pub fn place(&mut self, placements: &[Placement<Wide>]) {
        let roots = self.links.iter().map(|link| {
            let root = link.nodes.first();
            root.map_or_else(Vector3::zeros, |root| {
                placed_point(link.body.map(|body| &placements[body]), &root.bound.centre)
            })
        });
        self.centres.clear();
        self.centres.extend(roots);
    }

    /// Takes a line along which the joints move by these distances.
    pub fn begin_line(&mut self, moves: &[f64]) {
        for pair in &mut self.pairs {
            // A slider without limits has an infinite reach.
            let terms = pair.reaches.iter().zip(moves).filter(|(_, by)| **by > 0.0);
            pair.speed = terms.map(|(reach, by)| reach * by).sum();
        }
    }

    /// Looks whether a pair keeps its distance with the bodies at `placements`, and where it might be less than the
    /// constraint requires while the configuration moves by `share` of the line from there.
    pub fn look(&self, pair: usize, placements: &[Placement<Wide>], share: f64) -> Look {
        let own = &self.pairs[pair];
        let reach = (share * own.speed - own.margin).max(0.0);
        let mut look = Look { near: 0, hit: false };
        // Most are so far from each other that balls around them are.
        let other = match &own.other {
            Other::Solid(solid) => solid.placement.translation.map(Wide::splat),
            Other::Link(other) => self.centres[*other],
        };
        let d = self.centres[own.link] - other;
        let far = own.radius + own.kept + own.margin + reach;
        if dot(&d, &d).0.iter().all(|square| *square >= far * far) {
            return look;
        }
        self.search(pair, placements, reach, |distance, is_leaf| look.take(distance, reach, is_leaf));
        look
    }

    /// Visits lower bounds of the distance of a pair, less that which is kept, and the distances of balls; of convex
    /// bodies those up to `enough`.
    fn search(
        &self,
        pair: usize,
        placements: &[Placement<Wide>],
        enough: f64,
        mut visit: impl FnMut(&Wide, bool) -> bool,
    ) {
        let Pair { link, other, kept, margin, row, .. } = &self.pairs[pair];
        if let Some((rows, row)) = row {
            let margin = Wide::splat(*margin);
            let bound = rows.bound(*row, placements);
            if visit(&(bound - margin), false) {
                let (_, gap) = rows.plane(*row, placements, None, Until::Gap(margin + Wide::splat(enough)));
                visit(&(gap - margin), true);
            }
            return;
        }
        let kept = kept + margin;
        let link = &self.links[*link];
        let place = |tree: &BallTree, centre| placed_point(tree.body.map(|body| &placements[body]), centre);
        let is_nearer = |a: &Wide, b: &Wide| (0..LANES).all(|k| a.0[k] < b.0[k]);
        match other {
            Other::Solid(solid) => {
                let bound = |node: usize| {
                    let ball = &link.nodes[node].bound;
                    let distance = solid.distance(&place(link, &ball.centre));
                    distance - Wide::splat(ball.radius + kept)
                };
                link.search(bound, is_nearer, |node, distance| visit(distance, link.nodes[node].leaf.is_some()));
            }
            Other::Link(other) => {
                let other = &self.links[*other];
                let bound = |[i, j]: [usize; 2]| {
                    let (a, b) = (&link.nodes[i].bound, &other.nodes[j].bound);
                    let d = place(link, &a.centre) - place(other, &b.centre);
                    dot(&d, &d).sqrt() - Wide::splat(a.radius + b.radius + kept)
                };
                link.search_pairs(other, bound, is_nearer, |[i, j], distance| {
                    let is_leaf = link.nodes[i].leaf.is_some() && other.nodes[j].leaf.is_some();
                    visit(distance, is_leaf)
                });
            }
        }
    }
}

/// The largest motion of the centre of a ball of a link with that of each joint, m/rad or 1: its largest distance from
/// the axis, by the lengths between the joints.
fn reaches(model: &Model, link: &BallTree) -> Vec<f64> {
    let mut reaches = vec![0.0; model.dof()];
    let leaves = link.nodes.iter().filter(|node| node.leaf.is_some());
    let mut reach = leaves.map(|node| node.bound.centre.norm()).fold(0.0, f64::max);
    let mut body = link.body;
    while let Some(i) = body {
        let joint = &model.joints()[i];
        let travel = match joint.kind() {
            JointKind::Revolute | JointKind::Continuous => {
                reaches[i] = reach;
                0.0
            }
            JointKind::Prismatic => {
                reaches[i] = 1.0;
                let limits = joint.limits();
                limits.lower.abs().max(limits.upper.abs())
            }
        };
        reach += joint.origin().translation.norm() + travel;
        body = joint.parent();
    }
    reaches
}
