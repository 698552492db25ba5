//! Convex pieces that cover a mesh.

use super::Triangle;
use super::hull::{ConvexPiece, bounds, refused};
use crate::error::{Result, plain};
use nalgebra::Vector3;
use parry3d_f64::math::Vector as Coordinates;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::TriMesh;
use std::collections::HashMap;

/// The largest number of pieces of a mesh, beyond which a finer partition is not sought.
const MAX_PIECES: usize = 8;

/// The planes between the ends of a piece across each axis that may divide it, and the least share of its volume that
/// a division saves.
const PLANES: usize = 7;
const LEAST_SAVED: f64 = 0.03;

/// The number of corners by which the volumes of hulls are compared.
const SAMPLE: usize = 300;

/// The size of the parts of a surface, relative to the excess, that are not divided to find whether they exceed it.
const CLOSELY: f64 = 0.1;

/// The distance by which a point of a surface is moved outward to find whether another piece begins there, m.
const BEYOND: f64 = 1e-6;

/// Covers triangles by convex pieces, no point of which is further than `max_excess` in m from these and from the other
/// pieces if a partition into at most eight saves enough of their volume.
///
/// The hull of a set of triangles contains them, so the hulls of any partition of a mesh cover it. One piece is divided
/// after the other, by the plane across an axis that leaves the least volume, if a point of its surface is too far from
/// the triangles and at least 3 % of its volume are saved: the inside of an open tube stays part of a piece.
///
/// # Errors
/// There is no triangle, `max_excess` is not positive and finite, or a coordinate is not finite.
pub fn convex_pieces(triangles: &[Triangle], max_excess: f64) -> Result<Vec<ConvexPiece>> {
    if !(max_excess > 0.0 && max_excess.is_finite()) {
        return refused("excess", format!("it is {} and must be a positive number", plain(max_excess)));
    }
    let mesh = Mesh::new(triangles)?;
    let all: Vec<usize> = (0..triangles.len()).collect();
    let (mut pieces, mut of_pieces, mut closed) = (vec![mesh.hull(&all)?], vec![all], vec![false]);
    while pieces.len() < MAX_PIECES {
        let exceeding = (0..pieces.len()).find(|i| !closed[*i] && mesh.exceeds(&pieces, *i, max_excess));
        let Some(i) = exceeding else { break };
        match mesh.divided(&pieces[i], &of_pieces[i])? {
            None => closed[i] = true,
            Some([(first, below), (second, above)]) => {
                (pieces[i], of_pieces[i]) = (first, below);
                pieces.push(second);
                of_pieces.push(above);
                closed.push(false);
            }
        }
    }
    Ok(pieces)
}

/// A bound on the distance of the surfaces of pieces from triangles, where they are outside of the other pieces, m, to
/// within `accuracy`, m. Cost O(length of all edges / accuracy).
///
/// # Errors
/// There is no triangle, or a coordinate is not finite.
pub fn excess(pieces: &[ConvexPiece], triangles: &[Triangle], accuracy: f64) -> Result<f64> {
    let mesh = Mesh::new(triangles)?;
    let mut least = 0.0;
    for i in 0..pieces.len() {
        mesh.visit_surface(pieces, i, |part| {
            if part.is_outside || part.size <= accuracy {
                least = f64::max(least, part.distance);
            }
            part.most <= least + accuracy || part.size <= accuracy
        });
    }
    Ok(least + accuracy)
}

fn coordinates(p: &Vector3<f64>) -> Coordinates {
    Coordinates::new(p.x, p.y, p.z)
}

/// A piece and the indices of its triangles.
type Own = (ConvexPiece, Vec<usize>);

/// A triangle of the surface of a piece.
struct SurfacePart {
    /// The distance of its middle from the mesh, and a bound on that of all of its points, m.
    distance: f64,
    most: f64,
    /// The distance of its furthest point from the middle, m.
    size: f64,
    /// True if the middle is outside of the other pieces.
    is_outside: bool,
}

/// The inside of a piece and its surface: the planes of its faces, and its bounds.
struct Inside {
    planes: Vec<(Vector3<f64>, f64)>,
    bounds: [Vector3<f64>; 2],
}

impl Inside {
    fn new(piece: &ConvexPiece) -> Self {
        let plane = |[a, b, c]: Triangle| {
            let normal = (b - a).cross(&(c - a));
            (normal, normal.dot(&a))
        };
        Self { planes: piece.triangles().map(plane).collect(), bounds: bounds(piece.corners.iter()) }
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        let [lower, upper] = &self.bounds;
        let is_within = (0..3).all(|i| lower[i] <= p[i] && p[i] <= upper[i]);
        is_within && self.planes.iter().all(|(normal, offset)| normal.dot(p) <= *offset)
    }
}

/// Triangles and the distances from them.
struct Mesh {
    /// Their corners, each once, and the triangles as indices of these.
    corners: Vec<Vector3<f64>>,
    triangles: Vec<[usize; 3]>,
    shape: TriMesh,
}

impl Mesh {
    fn new(triangles: &[Triangle]) -> Result<Self> {
        if !triangles.iter().flatten().all(|p| p.iter().all(|x| x.is_finite())) {
            return refused("triangles", "a coordinate is not a finite number".to_owned());
        }
        let (mut corners, mut known) = (Vec::new(), HashMap::new());
        let mut number = |p: &Vector3<f64>| {
            *known.entry(<[f64; 3]>::from(*p).map(f64::to_bits)).or_insert_with(|| {
                corners.push(*p);
                corners.len() - 1
            })
        };
        let triangles: Vec<_> = triangles.iter().map(|t| t.each_ref().map(&mut number)).collect();
        let indices = triangles.iter().map(|t| t.map(|i| i as u32)).collect();
        match TriMesh::new(corners.iter().map(coordinates).collect(), indices) {
            Ok(shape) => Ok(Self { corners, triangles, shape }),
            Err(e) => refused("triangles", e.to_string()),
        }
    }

    fn corners_of(&self, triangle: usize) -> Triangle {
        self.triangles[triangle].map(|i| self.corners[i])
    }

    /// The corners of some triangles, each once.
    fn points(&self, own: &[usize]) -> Vec<Vector3<f64>> {
        let mut is_own = vec![false; self.corners.len()];
        for i in own.iter().flat_map(|i| self.triangles[*i]) {
            is_own[i] = true;
        }
        let corners = self.corners.iter().zip(is_own).filter(|(_, is_own)| *is_own);
        corners.map(|(corner, _)| *corner).collect()
    }

    fn hull(&self, own: &[usize]) -> Result<ConvexPiece> {
        ConvexPiece::hull(&self.points(own))
    }

    /// The volume of the hull of some triangles, nearly: by some of their corners if there are many.
    fn volume(&self, own: &[usize]) -> Result<f64> {
        let mut points = self.points(own);
        let every = points.len().div_ceil(SAMPLE);
        points = points.into_iter().step_by(every).collect();
        Ok(ConvexPiece::hull(&points)?.volume())
    }

    /// True if a point of the surface of a piece that is outside of the others is further than `most` from the
    /// triangles, m, or closely so.
    fn exceeds(&self, pieces: &[ConvexPiece], own: usize, most: f64) -> bool {
        let mut beyond = false;
        self.visit_surface(pieces, own, |part| {
            let is_within = part.most <= most;
            let is_decided = part.distance > most || part.size <= CLOSELY * most;
            beyond |= part.is_outside && !is_within && is_decided;
            beyond || is_within || part.size <= CLOSELY * most
        });
        beyond
    }

    /// Calls `is_done` with the triangles of the surface of a piece, and if it is not, with their quarters; without
    /// those within another piece.
    fn visit_surface(&self, pieces: &[ConvexPiece], own: usize, mut is_done: impl FnMut(&SurfacePart) -> bool) {
        let others = pieces.iter().enumerate().filter(|(i, _)| *i != own);
        let others: Vec<_> = others.map(|(_, piece)| Inside::new(piece)).collect();
        for triangle in pieces[own].triangles() {
            let [a, b, c] = triangle;
            let outward = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default() * BEYOND;
            let mut open = vec![(triangle, f64::MAX)];
            while let Some((triangle, most)) = open.pop() {
                let mut part = self.part(&triangle, most);
                if part.most > 0.0 {
                    let corners = triangle.map(|p| p + outward);
                    if others.iter().any(|other| corners.iter().all(|p| other.contains(p))) {
                        continue;
                    }
                    let middle = corners.iter().sum::<Vector3<f64>>() / 3.0;
                    part.is_outside = !others.iter().any(|other| other.contains(&middle));
                }
                if !is_done(&part) {
                    let [a, b, c] = triangle;
                    let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
                    let quarters = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
                    // Their middles are at most half as far away as the corners; the factor is for rounding.
                    let most = 1.001 * (part.distance + 0.5 * part.size);
                    open.extend(quarters.map(|quarter| (quarter, most)));
                }
            }
        }
    }

    /// The distances of a triangle of a surface. The distance from the triangle of the mesh that is nearest to the
    /// middle is a convex function, so that it is largest at a corner. The middle is less than `most` away, m.
    fn part(&self, triangle: &Triangle, most: f64) -> SurfacePart {
        let middle = triangle.iter().sum::<Vector3<f64>>() / 3.0;
        let size = triangle.iter().fold(0.0_f64, |most, p| most.max((p - middle).norm()));
        let from = coordinates(&middle);
        let within = self.shape.project_local_point_and_get_location_with_max_dist(from, false, most);
        let (projection, (nearest, _)) =
            within.unwrap_or_else(|| self.shape.project_local_point_and_get_location(from, false));
        let distance = (projection.point - from).length();
        let nearest = self.shape.triangle(nearest);
        let at_corners = triangle.iter().map(|p| nearest.distance_to_local_point(coordinates(p), false));
        let most = at_corners.fold(0.0, f64::max).min(distance + size);
        SurfacePart { distance, most, size, is_outside: true }
    }

    /// The two parts of a piece with the least volume; `None` if they save too little.
    fn divided(&self, piece: &ConvexPiece, own: &[usize]) -> Result<Option<[Own; 2]>> {
        let [lower, upper] = bounds(piece.corners.iter());
        let mut best: Option<(f64, [Vec<usize>; 2])> = None;
        for (axis, k) in (0..3).flat_map(|axis| (1..=PLANES).map(move |k| (axis, k))) {
            let share = k as f64 / (PLANES + 1) as f64;
            let at = lower[axis] + share * (upper[axis] - lower[axis]);
            // A triangle across the plane is below it, or above.
            let heights = |i: usize| self.corners_of(i).map(|p| p[axis] - at);
            let rules: [fn([f64; 3]) -> bool; 2] =
                [|heights| heights.into_iter().any(|h| h < 0.0), |heights| heights.into_iter().all(|h| h < 0.0)];
            for is_below in rules {
                let (below, above): (Vec<usize>, Vec<usize>) = own.iter().partition(|i| is_below(heights(**i)));
                if below.is_empty() || above.is_empty() {
                    continue;
                }
                let least = best.as_ref().map_or(f64::INFINITY, |(least, _)| *least);
                let (fewer, more) = if below.len() < above.len() { (&below, &above) } else { (&above, &below) };
                let mut volume = self.volume(more)?;
                if volume < least {
                    volume += self.volume(fewer)?;
                }
                if volume < least {
                    best = Some((volume, [below, above]));
                }
            }
        }
        let Some((_, [below, above])) = best else {
            return Ok(None);
        };
        let halves = [(self.hull(&below)?, below), (self.hull(&above)?, above)];
        let volume: f64 = halves.iter().map(|(half, _)| half.volume()).sum();
        Ok((volume < (1.0 - LEAST_SAVED) * piece.volume()).then_some(halves))
    }
}
