//! Triangle meshes, and balls that cover them.

use super::cells::{Cells, Patch, bounds};
use super::cover::{check, refused};
use super::greedy::fewest;
use super::tree::Tree;
use super::{Cover, Sphere};
use crate::error::Result;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// The corners of a triangle, in m.
pub type Triangle = [Vector3<f64>; 3];

/// The width of the cells relative to the excess. Up to $1 / \sqrt 3$ a ball of the excess as radius about a point of a
/// cell contains the cell.
const WIDTH: f64 = 0.57;

/// The distance of candidates that are as good as one, relative to their radius: with less than this the number of
/// balls is the same.
const ALIKE: f64 = 0.3;

/// The distance within which a cell needs no ball of its own, relative to the radius of that of another. With 0.1 the
/// meshes of a UR5 need a quarter fewer balls, and more than twice the time.
const NEARBY: f64 = 0.25;

/// The number of points of a surface by which a ball is shrunk before all triangles near it are examined.
const SOME: usize = 500;

/// The share of its radius by which a ball may contain the surface: rounding.
const ROUNDING: f64 = 1e-9;

/// Covers triangles and the volume that they enclose by balls, no point of which is further than `excess` in m from
/// these.
///
/// Space is divided into cubes somewhat wider than `excess / 2`. Those that no path over cubes without a surface
/// connects with the outside are within: a mesh encloses a volume even if it has gaps narrower than a cube, and a space
/// that is only reached through such gaps, such as the inside of a housing, is part of the volume. The surface that
/// remains is cut along the cubes into patches.
///
/// Candidates are the balls within that touch the surface at two points, with their radius increased by the excess:
/// each other ball within, increased likewise, is contained in one of them. They are chosen by the number of patches
/// that they contain and no other does, a greedy set cover. Patches that none contains, such as those of a sheet, get
/// balls about points of theirs with the excess as radius; cubes within that none contains, the candidate from their
/// middle. All patches and cubes are therefore contained in balls. Cost about O(area / excess^2) logarithms.
///
/// # Errors
/// There is no triangle, `excess` is not positive and finite, a coordinate is not finite, or more than 1e8 cubes are
/// needed.
pub fn cover_triangles(triangles: &[Triangle], excess: f64) -> Result<Cover> {
    check(&[("excess", excess)])?;
    let mut coordinates = triangles.iter().flatten().flat_map(|p| p.iter());
    if triangles.is_empty() {
        return refused("triangles", "there are none".to_owned());
    }
    if !coordinates.all(|x| x.is_finite()) {
        return refused("triangles", "a coordinate is not a finite number".to_owned());
    }
    let cells = Cells::new(triangles, WIDTH * excess)?;
    let surface = Surface::new(triangles, cells.outer_patches());
    let mut candidates = BTreeMap::new();
    let mut seen = vec![false; cells.count()];
    for cell in 0..cells.count() {
        let Some(seed) = cells.within(cell).filter(|_| !seen[cell] && cells.is_beside(cell)) else {
            continue;
        };
        let ball = surface.largest_ball(&seed, excess);
        for near in cells.about(&seed, NEARBY * ball.radius) {
            seen[near] = true;
        }
        let level = (ball.radius / excess).log2().floor();
        let near = WIDTH.max(ALIKE * level.exp2()) * excess;
        let place = (ball.centre / near).map(|x| x.round() as i64);
        let of_place = candidates.entry((level as i64, <[i64; 3]>::from(place)));
        let known = of_place.or_insert(ball);
        if known.radius < ball.radius {
            *known = ball;
        }
    }
    let candidates: Vec<Sphere> = candidates.into_values().collect();
    let mut balls = surface.chosen(&candidates, excess);
    // A cell is most often in the same ball as the one before, or else in a large one.
    balls.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    let reach = 0.5 * 3.0_f64.sqrt() * WIDTH * excess;
    let mut last = 0;
    for middle in (0..cells.count()).filter_map(|cell| cells.within(cell)) {
        let contains = |ball: &Sphere| (middle - ball.centre).norm() + reach <= ball.radius;
        if !balls.get(last).is_some_and(contains) {
            last = balls.iter().position(contains).unwrap_or(balls.len());
            if last == balls.len() {
                balls.push(surface.largest_ball(&middle, excess));
            }
        }
    }
    Ok(Cover { balls, excess })
}

/// The outer surface of a mesh.
struct Surface<'a> {
    triangles: &'a [Triangle],
    patches: Vec<Patch>,
    boxes: Vec<[Vector3<f64>; 2]>,
    tree: Tree,
    /// Some points of the surface, and the length of the diagonal of its bounding box.
    some: Vec<Vector3<f64>>,
    size: f64,
}

impl<'a> Surface<'a> {
    fn new(triangles: &'a [Triangle], patches: Vec<Patch>) -> Self {
        let boxes: Vec<_> = patches.iter().map(|p| bounds(p.corners.iter())).collect();
        let [lower, upper] = bounds(boxes.iter().flatten());
        let every = patches.len().div_ceil(SOME);
        Self {
            triangles,
            tree: Tree::new(&boxes),
            some: patches.iter().step_by(every).map(|p| p.corners[0]).collect(),
            size: (upper - lower).norm(),
            boxes,
            patches,
        }
    }

    /// The largest ball that contains no point of the surface in its interior and touches it where it is nearest to
    /// `seed`, on the side of `seed`, with its radius increased by `excess`.
    fn largest_ball(&self, seed: &Vector3<f64>, excess: f64) -> Sphere {
        let mut near = self.some.iter().map(|p| (*p, (p - seed).norm()));
        let first = near.next().unwrap_or((*seed, self.size));
        let (mut foot, mut least) = near.fold(first, |a, b| if b.1 < a.1 { b } else { a });
        self.tree.visit((*seed, least), |i| {
            for triangle in &self.patches[i].triangles {
                let point = nearest_point(&self.triangles[*triangle], seed);
                let distance = (point - seed).norm();
                if distance < least {
                    (foot, least) = (point, distance);
                }
            }
            (*seed, least)
        });
        let normal = (seed - foot) / least;
        let mut radius = self.size;
        // The ball that touches a point, or the same if that is not in it.
        let touching = |radius: f64, point: &Vector3<f64>| {
            let off = point - foot;
            let along = off.dot(&normal).max(f64::MIN_POSITIVE);
            (0.5 * off.norm_squared() / along).clamp(least, radius)
        };
        for point in &self.some {
            radius = touching(radius, point);
        }
        self.tree.visit((foot + normal * radius, radius), |i| {
            for triangle in &self.patches[i].triangles {
                loop {
                    let centre = foot + normal * radius;
                    let point = nearest_point(&self.triangles[*triangle], &centre);
                    if (point - centre).norm() >= radius * (1.0 - ROUNDING) || radius <= least {
                        break;
                    }
                    radius = touching(radius, &point);
                }
            }
            (foot + normal * radius, radius)
        });
        Sphere { centre: foot + normal * radius, radius: radius + excess }
    }

    /// The candidates that together contain all patches, with further balls about the patches that no candidate
    /// contains.
    fn chosen(&self, candidates: &[Sphere], excess: f64) -> Vec<Sphere> {
        let mut left = vec![true; self.patches.len()];
        let mut chosen = self.some(candidates, &mut left);
        let about = |(i, [lower, upper]): (usize, &[Vector3<f64>; 2])| Sphere {
            centre: {
                let triangle = &self.triangles[self.patches[i].triangles[0]];
                nearest_point(triangle, &((lower + upper) * 0.5))
            },
            radius: excess,
        };
        let remaining = self.boxes.iter().enumerate().filter(|(i, _)| left[*i]);
        let about: Vec<_> = remaining.map(about).collect();
        chosen.extend(self.some(&about, &mut left));
        chosen
    }

    /// As few candidates as a greedy choice finds that contain all patches that are left and can be contained, which
    /// are left no longer.
    fn some(&self, candidates: &[Sphere], left: &mut [bool]) -> Vec<Sphere> {
        let contained: Vec<_> = candidates.iter().map(|b| self.contained(b, left)).collect();
        for i in contained.iter().flatten() {
            left[*i] = false;
        }
        let chosen = fewest(&contained, left.len());
        chosen.into_iter().map(|i| candidates[i]).collect()
    }

    /// The patches in a ball among those that are left.
    fn contained(&self, ball: &Sphere, left: &[bool]) -> Vec<usize> {
        let mut found = Vec::new();
        let around = (ball.centre, ball.radius);
        let square = ball.radius * ball.radius;
        self.tree.visit(around, |i| {
            let is_in = |p: &Vector3<f64>| (p - ball.centre).norm_squared() <= square;
            let [lower, upper] = &self.boxes[i];
            let furthest = (ball.centre - lower).sup(&(upper - ball.centre));
            if left[i] && (furthest.norm_squared() <= square || self.patches[i].corners.iter().all(is_in)) {
                found.push(i);
            }
            around
        });
        found
    }
}

/// The point of a triangle that is nearest to `p`.
fn nearest_point([a, b, c]: &Triangle, p: &Vector3<f64>) -> Vector3<f64> {
    let (u, v, w) = (b - a, c - a, p - a);
    let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
    let (wu, wv) = (w.dot(&u), w.dot(&v));
    let area = uu * vv - uv * uv;
    let (s, t) = (vv * wu - uv * wv, uu * wv - uv * wu);
    if s >= 0.0 && t >= 0.0 && s + t <= area && area > 0.0 {
        return a + u * (s / area) + v * (t / area);
    }
    let on_edge = |from: &Vector3<f64>, to: &Vector3<f64>| {
        let along = to - from;
        let share = (p - from).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        from + along * share.clamp(0.0, 1.0)
    };
    let edges = [on_edge(a, b), on_edge(b, c), on_edge(c, a)];
    let nearest = edges.into_iter();
    let nearest = nearest.min_by(|x, y| (x - p).norm_squared().total_cmp(&(y - p).norm_squared()));
    nearest.unwrap_or(*a)
}
