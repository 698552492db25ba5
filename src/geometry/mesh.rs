//! Triangle meshes, and balls that cover them.

use super::cover::{check, check_number};
use super::{Cover, Sphere};
use crate::error::{Error, Result, plain};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// The corners of a triangle, in m.
pub type Triangle = [Vector3<f64>; 3];

/// The largest coordinate in units of the spacing: up to it, halving an edge is not affected by rounding.
const FURTHEST: f64 = 1e12;

/// Covers the triangles by balls, but not a volume that they may enclose. Triangles are halved until no edge is longer
/// than `spacing`; those with their middles in one cell of a grid of that width share a ball about their bounding box.
/// Each ball contains corners of triangles, so that no point of it is further from the surface than its radius plus the
/// distance from its centre to the nearest corner: the excess, which is less than 4.1 times `spacing`. Cost O(area /
/// spacing^2).
///
/// # Errors
/// `spacing` is not positive and finite, a coordinate is not finite or above 1e12 times `spacing`, or more than 1e5
/// balls are needed.
pub fn cover_triangles(triangles: &[Triangle], spacing: f64) -> Result<Cover> {
    check(spacing, &[])?;
    let coordinates = triangles.iter().flatten().flat_map(|p| p.iter());
    let refuse = |condition: String| Err(Error::input("cover by balls", "triangles", condition));
    // Not by the largest, which is blind to what is not a number.
    if !coordinates.clone().all(|x| x.is_finite()) {
        return refuse("a coordinate is not a finite number".to_owned());
    }
    let largest = coordinates.fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest > FURTHEST * spacing {
        let [largest, spacing] = [largest, spacing].map(plain);
        let condition = format!(
            "a coordinate is {largest} m, which rounding moves by more than is halved at a spacing of {spacing} m"
        );
        return refuse(condition);
    }
    let mut cells: BTreeMap<[i64; 3], Vec<Vector3<f64>>> = BTreeMap::new();
    let mut pending = triangles.to_vec();
    while let Some([a, b, c]) = pending.pop() {
        let (ab, bc, ca) = ((a - b).norm(), (b - c).norm(), (c - a).norm());
        let longest = ab.max(bc).max(ca);
        if longest > spacing {
            // Turned so that the longest edge comes first.
            let [a, b, c] = match () {
                () if longest == ab => [a, b, c],
                () if longest == bc => [b, c, a],
                () => [c, a, b],
            };
            let middle = (a + b) * 0.5;
            pending.extend([[a, middle, c], [middle, b, c]]);
            continue;
        }
        // The cast saturates.
        let cell = ((a + b + c) / (3.0 * spacing)).map(|x| x.floor() as i64);
        cells.entry(cell.into()).or_default().extend([a, b, c]);
        check_number(cells.len() as f64, spacing)?;
    }
    let mut cover = Cover {
        balls: Vec::with_capacity(cells.len()),
        excess: 0.0,
    };
    for corners in cells.values() {
        let lower = corners.iter().fold(corners[0], |m, p| m.inf(p));
        let upper = corners.iter().fold(corners[0], |m, p| m.sup(p));
        let centre = (lower + upper) * 0.5;
        let distances = || corners.iter().map(|p| (p - centre).norm());
        let radius = distances().fold(0.0, f64::max);
        let nearest = distances().fold(f64::INFINITY, f64::min);
        cover.balls.push(Sphere { centre, radius });
        cover.excess = cover.excess.max(radius + nearest);
    }
    Ok(cover)
}
