//! Simplified meshes: corners on a grid that is as fine as the number of triangles allows.

use super::encode::{of_u16, of_u32};
use aghf::geometry::Triangle;
use nalgebra::Vector3;
use serde::Serialize;
use std::collections::HashMap;

/// The largest number of triangles of a mesh.
const MAX_TRIANGLES: usize = 6000;
/// The finest and the coarsest number of cells along the longest edge of a mesh.
const FINEST: f64 = 65535.0;
const COARSEST: f64 = 16.0;

/// A mesh for the page: corners are `low + step * xyz`.
#[derive(Clone, Serialize)]
pub(super) struct MeshData {
    low: [f64; 3],
    step: f64,
    /// Three 16-bit numbers for each corner.
    corners: String,
    /// Three 32-bit numbers for each triangle.
    triangles: String,
}

/// The meshes of a robot, without duplicates.
#[derive(Default)]
pub(super) struct Meshes {
    numbers: HashMap<String, usize>,
    data: Vec<MeshData>,
}

impl Meshes {
    /// The index of a mesh that was added before.
    pub fn find(&self, key: &str) -> Option<usize> {
        self.numbers.get(key).copied()
    }

    /// Adds a mesh and returns its index.
    pub fn add(&mut self, key: String, triangles: &[Triangle]) -> usize {
        let number = self.data.len();
        self.data.push(small(triangles));
        self.numbers.insert(key, number);
        number
    }

    pub fn data(self) -> Vec<MeshData> {
        self.data
    }
}

/// Merges the corners in each cell of a grid, on the finest grid that leaves few enough triangles.
fn small(triangles: &[Triangle]) -> MeshData {
    let corners = || triangles.iter().flatten();
    let low = corners().fold(Vector3::repeat(f64::INFINITY), |m, p| m.inf(p));
    let high = corners().fold(Vector3::repeat(f64::NEG_INFINITY), |m, p| m.sup(p));
    let longest = (high - low).max().max(f64::MIN_POSITIVE);
    let mut cells = FINEST;
    loop {
        let step = longest / cells;
        let (corners, indices) = merged(triangles, &low, step);
        if indices.len() <= 3 * MAX_TRIANGLES || cells <= COARSEST {
            return MeshData { low: low.into(), step, corners: of_u16(&corners), triangles: of_u32(&indices) };
        }
        // The number of triangles of a surface is about the square of the number of cells, but unknown at the finest
        // grid.
        cells = if cells == FINEST { 512.0 } else { 0.8 * cells };
    }
}

fn merged(triangles: &[Triangle], low: &Vector3<f64>, step: f64) -> (Vec<u16>, Vec<u32>) {
    let mut numbers: HashMap<[u16; 3], u32> = HashMap::new();
    let (mut corners, mut indices) = (Vec::new(), Vec::new());
    for triangle in triangles {
        let cell = triangle.map(|p| ((p - low) / step).map(|x| x.round() as u16));
        let [a, b, c] = cell;
        if a == b || b == c || c == a {
            continue;
        }
        for corner in cell {
            let corner: [u16; 3] = corner.into();
            let next = numbers.len() as u32;
            let number = *numbers.entry(corner).or_insert_with(|| {
                corners.extend(corner);
                next
            });
            indices.push(number);
        }
    }
    (corners, indices)
}
