//! Convex bodies with a radius, and their support functions, smoothed.

use super::hull::bounds;
use super::{ConvexPiece, PIECE_RADIUS, Shape, Solid};
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Placement, dot, outer};
use arrayvec::ArrayVec;
use nalgebra::{Matrix3, Vector3};
use std::cell::Cell;
use std::ops::Range;

/// A convex body: the points within a radius of the hull of corners and, about each of these, a disc.
#[derive(Clone, Debug, PartialEq)]
pub struct Convex<C: Scalar = f64> {
    /// The corners, m, those near each other one after the other.
    corners: Vec<Vector3<C>>,
    /// Blocks of them, each followed by those within it.
    blocks: Vec<Block<C>>,
    /// The radius, m.
    pub radius: C,
    /// The unit normal of the disc and its radius, m, if there is one: a cylinder has two corners.
    disc: Option<(Vector3<C>, C)>,
}

/// Corners that are near each other.
#[derive(Clone, Debug, PartialEq)]
struct Block<C: Scalar> {
    /// Their average, and the radius of a ball about it that contains them, m.
    centre: Vector3<C>,
    radius: C,
    corners: Range<usize>,
    /// The index of the first block that is not within this one.
    next: usize,
}

/// A smoothed support function at a direction, with its derivatives there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent<S: Scalar> {
    /// The extent in the direction, m, at least that of the body without its radius.
    pub value: S,
    /// The gradient: an average of the points that are furthest, m.
    pub point: Vector3<S>,
    /// The Hessian, m.
    pub curvature: Matrix3<S>,
}

impl Convex {
    /// A piece of a mesh.
    #[must_use]
    pub fn of_piece(piece: &ConvexPiece) -> Self {
        Self::of_corners(piece.corners.clone(), PIECE_RADIUS)
    }

    /// A solid; `None` for a half-space, which has no end.
    #[must_use]
    pub fn of_solid(solid: &Solid) -> Option<Self> {
        let at = |x: f64, y: f64, z: f64| solid.placement.point(&Vector3::new(x, y, z));
        let ends = |half: f64| vec![at(0.0, 0.0, half), at(0.0, 0.0, -half)];
        Some(match solid.shape {
            Shape::Sphere { radius } => Self::of_corners(vec![solid.placement.translation], radius),
            Shape::Capsule { radius, half_length } => Self::of_corners(ends(half_length), radius),
            Shape::Cylinder { radius, half_length } => {
                let axis = solid.placement.rotation.column(2).into_owned();
                Self { disc: Some((axis, radius)), ..Self::of_corners(ends(half_length), 0.0) }
            }
            Shape::Cuboid { half_extents: h } => {
                let sides = [-1.0, 1.0];
                let corners = sides.iter().flat_map(|x| sides.iter().map(move |y| (x, y)));
                let corners = corners.flat_map(|(x, y)| sides.iter().map(move |z| (x, y, z)));
                Self::of_corners(corners.map(|(x, y, z)| at(x * h.x, y * h.y, z * h.z)).collect(), 0.0)
            }
            Shape::HalfSpace => return None,
        })
    }

    /// The points within a radius of the hull of corners, m.
    #[must_use]
    pub fn of_corners(mut corners: Vec<Vector3<f64>>, radius: f64) -> Self {
        sort(&mut corners);
        let mut blocks = Vec::new();
        add_blocks(&corners, 0, 0, &mut blocks);
        Self { blocks, corners, radius, disc: None }
    }

    /// The same moved by a placement.
    #[must_use]
    pub fn moved(&self, placement: &Placement<f64>) -> Self {
        Self {
            corners: self.corners.iter().map(|corner| placement.point(corner)).collect(),
            blocks: self.blocks.iter().map(|of| Block { centre: placement.point(&of.centre), ..of.clone() }).collect(),
            disc: self.disc.map(|(axis, radius)| (placement.rotation * axis, radius)),
            ..*self
        }
    }

    /// A ball that contains the body.
    #[must_use]
    pub fn ball(&self) -> super::Sphere {
        let [lower, upper] = bounds(self.corners.iter());
        let centre = (lower + upper) * 0.5;
        let furthest = self.corners.iter().fold(0.0_f64, |most, corner| most.max((corner - centre).norm()));
        let disc = self.disc.map_or(0.0, |(_, radius)| radius);
        // The axis of a disc is along the line of its two corners.
        super::Sphere { centre, radius: furthest.hypot(disc) + self.radius }
    }

    /// The extent in a unit direction from the origin, m.
    #[must_use]
    pub fn extent(&self, direction: &Vector3<f64>) -> f64 {
        direction.dot(&self.furthest(direction)) + self.radius
    }

    /// A point of the body without its radius that is furthest in a direction.
    #[must_use]
    pub fn furthest(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let (most, mut furthest) = (Cell::new(f64::NEG_INFINITY), Vector3::zeros());
        let length = direction.norm();
        let is_below = |block: &Block<f64>| along(direction, &block.centre) + block.radius * length < most.get();
        self.search(is_below, |_, corner| {
            let extent = along(direction, corner);
            if extent > most.get() {
                most.set(extent);
                furthest = *corner;
            }
        });
        let off = self.disc.map_or_else(Vector3::zeros, |(axis, radius)| {
            let across = |v: Vector3<f64>| v - axis * axis.dot(&v);
            // Rounding of the first difference is not small relative to it where the direction is nearly the axis.
            let unit = across(*direction).try_normalize(PARALLEL * length).unwrap_or_default();
            across(unit) * radius
        });
        furthest + off
    }

    /// The corners, m, those near each other one after the other.
    #[must_use]
    pub fn corners(&self) -> &[Vector3<f64>] {
        &self.corners
    }
}

/// The largest difference of a smoothed maximum of two numbers and their maximum, relative to the width.
const MOST_ADDED: f64 = 3.0 / 16.0;

/// The length across the axis of a disc, relative to that of a direction, up to which the direction is along the axis.
const PARALLEL: f64 = 1e-12;

/// The largest difference of the smoothed extent of a disc and its extent, relative to the width.
const DISC: f64 = 0.25;

/// Sorts points so that those of each half, quarter and so on are near each other.
fn sort(points: &mut [Vector3<f64>]) {
    if points.len() <= 2 {
        return;
    }
    let [lower, upper] = bounds(points.iter());
    let axis = (upper - lower).imax();
    points.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
    let (first, second) = points.split_at_mut(half(points.len()));
    sort(first);
    sort(second);
}

/// The number of corners in the first half of several ones: a power of two.
fn half(count: usize) -> usize {
    count.next_power_of_two() / 2
}

/// The largest number of levels of the tree of corners, of which there are fewer than a million, and one more.
const LEVELS: usize = 21;

/// The number of corners of a block.
const BLOCK: usize = 8;

/// The depth below the furthest corner beyond which corners are left out, in widths: they act on the maximum by way of
/// others alone, each within a width of the next, with weights whose product is below rounding.
const DEPTH: f64 = 3.0;

/// The width of the smoothing and its inverse.
struct Smoothing<S> {
    width: S,
    inverse: S,
}

/// The smoothed maximum of the extents of some corners.
#[derive(Clone, Copy)]
struct Node<S> {
    /// The index of the last corner.
    last: usize,
    value: S,
    point: [S; 3],
    /// The Hessian: its entries `xx`, `xy`, `xz`, `yy`, `yz` and `zz`.
    curvature: [S; 6],
}

impl<C: Scalar> Convex<C> {
    /// A bound on the difference of the smoothed extent and the extent, relative to the width of the smoothing.
    #[must_use]
    pub fn excess(&self) -> f64 {
        let levels = f64::from(self.corners.len().next_power_of_two().trailing_zeros());
        levels * MOST_ADDED + self.disc.map_or(0.0, |_| DISC)
    }

    /// Calls `visit` with the corners and their indices, without those of blocks that are below.
    #[inline(always)]
    fn search(&self, is_below: impl Fn(&Block<C>) -> bool, mut visit: impl FnMut(usize, &Vector3<C>)) {
        let mut at = 0;
        while let Some(block) = self.blocks.get(at) {
            if is_below(block) {
                at = block.next;
                continue;
            }
            at += 1;
            // There is no block within this one.
            if block.next == at {
                let corners = &self.corners[block.corners.clone()];
                (block.corners.start..).zip(corners).for_each(|(i, corner)| visit(i, corner));
            }
        }
    }

    /// The smoothed extent in a direction of length one: the maximum of the extents of corners by halves, where that of
    /// two numbers with the difference `d`, in widths `u`, is $y + w d + \frac{3}{16} (1 - u^2)^2$ with
    /// $w = \frac{1}{2} + \frac{3}{4} u - \frac{1}{4} u^3$ for $|u| < 1$, and their maximum beyond. It is convex, twice
    /// continuously differentiable, and at least the extent. A point of the body that is nearly the furthest one saves
    /// the search for that.
    pub(super) fn smoothed<S: AlgebraOver<C>>(
        &self,
        direction: &Vector3<S>,
        width: f64,
        known_point: Option<&Vector3<S>>,
    ) -> Extent<S> {
        // A disc is not part of the hull of the corners.
        let known_point = known_point.filter(|_| self.disc.is_none());
        let most = Cell::new(match known_point {
            Some(point) => dot(direction, point),
            None => along(direction, &self.corners[0]),
        });
        let raise = |x: S| most.set((x - most.get()).if_negative(most.get(), x));
        let is_below = |block: &Block<C>| {
            let middle = along(direction, &block.centre);
            let is_below = is_nowhere_negative(most.get() - middle - S::lift(block.radius));
            // The centre, an average of corners, is within the body.
            raise(middle);
            is_below
        };
        if known_point.is_none() {
            self.search(is_below, |_, corner| raise(along(direction, corner)));
        }
        let floor = most.get() - S::from_f64(DEPTH * width);
        let with = Smoothing { width: S::from_f64(width), inverse: S::from_f64(1.0 / width) };
        let mut nodes = ArrayVec::<Node<S>, LEVELS>::new();
        let join_last = |nodes: &mut ArrayVec<Node<S>, LEVELS>| {
            if let (Some(last), Some(node)) = (nodes.pop(), nodes.last_mut()) {
                node.join(&last, &with);
            }
        };
        let is_below =
            |block: &Block<C>| is_nowhere_negative(floor - along(direction, &block.centre) - S::lift(block.radius));
        self.search(is_below, |i, corner| {
            let value = along(direction, corner);
            if is_nowhere_negative(floor - value) {
                return;
            }
            // Two nodes are joined once the next corner is in another part of the tree.
            while let [.., before, last] = &nodes[..]
                && (before.last ^ last.last) < (last.last ^ i)
            {
                join_last(&mut nodes);
            }
            let point = [0, 1, 2].map(|k| S::lift(corner[k]));
            nodes.push(Node { last: i, value, point, curvature: [S::zero(); 6] });
        });
        while nodes.len() > 1 {
            join_last(&mut nodes);
        }
        let Node { value, point, curvature: [xx, xy, xz, yy, yz, zz], .. } = nodes[0];
        let curvature = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let mut found = Extent { value, point: point.into(), curvature };
        if let Some((axis, radius)) = &self.disc {
            found.add_disc(direction, (axis, *radius), &with);
        }
        found
    }
}

/// Adds the block of some corners, from `first` on, and those within it: of a quarter of them each.
fn add_blocks(corners: &[Vector3<f64>], first: usize, depth: usize, blocks: &mut Vec<Block<f64>>) {
    let count = corners.len();
    let is_node = depth.is_multiple_of(2) || count <= BLOCK;
    let at = blocks.len();
    if is_node {
        let centre = corners.iter().sum::<Vector3<f64>>() / count as f64;
        let radius = corners.iter().fold(0.0_f64, |most, corner| most.max((corner - centre).norm()));
        blocks.push(Block { centre, radius, corners: first..first + count, next: at + 1 });
    }
    if count > BLOCK {
        let half = half(count);
        add_blocks(&corners[..half], first, depth + 1, blocks);
        add_blocks(&corners[half..], first + half, depth + 1, blocks);
    }
    if is_node {
        blocks[at].next = blocks.len();
    }
}

/// The extent of a corner.
#[inline(always)]
fn along<C: Scalar, S: AlgebraOver<C>>(direction: &Vector3<S>, corner: &Vector3<C>) -> S {
    direction.x.scale(corner.x) + direction.y.scale(corner.y) + direction.z.scale(corner.z)
}

/// Returns true if a number is negative nowhere.
#[inline(always)]
pub(crate) fn is_nowhere_negative<S: Scalar>(x: S) -> bool {
    x.if_negative(S::one(), S::zero()).vanishes()
}

impl<S: Scalar> Node<S> {
    /// The smoothed maximum of this and the next node.
    #[inline(always)]
    fn join(&mut self, next: &Self, with: &Smoothing<S>) {
        let [one, half, quarter] = [1.0, 0.5, 0.25].map(S::from_f64);
        let d = self.value - next.value;
        self.last = next.last;
        if is_nowhere_negative(d - with.width) {
            return;
        }
        if is_nowhere_negative(-d - with.width) {
            *self = *next;
            return;
        }
        let u = d * with.inverse;
        let u = (one - u).if_negative(one, u);
        let u = (u + one).if_negative(-one, u);
        let square = u * u;
        let left = one - square;
        let weight = half + u * (half + quarter - quarter * square);
        let bend = S::from_f64(0.75) * left * with.inverse;
        self.value = next.value + weight * d + S::from_f64(MOST_ADDED) * with.width * left * left;
        let mut off = [S::zero(); 3];
        for k in 0..3 {
            off[k] = self.point[k] - next.point[k];
            self.point[k] = next.point[k] + off[k] * weight;
        }
        let mut entry = 0;
        for i in 0..3 {
            let bent = off[i] * bend;
            for j in i..3 {
                let (own, other) = (&mut self.curvature[entry], next.curvature[entry]);
                *own = other + (*own - other) * weight + bent * off[j];
                entry += 1;
            }
        }
    }
}

impl<S: Scalar> Extent<S> {
    /// Adds a disc: $\rho \sqrt{|n_\perp|^2 + \epsilon^2}$.
    fn add_disc<C: Scalar>(&mut self, n: &Vector3<S>, (axis, radius): (&Vector3<C>, C), with: &Smoothing<S>)
    where
        S: AlgebraOver<C>,
    {
        let (axis, radius) = (axis.map(S::lift), S::lift(radius));
        let across = n - axis * dot(&axis, n);
        let least = S::from_f64(DISC) * with.width / radius;
        let length = (dot(&across, &across) + least * least).sqrt();
        let inverse = S::one() / length;
        let unit = across * inverse;
        let bend = radius * inverse;
        self.value += radius * length;
        self.point += unit * radius;
        self.curvature -= (outer(&unit, &unit) + outer(&axis, &axis)) * bend;
        for i in 0..3 {
            self.curvature[(i, i)] += bend;
        }
    }
}
