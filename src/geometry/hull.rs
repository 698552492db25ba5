//! Convex hulls of points.

use crate::error::{Error, Result};
use nalgebra::Vector3;

/// The distance beyond a face within which a point counts as on it, relative to the size of the set: rounding.
const ROUNDING: f64 = 1e-12;

/// The thickness relative to the size below which a set of points counts as flat.
const FLAT: f64 = 1e-9;

/// The thickness of the hull of a plane set of points, relative to its size, and that of a single point, m.
const THICKNESS: f64 = 1e-4;
const POINT: f64 = 1e-6;

/// The radius about the hulls of [`ConvexPiece`]s within which the corners of a mesh are, m: more than their rounding
/// in the precision of its file.
pub const PIECE_RADIUS: f64 = 1e-6;

/// The corners of a triangle, m.
pub type Triangle = [Vector3<f64>; 3];

/// The hull of points: all of their averages.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexPiece {
    /// The corners, m.
    pub corners: Vec<Vector3<f64>>,
    /// The triangles of its surface, as indices of corners, in positive orientation seen from outside.
    pub faces: Vec<[usize; 3]>,
}

impl ConvexPiece {
    /// The hull of the given points; if they are in a plane, one of some thickness that contains them.
    ///
    /// # Errors
    /// There is no point, or a coordinate is not finite.
    pub fn hull(points: &[Vector3<f64>]) -> Result<Self> {
        if points.is_empty() || !points.iter().all(|p| p.iter().all(|x| x.is_finite())) {
            return refused("points", "there are none, or a coordinate is not a finite number".to_owned());
        }
        if let Some((corners, faces)) = quickhull(points) {
            return Ok(Self { corners: corners.into_iter().map(|i| points[i]).collect(), faces });
        }
        let [lower, upper] = bounds(points.iter());
        let thickness = THICKNESS * (upper - lower).norm() + POINT;
        let about = |p: &Vector3<f64>| {
            let p = *p;
            (0..3).flat_map(move |i| [-thickness, thickness].map(|off| p + Vector3::ith(i, off)))
        };
        let thick: Vec<_> = points.iter().flat_map(about).collect();
        match quickhull(&thick) {
            Some((corners, faces)) => Ok(Self { corners: corners.into_iter().map(|i| thick[i]).collect(), faces }),
            None => refused("points", "they are too large for a hull".to_owned()),
        }
    }

    /// The triangles of the surface.
    pub fn triangles(&self) -> impl Iterator<Item = Triangle> {
        self.faces.iter().map(|face| face.map(|i| self.corners[i]))
    }

    /// The enclosed volume, m^3.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let from = self.corners[0];
        let six = |[a, b, c]: Triangle| (a - from).dot(&(b - from).cross(&(c - from)));
        self.triangles().map(six).sum::<f64>() / 6.0
    }
}

/// A triangle of a hull under construction.
struct Face {
    corners: [usize; 3],
    normal: Vector3<f64>,
    /// The faces across the edges from each corner to the next.
    neighbours: [usize; 3],
    /// The points beyond it that are assigned to it, and the furthest of them.
    beyond: Vec<usize>,
    furthest: Option<(usize, f64)>,
    is_removed: bool,
}

/// The corners of the hull of points, as indices of these, and its faces as indices of the corners; `None` if the
/// points are in a plane. By quickhull: of the points beyond a face the furthest one becomes a corner, and the faces
/// that it sees are replaced by those between it and their horizon. A point for which rounding makes the horizon no
/// single loop becomes a corner without faces. Cost about O(n log n).
fn quickhull(points: &[Vector3<f64>]) -> Option<(Vec<usize>, Vec<[usize; 3]>)> {
    let mut hull = Hull::new(points)?;
    let mut at = 0;
    while at < hull.faces.len() {
        let face = &hull.faces[at];
        match face.furthest.filter(|_| !face.is_removed) {
            Some((point, _)) => hull.add(at, point),
            None => at += 1,
        }
    }
    let kept: Vec<_> = hull.faces.iter().filter(|face| !face.is_removed).map(|face| face.corners).collect();
    let mut corners: Vec<usize> = kept.iter().flatten().copied().chain(hull.alone).collect();
    corners.sort_unstable();
    corners.dedup();
    let mut number = vec![0; points.len()];
    corners.iter().enumerate().for_each(|(k, i)| number[*i] = k);
    let faces = kept.into_iter().map(|face| face.map(|i| number[i])).collect();
    Some((corners, faces))
}

struct Hull<'a> {
    points: &'a [Vector3<f64>],
    faces: Vec<Face>,
    rounding: f64,
    /// Corners without faces.
    alone: Vec<usize>,
    /// Per point the new faces with an edge of the horizon from it, and to it.
    along: Vec<[Option<usize>; 2]>,
}

impl<'a> Hull<'a> {
    /// A tetrahedron of extreme points.
    fn new(points: &'a [Vector3<f64>]) -> Option<Self> {
        let furthest = |height: &dyn Fn(&Vector3<f64>) -> f64| {
            let all = points.iter().map(height).enumerate();
            all.max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let (a, _) = furthest(&|p| p.x)?;
        let (b, size) = furthest(&|p| (p - points[a]).norm())?;
        let along = (points[b] - points[a]) / size;
        let (c, width) = furthest(&|p| (p - points[a]).cross(&along).norm())?;
        let normal = along.cross(&(points[c] - points[a])).normalize();
        let (d, height) = furthest(&|p| (p - points[a]).dot(&normal).abs())?;
        if !(size > 0.0 && width > FLAT * size && height > FLAT * size) {
            return None;
        }
        // The first face is seen from outside in positive orientation if the fourth corner is below it.
        let is_above = (points[d] - points[a]).dot(&normal) > 0.0;
        let [b, c] = if is_above { [c, b] } else { [b, c] };
        let along = vec![[None; 2]; points.len()];
        let mut hull = Self { points, faces: Vec::new(), rounding: ROUNDING * size, alone: Vec::new(), along };
        for corners in [[a, b, c], [b, a, d], [c, b, d], [a, c, d]] {
            hull.push(corners);
        }
        for (face, neighbours) in [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]].into_iter().enumerate() {
            hull.faces[face].neighbours = neighbours;
        }
        hull.assign((0..points.len()).collect(), 0);
        Some(hull)
    }

    fn push(&mut self, corners: [usize; 3]) {
        let [a, b, c] = corners.map(|i| self.points[i]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
        self.faces.push(Face {
            corners,
            normal,
            neighbours: [0; 3],
            beyond: Vec::new(),
            furthest: None,
            is_removed: false,
        });
    }

    /// The distance of a point beyond a face.
    fn height(&self, face: usize, point: usize) -> f64 {
        let face = &self.faces[face];
        face.normal.dot(&(self.points[point] - self.points[face.corners[0]]))
    }

    /// Assigns points to the face from `first` on that they are furthest beyond, if they are beyond one.
    fn assign(&mut self, points: Vec<usize>, first: usize) {
        for point in points {
            let heights = (first..self.faces.len()).map(|face| (face, self.height(face, point)));
            let best = heights.max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((face, height)) = best.filter(|(_, height)| *height > self.rounding) {
                let face = &mut self.faces[face];
                face.beyond.push(point);
                if face.furthest.is_none_or(|(_, known)| height > known) {
                    face.furthest = Some((point, height));
                }
            }
        }
    }

    /// Adds a corner that is beyond a face.
    fn add(&mut self, face: usize, point: usize) {
        let (mut seen, mut open, mut horizon) = (vec![face], vec![face], Vec::new());
        self.faces[face].is_removed = true;
        while let Some(at) = open.pop() {
            for k in 0..3 {
                let next = self.faces[at].neighbours[k];
                if self.faces[next].is_removed {
                    continue;
                }
                if self.height(next, point) > self.rounding {
                    self.faces[next].is_removed = true;
                    seen.push(next);
                    open.push(next);
                } else {
                    let corners = self.faces[at].corners;
                    horizon.push(([corners[k], corners[(k + 1) % 3]], next));
                }
            }
        }
        let first = self.faces.len();
        let mut is_loop = true;
        for (k, ([from, to], _)) in horizon.iter().enumerate() {
            is_loop &= self.along[*from][0].replace(first + k).is_none();
            is_loop &= self.along[*to][1].replace(first + k).is_none();
        }
        is_loop &= horizon.iter().all(|([_, to], _)| self.along[*to][0].is_some());
        for (k, ([from, to], beyond)) in horizon.iter().enumerate().filter(|_| is_loop) {
            self.push([*from, *to, point]);
            let [next, before] = [self.along[*to][0], self.along[*from][1]];
            self.faces[first + k].neighbours = [*beyond, next.unwrap_or(first), before.unwrap_or(first)];
            let beyond = &mut self.faces[*beyond];
            let edge = (0..3).find(|e| beyond.corners[*e] == *to && beyond.corners[(e + 1) % 3] == *from);
            edge.into_iter().for_each(|edge| beyond.neighbours[edge] = first + k);
        }
        for ([from, to], _) in &horizon {
            (self.along[*from], self.along[*to]) = ([None; 2], [None; 2]);
        }
        if !is_loop {
            seen.into_iter().for_each(|face| self.faces[face].is_removed = false);
            self.alone.push(point);
            self.drop(face, point);
            return;
        }
        let points = seen.into_iter().flat_map(|face| std::mem::take(&mut self.faces[face].beyond));
        let points = points.filter(|other| *other != point).collect();
        self.assign(points, first);
    }

    /// Removes a point from those beyond a face.
    fn drop(&mut self, face: usize, point: usize) {
        self.faces[face].beyond.retain(|other| *other != point);
        let heights = self.faces[face].beyond.iter().map(|other| (*other, self.height(face, *other)));
        let furthest = heights.max_by(|a, b| a.1.total_cmp(&b.1));
        self.faces[face].furthest = furthest;
    }
}

/// The smallest and the largest coordinates of points.
pub(super) fn bounds<'a>(points: impl Iterator<Item = &'a Vector3<f64>>) -> [Vector3<f64>; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
    points.fold(none, |[lower, upper], p| [lower.inf(p), upper.sup(p)])
}

/// The error of input without a file.
pub(super) fn refused<T>(element: &str, condition: String) -> Result<T> {
    Err(Error::input("convex hull", element, condition))
}
