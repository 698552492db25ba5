//! Clearances of convex bodies.

use super::clearance::distance;
use super::label::name_of;
use super::{
    ActivePair, CollisionSphere, Constraint, PairDistance, PlacedState, Quantity, RowLabel, RowList, RowSet,
    WeightedDerivatives, Weights,
};
use crate::error::{Error, Result};
use crate::geometry::{Convex, Placed, Plane, PlaneHint, Scene, Solid, Sphere, Until, WIDTHS, is_nowhere_negative};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Force, Placement, cross, dot, placed_point};
use nalgebra::Vector3;

/// The distance beyond its margin from which on bodies no longer act, relative to the radius of the largest one.
const FAR: f64 = 0.35;

/// The share of the cutoff within which a row is exact along a search: at least that of the working set, whose default
/// is the same.
const EXACT: f64 = 0.5;

/// The least width, and the ratio of one to the next larger one, for pairs that are near each other at an end.
const LEAST_WIDTH: f64 = 1e-6;
const NARROWER: f64 = 0.25;

/// A convex body of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexPart<C: Scalar = f64> {
    /// The body that carries it; `None` is the base.
    pub body: Option<usize>,
    /// The convex body, in the frame of this.
    pub convex: Convex<C>,
    /// A ball that contains it.
    pub ball: Sphere<C>,
}

/// A part of the robot, or a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Other {
    /// The part of the robot with this index.
    Part(usize),
    /// The solid with this index.
    Solid(usize),
}

/// A part of the robot that keeps clear of another one or of a solid.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexPair<C: Scalar = f64> {
    /// The index of the part.
    pub part: usize,
    /// The other one.
    pub other: Other,
    /// The distance that is kept, m.
    pub margin: C,
    /// The width of the smoothing, m.
    pub width: f64,
}

/// Convex parts of the robot stay clear of solids and of each other, one row per pair: $g = m - \min(\phi, m + f)$ in m
/// with the margin `m`, the [gap](Plane) $\phi$ of the plane that separates the smoothed bodies best, less their radii,
/// and `f` for [`far`](Self::far). The gap is at most the distance, so that a motion that keeps its rows keeps its
/// margins.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexClearance<C: Scalar = f64> {
    /// The parts of the robot.
    pub parts: Vec<ConvexPart<C>>,
    /// The solids in the base frame, each with its convex form unless it is a half-space.
    pub solids: Vec<(Solid<C>, Option<Convex<C>>)>,
    /// The names of the solids.
    pub names: Vec<String>,
    /// The pairs that keep clear.
    pub pairs: Vec<ConvexPair<C>>,
    /// The distance beyond the margin from which on distances count as this, m.
    pub far: C,
}

impl ConvexClearance {
    /// The rows of a scene of convex bodies.
    pub(super) fn of_scene(scene: &Scene) -> Self {
        let robot = scene.robot();
        let part = |(convex, ball): (&Convex, &CollisionSphere)| ConvexPart {
            body: ball.body,
            convex: convex.clone(),
            ball: Sphere { centre: ball.centre, radius: ball.radius },
        };
        let parts: Vec<_> = robot.parts.iter().zip(&robot.balls).map(part).collect();
        let moving = || (0..parts.len()).filter(|i| parts[*i].body.is_some());
        let margins = scene.obstacle_margins().iter().enumerate();
        let of_solids = margins.flat_map(|(k, margin)| {
            moving().map(move |part| ConvexPair { part, other: Other::Solid(k), margin: *margin, width: WIDTHS[1] })
        });
        let mut pairs: Vec<_> = of_solids.collect();
        let parts_of = |tree: usize| scene.trees()[tree].nodes.iter().filter_map(|node| node.leaf);
        for ([a, b], margin) in scene.tree_pairs().iter().zip(scene.pair_margins()) {
            for part in parts_of(*a) {
                let pair = |j| ConvexPair { part, other: Other::Part(j), margin: *margin, width: WIDTHS[1] };
                pairs.extend(parts_of(*b).map(pair));
            }
        }
        let largest = parts.iter().fold(0.0, |most: f64, part| most.max(part.ball.radius));
        let obstacles = scene.obstacles();
        let mut rows = Self {
            pairs,
            solids: obstacles.iter().map(|o| o.solid).zip(scene.forms().iter().cloned()).collect(),
            names: obstacles.iter().map(|o| o.name.clone()).collect(),
            far: FAR * largest,
            parts,
        };
        for placements in scene.ends() {
            rows.fit(placements);
        }
        rows
    }

    /// Smooths pairs less that are violated with the bodies at `placements` by the smoothing alone, as those of a start
    /// that is right next to an obstacle.
    fn fit(&mut self, placements: &[Placement<f64>]) {
        for row in 0..self.pairs.len() {
            let bound = self.bound(row, placements);
            while bound < self.excess(row)
                && self.pairs[row].width > LEAST_WIDTH
                && self.plane(row, placements, None, Until::Value).1 < 0.0
            {
                self.pairs[row].width *= NARROWER;
            }
        }
    }
}

/// The row of a pair that is near.
struct Near<S: Scalar> {
    row: usize,
    plane: Plane<S>,
    g: S,
    /// Negative where the pair is far.
    is_near: S,
}

impl<C: Scalar> ConvexClearance<C> {
    /// A lower bound on the distance of a pair less its margin, m, by balls.
    pub(crate) fn bound<S: AlgebraOver<C>>(&self, row: usize, placements: &[Placement<S>]) -> S {
        let ConvexPair { part, other, margin, .. } = &self.pairs[row];
        let first = &self.parts[*part];
        let centre = first.centre(placements);
        let reach = first.ball.radius + *margin;
        match other {
            Other::Part(j) => {
                let second = &self.parts[*j];
                let off = centre - second.centre(placements);
                dot(&off, &off).sqrt() - S::lift(reach + second.ball.radius)
            }
            Other::Solid(k) => self.solids[*k].0.distance(&centre) - S::lift(reach),
        }
    }

    /// A direction from the other body of a pair to the part, which separates them where they are far from each other.
    fn direction<S: AlgebraOver<C>>(&self, row: usize, placements: &[Placement<S>]) -> Vector3<S> {
        let ConvexPair { part, other, .. } = &self.pairs[row];
        let centre = self.parts[*part].centre(placements);
        match other {
            Other::Part(j) => centre - self.parts[*j].centre(placements),
            Other::Solid(k) => self.solids[*k].0.distance_derivatives(&centre).normal,
        }
    }

    /// The best plane of a pair, and its gap less the radii and the margin, m, or one with a gap that is enough: from
    /// a plane at a state nearby, if there is one, which is followed where the bodies overlap if it comes with `true`.
    pub(crate) fn plane<S: AlgebraOver<C>>(
        &self,
        row: usize,
        placements: &[Placement<S>],
        hint: Option<(&PlaneHint<S>, bool)>,
        until: Until<S>,
    ) -> (Plane<S>, S) {
        let ConvexPair { part, other, margin, width } = &self.pairs[row];
        let first = &self.parts[*part];
        let placed = |part: &'_ ConvexPart<C>| part.body.map(|body| &placements[body]);
        let body = Placed { convex: &first.convex, placement: placed(first) };
        let reach = first.convex.radius + *margin;
        let between = |other: Placed<'_, C, S>| {
            let reach = S::lift(reach + other.convex.radius);
            let until = match until {
                Until::Gap(enough) => Until::Gap(enough + reach),
                other => other,
            };
            let plane =
                Plane::between(&[body, other], (|| self.direction(row, placements), hint), [WIDTHS[0], *width], until);
            let gap = plane.gap - reach;
            (plane, gap)
        };
        match other {
            Other::Part(j) => {
                let second = &self.parts[*j];
                between(Placed { convex: &second.convex, placement: placed(second) })
            }
            Other::Solid(k) => match &self.solids[*k] {
                (_, Some(convex)) => between(Placed { convex, placement: None }),
                (Solid { placement, .. }, None) => {
                    let normal = placement.rotation.column(2).into_owned();
                    let offset = S::lift(dot(&normal, &placement.translation));
                    let plane = Plane::of_half_space(&body, &normal.map(S::lift), offset, *width);
                    let gap = plane.gap - S::lift(reach);
                    (plane, gap)
                }
            },
        }
    }

    /// Checks that the robot has the bodies of the parts.
    fn check_bodies(&self, found: usize) -> Result<()> {
        let bodies = self.parts.iter().filter_map(|part| part.body);
        match bodies.max().filter(|last| *last >= found) {
            Some(last) => Err(Error::Length { what: "bodies of the robot of a constraint", expected: last + 1, found }),
            None => Ok(()),
        }
    }

    /// Calls `visit` with the needed rows that are near.
    fn visit<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        rows: impl Iterator<Item = usize>,
        until: Until<S>,
        mut visit: impl FnMut(Near<S>) -> Result<()>,
    ) -> Result<()> {
        self.check_bodies(at.placements.len())?;
        for row in rows {
            let bound = self.bound(row, at.placements);
            if is_nowhere_negative(bound - S::lift(self.far) - S::from_f64(self.excess(row))) {
                continue;
            }
            let hint = at.active_pairs.and_then(|pairs| pairs.plane(row));
            let (plane, gap) = self.plane(row, at.placements, hint, until);
            let is_far = gap - if let Until::Gap(enough) = until { enough } else { S::lift(self.far) };
            let g = is_far.if_negative(-gap, S::lift(-self.far));
            visit(Near { row, plane, g, is_near: -is_far })?;
        }
        Ok(())
    }

    /// A bound on the difference of the gap of a pair and its distance, m.
    fn excess(&self, row: usize) -> f64 {
        let ConvexPair { part, other, width, .. } = &self.pairs[row];
        let second = match other {
            Other::Part(j) => self.parts[*j].convex.excess(),
            Other::Solid(k) => self.solids[*k].1.as_ref().map_or(0.0, Convex::excess),
        };
        width * (self.parts[*part].convex.excess() + second)
    }

    /// The bodies of a pair.
    fn bodies(&self, pair: &ConvexPair<C>) -> [Option<usize>; 2] {
        let second = match pair.other {
            Other::Part(j) => self.parts[j].body,
            Other::Solid(_) => None,
        };
        [self.parts[pair.part].body, second]
    }
}

impl<C: Scalar> ConvexPart<C> {
    /// The centre of the ball about it.
    fn centre<S: AlgebraOver<C>>(&self, placements: &[Placement<S>]) -> Vector3<S> {
        placed_point(self.body.map(|body| &placements[body]), &self.ball.centre)
    }
}

impl<C: Scalar> Constraint<C> for ConvexClearance<C> {
    fn dim(&self) -> usize {
        self.pairs.len()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        self.value_of(at, None, g, None)
    }

    fn value_of<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        rows: Option<RowList<'_>>,
        g: &mut [S],
        mut active_pairs: Option<&mut Vec<ActivePair<S>>>,
    ) -> Result<()> {
        let far = S::lift(-self.far);
        match rows {
            None => g.fill(far),
            Some(rows) => rows.iter().for_each(|row| g[row] = far),
        }
        let take = |near: Near<S>| {
            g[near.row] = near.g;
            if let Some(active_pairs) = &mut active_pairs {
                active_pairs.push(ActivePair { row: near.row, plane: near.plane.hint() });
            }
            Ok(())
        };
        let enough = S::lift(self.far) * S::from_f64(EXACT);
        let until = at.active_pairs.map_or(Until::Value, |_| Until::Gap(enough));
        match rows {
            None => self.visit(at, 0..self.pairs.len(), until, take),
            Some(rows) => self.visit(at, rows.iter(), until, take),
        }
    }

    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        let Some(pair) = self.pairs.get(row) else {
            return RowLabel::numbered(row);
        };
        let [first, second] = self.bodies(pair).map(|body| name_of(body, model));
        match pair.other {
            Other::Part(_) => distance(first, second, Quantity::SelfCollision),
            Other::Solid(k) => distance(first, format!("'{}'", self.names[k]), Quantity::Obstacles),
        }
    }

    fn row_set(&self, row: usize) -> RowSet<C> {
        let gap = self.pairs.get(row).map(|pair| {
            let of = |part: &ConvexPart<C>| {
                let r = dot(&part.ball.centre, &part.ball.centre).sqrt() + part.ball.radius;
                part.body.map(|body| (body, r))
            };
            let second = match pair.other {
                Other::Part(j) => of(&self.parts[j]),
                Other::Solid(_) => None,
            };
            PairDistance { bodies: [of(&self.parts[pair.part]), second], squared: None }
        });
        RowSet { cutoff: Some(self.far), ..RowSet::clearance(gap) }
    }

    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let needed = (0..self.pairs.len()).filter(|row| !weights.vanish(*row));
        self.visit(at, needed, Until::Derivatives, |Near { row, plane, is_near, .. }| {
            let w = is_near.if_negative(S::zero(), -weights.first_order[row]);
            let c = weights.gauss_newton.map(|c| is_near.if_negative(S::zero(), c[row]));
            let force = Force::new(cross(&plane.points[0], &plane.normal), plane.normal);
            out.add_coupling(self.bodies(&self.pairs[row]), &force, || plane.coupling(), w, c)
        })
    }
}
