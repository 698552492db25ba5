//! Meshes of links, and the convex pieces that contain them.

use crate::Checked;
use crate::arithmetic::UNIT;
use crate::json::{entries, require, three};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The radius about a piece, m, and the distance of a corner of the mesh from it that is accepted: less by more than
/// rounding.
pub(crate) const RADIUS: f64 = 1e-6;
const ACCEPTED: f64 = 0.9e-6;

/// The weight of a corner below which a point is not examined further.
const FAR: f64 = -1e-3;

type Point = [f64; 3];

/// A convex piece: its corners, and triangles of its surface as indices of them.
pub(crate) struct Piece {
    corners: Vec<Point>,
    faces: Vec<[usize; 3]>,
}

impl Piece {
    pub(crate) fn read(value: &Value) -> Checked<Self> {
        let all = |i: usize| value[i].as_array().into_iter().flatten().map(three);
        let corners: Vec<Point> = all(0).collect();
        let faces: Vec<[usize; 3]> = all(1).map(|face| face.map(|i| i as usize)).collect();
        let known = !corners.is_empty() && faces.iter().flatten().all(|i| *i < corners.len());
        require(known, "a piece of a mesh has no corner, or a face without one")?;
        Ok(Self { corners, faces })
    }

    /// The middle of the box of the corners along the axes.
    pub(crate) fn middle(&self) -> Point {
        std::array::from_fn(|i| {
            let all = self.corners.iter().map(|corner| corner[i]);
            0.5 * (all.clone().fold(f64::INFINITY, f64::min) + all.fold(f64::NEG_INFINITY, f64::max))
        })
    }

    /// The corners about a point.
    pub(crate) fn about(&self, middle: Point) -> Vec<Point> {
        self.corners.iter().map(|corner| sub(*corner, middle)).collect()
    }

    /// The radius of a ball about a point that contains the piece and its radius, m.
    pub(crate) fn radius(&self, middle: Point) -> f64 {
        let most = self.about(middle).into_iter().map(|c| dot(c, c)).fold(0.0, f64::max);
        most.sqrt() * (1.0 + 8.0 * UNIT) + RADIUS
    }
}

/// The bytes of the mesh that a URDF calls `name`: a path from its folder, or `package://NAME/PATH`, which is
/// `NAME/PATH` in the folder of the URDF, in one above it or in one of `folders`, or `PATH` in such a folder that is
/// called `NAME`. `None` if there is no such file.
#[must_use]
pub fn find_mesh(name: &str, robot: &Path, folders: &[PathBuf]) -> Option<Vec<u8>> {
    let own = std::path::absolute(robot).ok()?;
    let own = own.parent()?;
    let Some(path) = name.trim().strip_prefix("package://") else {
        return std::fs::read(own.join(name.trim().trim_start_matches("file://"))).ok();
    };
    let (package, path) = path.trim_start_matches('/').split_once('/')?;
    let within = |folder: &Path| {
        let named = folder.ends_with(package).then(|| folder.join(path));
        [Some(folder.join(package).join(path)), named]
    };
    let all = own.ancestors().chain(folders.iter().map(PathBuf::as_path));
    all.flat_map(within).flatten().find_map(|file| std::fs::read(file).ok())
}

/// The corners of the triangles of an STL or OBJ; `None` if the file has another format, or more than is read here.
pub(crate) fn triangles(name: &str, bytes: &[u8]) -> Option<Vec<[Point; 3]>> {
    let name = name.trim().to_ascii_lowercase();
    let text = || std::str::from_utf8(bytes).ok();
    if name.ends_with(".obj") {
        return obj(text()?);
    }
    if !name.ends_with(".stl") {
        return None;
    }
    let count = bytes.get(80..84).and_then(|four| Some(u32::from_le_bytes(four.try_into().ok()?) as usize));
    if let Some(count) = count.filter(|count| bytes.len() == 84 + 50 * count) {
        let at = |i: usize| bytes[i..i + 4].try_into().map_or(f64::NAN, |four| f64::from(f32::from_le_bytes(four)));
        let corner = |i: usize| [at(i), at(i + 4), at(i + 8)];
        return Some((0..count).map(|k| [12, 24, 36].map(|i| corner(84 + 50 * k + i))).collect());
    }
    let mut corners = Vec::new();
    for line in text()?.lines() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("vertex") => corners.push(point(words)?),
            None | Some("solid" | "facet" | "outer" | "endloop" | "endfacet" | "endsolid") => {}
            _ => return None,
        }
    }
    let (all, rest) = corners.as_chunks();
    rest.is_empty().then(|| all.to_vec())
}

fn point<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<Point> {
    let mut next = || words.next()?.parse::<f64>().ok().filter(|x| x.is_finite());
    Some([next()?, next()?, next()?])
}

fn obj(text: &str) -> Option<Vec<[Point; 3]>> {
    let (mut corners, mut all): (Vec<Point>, _) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => corners.push(point(words)?),
            Some("f") => {
                let corner = |word: &str| {
                    let i: i64 = word.split('/').next()?.parse().ok()?;
                    let i = if i < 0 { corners.len() as i64 + i } else { i - 1 };
                    corners.get(usize::try_from(i).ok()?).copied()
                };
                let own: Vec<Point> = words.map(corner).collect::<Option<_>>()?;
                all.extend((2..own.len()).map(|i| [own[0], own[i - 1], own[i]]));
            }
            None | Some("vn" | "vt" | "vp" | "o" | "g" | "s" | "usemtl" | "mtllib" | "l" | "p") => {}
            Some(word) if word.starts_with('#') => {}
            _ => return None,
        }
    }
    Some(all)
}

fn sub(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] - b[i])
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A tetrahedron of the average of the corners of a piece and the corners of a face: the average, the ways to the
/// corners, and for each of them the vector whose product with a way is its weight.
struct Tetrahedron {
    ways: [Point; 3],
    weights: [Point; 3],
}

/// A piece as averages of its corners.
struct Inside {
    middle: Point,
    all: Vec<Tetrahedron>,
    known: BTreeMap<[u64; 3], bool>,
    last: usize,
}

impl Inside {
    fn new(piece: &Piece) -> Self {
        let count = piece.corners.len() as f64;
        let middle = std::array::from_fn(|i| piece.corners.iter().map(|c| c[i]).sum::<f64>() / count);
        let of_face = |face: &[usize; 3]| {
            let ways = face.map(|i| sub(piece.corners[i], middle));
            let [a, b, c] = ways;
            let normals = [cross(b, c), cross(c, a), cross(a, b)];
            let volume = dot(a, normals[0]);
            Tetrahedron { ways, weights: normals.map(|n| n.map(|x| x / volume)) }
        };
        let known = piece.corners.iter().map(|corner| (corner.map(f64::to_bits), true)).collect();
        Self { middle, all: piece.faces.iter().map(of_face).collect(), known, last: 0 }
    }

    /// True if a point is within [`ACCEPTED`] of an average of corners: of the middle and those of a face, with
    /// weights that are not negative and at most one together.
    fn contains(&mut self, p: Point) -> bool {
        let bits = p.map(f64::to_bits);
        if let Some(known) = self.known.get(&bits) {
            return *known;
        }
        let way = sub(p, self.middle);
        let is_within = |face: &Tetrahedron| {
            let weights = face.weights.map(|w| dot(w, way));
            // Far from this tetrahedron, as the point is from most.
            if weights.iter().any(|weight| *weight < FAR) {
                return false;
            }
            let weights = weights.map(|weight| weight.max(0.0));
            let scale = weights.iter().sum::<f64>().max(1.0);
            let average: Point = std::array::from_fn(|i| (0..3).map(|k| weights[k] / scale * face.ways[k][i]).sum());
            let off = sub(way, average);
            dot(off, off).sqrt() <= ACCEPTED - 64.0 * UNIT * dot(way, way).sqrt()
        };
        let last = self.all.get(self.last).is_some_and(is_within);
        let found = if last { Some(self.last) } else { self.all.iter().position(is_within) };
        self.last = found.unwrap_or(self.last);
        self.known.insert(bits, found.is_some());
        found.is_some()
    }
}

/// True if each triangle of a mesh, with its axes scaled, is in one of these pieces.
pub(crate) fn are_covered(triangles: &[[Point; 3]], scale: Point, pieces: &[Piece]) -> bool {
    let mut pieces: Vec<Inside> = pieces.iter().map(Inside::new).collect();
    triangles.iter().all(|triangle| {
        let corners = triangle.map(|p| std::array::from_fn(|i| p[i] * scale[i]));
        pieces.iter_mut().any(|piece| corners.into_iter().all(|p| piece.contains(p)))
    })
}

/// The pieces of each mesh that a certificate lists.
pub(crate) fn pieces(certificate: &Value) -> Checked<Vec<Vec<Piece>>> {
    let of_mesh = |all: &Value| all.as_array().into_iter().flatten().map(Piece::read).collect();
    entries(certificate, "pieces").iter().map(of_mesh).collect()
}
