//! The cells of a grid about a mesh: those that its surface passes through, those outside, and those within.

use super::Triangle;
use super::cover::refused;
use crate::error::{Result, plain};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// The largest number of cells: a byte each.
const MAX_CELLS: f64 = 1e8;

/// The part of a surface in one cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    /// The corners of the polygons of which it consists.
    pub corners: Vec<Vector3<f64>>,
    /// The indices of the triangles to which these belong, ascending.
    pub triangles: Vec<usize>,
}

/// A grid of cubes about a mesh.
pub(super) struct Cells {
    lower: Vector3<f64>,
    width: f64,
    counts: [usize; 3],
    kinds: Vec<Kind>,
    /// The patches of the cells with a surface, by the index of the cell.
    patches: BTreeMap<usize, Patch>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Not reached from outside.
    Within,
    Surface,
    Outside,
}

impl Cells {
    /// Divides the space about triangles, at least one, into cells of this width, and finds those that are outside:
    /// from which a path over common faces leads away without a cell that the surface passes through.
    ///
    /// # Errors
    /// There are more than 1e8 cells.
    pub fn new(triangles: &[Triangle], width: f64) -> Result<Self> {
        let [lower, upper] = bounds(triangles.iter().flatten());
        // Faces along the axes are in the middle of cells, and a layer of empty cells is all around.
        let lower = lower.map(|x| x - 1.5 * width);
        let counts = ((upper - lower) / width).map(|x| x.floor() + 2.0);
        if counts.product() > MAX_CELLS {
            let [x, y, z] = [0, 1, 2].map(|i| plain(upper[i] - lower[i]));
            let condition = format!(
                "it is too small for a shape of {x} by {y} by {z} m, which would be cut into more than {MAX_CELLS} \
                 cells"
            );
            return refused("excess", condition);
        }
        let counts = counts.map(|x| x as usize).into();
        let mut cells =
            Self { lower, width, counts, kinds: vec![Kind::Within; counts.iter().product()], patches: BTreeMap::new() };
        for (i, triangle) in triangles.iter().enumerate() {
            cells.divide(triangle.to_vec(), 0, [0; 3], i);
        }
        for cell in cells.patches.keys() {
            cells.kinds[*cell] = Kind::Surface;
        }
        cells.flood();
        Ok(cells)
    }

    /// Cuts a polygon at the planes between the cells, one axis after the other, and adds the pieces to their cells.
    fn divide(&mut self, mut polygon: Vec<Vector3<f64>>, axis: usize, mut cell: [usize; 3], i: usize) {
        if axis == 3 {
            let patch = self.patches.entry(self.index(cell)).or_default();
            patch.corners.extend(polygon);
            if patch.triangles.last() != Some(&i) {
                patch.triangles.push(i);
            }
            return;
        }
        let place = |p: &Vector3<f64>| (p[axis] - self.lower[axis]) / self.width;
        let places = polygon.iter().map(place);
        let [first, last] =
            [places.clone().fold(f64::INFINITY, f64::min) as usize, places.fold(0.0, f64::max) as usize];
        for k in first..last {
            let plane = self.lower[axis] + (k + 1) as f64 * self.width;
            let [below, above] = cut(&polygon, axis, plane);
            cell[axis] = k;
            if !below.is_empty() {
                self.divide(below, axis + 1, cell, i);
            }
            polygon = above;
        }
        cell[axis] = last;
        if !polygon.is_empty() {
            self.divide(polygon, axis + 1, cell, i);
        }
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.counts[1] + y) * self.counts[2] + z
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let [_, y, z] = self.counts;
        [index / (y * z), index / z % y, index % z]
    }

    /// Marks the cells outside, from a corner of the grid on.
    fn flood(&mut self) {
        let mut open = vec![0];
        self.kinds[0] = Kind::Outside;
        while let Some(index) = open.pop() {
            for next in self.neighbours(index) {
                if self.kinds[next] == Kind::Within {
                    self.kinds[next] = Kind::Outside;
                    open.push(next);
                }
            }
        }
    }

    /// The cells with a common face.
    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let [_, y, z] = self.counts;
        let (place, counts, strides) = (self.place(index), self.counts, [y * z, z, 1]);
        (0..3).flat_map(move |axis| {
            let before = (place[axis] > 0).then(|| index - strides[axis]);
            let after = (place[axis] + 1 < counts[axis]).then(|| index + strides[axis]);
            before.into_iter().chain(after)
        })
    }

    /// The patches with a cell outside among the up to 26 about theirs: the outer surface.
    pub fn outer_patches(&self) -> Vec<Patch> {
        let outer = self.patches.iter().filter(|(index, _)| {
            let at = self.place(**index);
            let range = |axis: usize| at[axis] - 1..at[axis] + 2;
            let is_outside = |x, y, z| self.kinds[self.index([x, y, z])] == Kind::Outside;
            range(0).any(|x| range(1).any(|y| range(2).any(|z| is_outside(x, y, z))))
        });
        outer.map(|(_, patch)| patch.clone()).collect()
    }

    /// The cells that are not further than `reach` from a point along any axis.
    pub fn about(&self, point: &Vector3<f64>, reach: f64) -> impl Iterator<Item = usize> + use<> {
        let range = |axis: usize| {
            let [first, last] = [-reach, reach].map(|side| {
                let place = (point[axis] + side - self.lower[axis]) / self.width;
                (place as usize).min(self.counts[axis] - 1)
            });
            first..last + 1
        };
        let ([xs, ys, zs], [_, y, z]) = ([0, 1, 2].map(range), self.counts);
        xs.flat_map(move |i| {
            let zs = zs.clone();
            (ys.clone()).flat_map(move |j| zs.clone().map(move |k| (i * y + j) * z + k))
        })
    }

    fn middle(&self, place: [usize; 3]) -> Vector3<f64> {
        self.lower + Vector3::from(place).map(|k| (k as f64 + 0.5) * self.width)
    }

    /// Returns true if a cell has a common face with one that the surface passes through.
    pub fn is_beside(&self, index: usize) -> bool {
        let is_surface = |index: usize| self.kinds[index] == Kind::Surface;
        self.neighbours(index).any(is_surface)
    }

    /// The number of cells.
    pub fn count(&self) -> usize {
        self.kinds.len()
    }

    /// The middle of a cell within.
    pub fn within(&self, index: usize) -> Option<Vector3<f64>> {
        (self.kinds[index] == Kind::Within).then(|| self.middle(self.place(index)))
    }
}

/// The smallest and the largest coordinates of points.
pub(super) fn bounds<'a>(points: impl Iterator<Item = &'a Vector3<f64>>) -> [Vector3<f64>; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
    points.fold(none, |[lower, upper], p| [lower.inf(p), upper.sup(p)])
}

/// The parts of a convex polygon below and above a plane across an axis.
fn cut(polygon: &[Vector3<f64>], axis: usize, plane: f64) -> [Vec<Vector3<f64>>; 2] {
    let mut parts = [Vec::new(), Vec::new()];
    for (i, p) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()];
        let (here, there) = (p[axis] - plane, next[axis] - plane);
        if here <= 0.0 {
            parts[0].push(*p);
        }
        if here >= 0.0 {
            parts[1].push(*p);
        }
        if here * there < 0.0 {
            let mut crossing = p + (next - p) * (here / (here - there));
            crossing[axis] = plane;
            parts[0].push(crossing);
            parts[1].push(crossing);
        }
    }
    parts
}
