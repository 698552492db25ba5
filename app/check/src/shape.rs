//! Shapes of links, loads and obstacles.

use crate::Checked;
use crate::arithmetic::{Tm, UNIT, Vector, apply, dot, transpose};
use crate::json::{number_or, three};
use crate::robot::{Pose, child, scalar, triple};
use roxmltree::Node;
use serde_json::Value;

/// A sphere, a box, a cylinder, a capsule, a half-space or a piece of a mesh: its placement and its radius, half
/// lengths of edges, or radius and half length; of a piece the radius of a ball about its centre.
#[derive(Clone, Copy)]
pub(crate) struct Solid {
    pub(crate) at: Pose,
    pub(crate) kind: &'static str,
    pub(crate) size: [f64; 3],
}

/// The shape of a collision element; `None` for a mesh.
pub(crate) fn shape_of(collision: Node) -> Checked<Option<(&'static str, [f64; 3])>> {
    let geometry = child(collision, "geometry");
    let of = |kind: &'static str| geometry.and_then(|g| child(g, kind)).map(|node| (kind, node));
    let Some((kind, node)) = ["sphere", "cylinder", "capsule", "box"].into_iter().find_map(of) else { return Ok(None) };
    let length = |name| scalar(Some(node), name);
    let size = match kind {
        "box" => triple(Some(node), "size", [0.0; 3])?.map(|x| 0.5 * x),
        _ => [length("radius")?, 0.5 * length("length")?, 0.0],
    };
    Ok(Some((kind, size)))
}

/// The shape of an obstacle or a load: its kind and its lengths.
pub(crate) fn solid_of(shape: &Value) -> Checked<(&'static str, [f64; 3])> {
    let of = |kind: &&'static str| shape.get(*kind).is_some();
    let kind = ["sphere", "box", "cylinder", "capsule", "half_space"].into_iter().find(of).ok_or("it has no shape")?;
    let size = match kind {
        "box" => three(&shape[kind]["size_m"]).map(|x| 0.5 * x),
        _ => [number_or(&shape[kind], "radius_m", 0.0), 0.5 * number_or(&shape[kind], "length_m", 0.0), 0.0],
    };
    Ok((kind, size))
}

/// The radius of a ball about the centre of a shape that contains it.
pub(crate) fn radius_about(of: &Solid) -> f64 {
    let [r, h, w] = of.size;
    match of.kind {
        "half_space" => f64::INFINITY,
        "sphere" | "piece" => r,
        "capsule" => r + h,
        "cylinder" => r.hypot(h) * (1.0 + 4.0 * UNIT),
        _ => r.hypot(h).hypot(w) * (1.0 + 8.0 * UNIT),
    }
}

/// An upper bound on the extent of a shape from its centre in a direction and against it: that of a ball, of edges, or
/// of an axis and a disc.
pub(crate) fn extent(of: &Solid, n: Vector) -> Tm {
    let [x, y, z] = apply(transpose(of.at.0), n).map(|x| x * x);
    let half = |square: Tm, half: f64| root(square) * Tm::new(half);
    let [r, h, _] = of.size;
    match of.kind {
        "sphere" => half(dot(n, n), r),
        "half_space" => Tm::new(0.0),
        "capsule" => half(z, h) + half(dot(n, n), r),
        "cylinder" => half(z, h) + half(x + y, r),
        _ => half(x, of.size[0]) + half(y, of.size[1]) + half(z, of.size[2]),
    }
}

/// An upper bound on a root, (x + b) / (2 sqrt b) for any positive b.
fn root(square: Tm) -> Tm {
    let near = square.c[0].max(0.3 * square.turn().1.most()).max(1e-12);
    // The root in the divisor is rounded.
    let bound = (square + Tm::new(near)).over(2.0 * near.sqrt());
    bound + Tm::within(0.0, 4.0 * UNIT * bound.most())
}
