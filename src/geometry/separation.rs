//! The closest points of convex bodies.

use super::{Convex, Placed, Plane, Solid, Until, WIDTHS};
use crate::spatial::placed_point;
use nalgebra::Vector3;
use parry3d_f64::math::{Pose, Vector as Coordinates};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points as gjk};
use parry3d_f64::shape::SupportMap;

/// The largest number of starts of the algorithm.
const MAX_STARTS: usize = 10;

/// The difference of a distance and the gap along its direction at which it is proved, m.
const PROVED: f64 = 5e-10;

/// A body as the library of the algorithm sees it.
struct Body<'a>(&'a Placed<'a, f64, f64>);

impl SupportMap for Body<'_> {
    fn local_support_point(&self, direction: Coordinates) -> Coordinates {
        let [x, y, z] = self.0.furthest(&Vector3::new(direction.x, direction.y, direction.z)).into();
        Coordinates::new(x, y, z)
    }
}

impl Placed<'_, f64, f64> {
    /// A point of the body without its radius that is furthest in a direction.
    fn furthest(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let own = self.placement.map_or(*direction, |placement| placement.rotation.transpose() * direction);
        placed_point(self.placement, &self.convex.furthest(&own))
    }
}

/// The algorithm of Gilbert, Johnson and Keerthi for two bodies without their radii, up to a distance, m, from a
/// direction from the first one to the second one.
fn gjk_within([a, b]: &[Placed<'_, f64, f64>; 2], start: Coordinates, most: f64, is_exact: bool) -> GJKResult {
    let (a, b) = (Body(a), Body(b));
    let here = Pose::IDENTITY;
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(&here, &a, &b, start));
    gjk(&here, &a, &b, most, is_exact, &mut simplex)
}

/// The gap between two bodies without their radii along a unit normal from the second one to the first one, m, and the
/// furthest points of both against each other.
fn gap_along([a, b]: &[Placed<'_, f64, f64>; 2], n: Vector3<f64>) -> Gap {
    let points = [a.furthest(&-n), b.furthest(&n)];
    Gap { distance: n.dot(&(points[0] - points[1])), points }
}

/// The distance of two bodies without their radii, m, as the gap along the direction of their closest points, which no
/// distance is less than; `None` if they touch or overlap.
///
/// The algorithm ends early if its simplex becomes flat, as at the rim of a disc. It begins again in the direction
/// found, after a step to the furthest points along it, until the gap is the distance of the points.
fn separation(bodies: &[Placed<'_, f64, f64>; 2]) -> Option<Gap> {
    let closest = |start| match gjk_within(bodies, start, f64::MAX, true) {
        GJKResult::ClosestPoints(p, q, _) => Some([p, q].map(|p| Vector3::new(p.x, p.y, p.z))),
        _ => None,
    };
    let length = |[p, q]: &[Vector3<f64>; 2]| (p - q).norm();
    let mut points = closest(Coordinates::X)?;
    let mut best = Gap { distance: 0.0, points };
    for _ in 0..MAX_STARTS {
        let (off, long) = (points[0] - points[1], length(&points));
        if long == 0.0 {
            break;
        }
        let n = off / long;
        let across = gap_along(bodies, n);
        if across.distance > best.distance {
            best = Gap { distance: across.distance, points };
        }
        if length(&best.points) - best.distance <= PROVED {
            break;
        }
        let step = across.points[0] - across.points[1] - off;
        let share = (long * (long - across.distance) / step.norm_squared()).min(1.0);
        for (point, further) in points.iter_mut().zip(across.points) {
            *point += (further - *point) * share;
        }
        let start = points[1] - points[0];
        if let Some(other) = closest(Coordinates::new(start.x, start.y, start.z))
            && length(&other) < length(&points)
        {
            points = other;
        }
    }
    (best.distance > 0.0).then_some(best)
}

/// Returns true if two bodies overlap or touch; faster than their distance.
pub(super) fn overlap(bodies: &[Placed<'_, f64, f64>; 2]) -> bool {
    let [a, b] = bodies;
    let most = a.convex.radius + b.convex.radius;
    let is_separating = |n: Coordinates| gap_along(bodies, -Vector3::new(n.x, n.y, n.z)).distance > most;
    match gjk_within(bodies, Coordinates::X, most, false) {
        GJKResult::Intersection => true,
        GJKResult::NoIntersection(n) if is_separating(n) => false,
        _ => gap(bodies).distance <= 0.0,
    }
}

/// The distance of two bodies.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// The distance, m, or up to 1e-5 m less at the rim of a disc; where they overlap, the negative depth or less.
    pub distance: f64,
    /// The nearest points of both.
    pub points: [Vector3<f64>; 2],
}

/// The distance of two convex bodies.
#[must_use]
pub fn gap(bodies: &[Placed<'_, f64, f64>; 2]) -> Gap {
    let [a, b] = bodies;
    let radii = [a, b].map(|body| body.convex.radius);
    let along = |n: Vector3<f64>, distance: f64, [p, q]: [Vector3<f64>; 2]| Gap {
        distance: distance - radii[0] - radii[1],
        points: [p - n * radii[0], q + n * radii[1]],
    };
    if let Some(Gap { distance, points }) = separation(bodies) {
        return along((points[0] - points[1]).normalize(), distance, points);
    }
    let centre = |body: &Placed<'_, f64, f64>| placed_point(body.placement, &body.convex.ball().centre);
    let off = centre(a) - centre(b);
    let start = if off.norm() > 0.0 { off } else { Vector3::z() };
    let normal = Plane::between(bodies, (|| start, None), WIDTHS, Until::Value).normal;
    let Gap { distance, points: [point, _] } = gap_along(bodies, normal);
    along(normal, distance, [point, point - normal * distance])
}

/// The distance of a convex body from a solid, placed in the base frame, by its [convex form](Convex::of_solid).
#[must_use]
pub fn gap_to(body: &Placed<'_, f64, f64>, (solid, convex): (&Solid, Option<&Convex>)) -> Gap {
    if let Some(convex) = convex {
        return gap(&[*body, Placed { convex, placement: None }]);
    }
    let normal = solid.placement.rotation.column(2).into_owned();
    let point = body.furthest(&-normal) - normal * body.convex.radius;
    let distance = normal.dot(&(point - solid.placement.translation));
    Gap { distance, points: [point, point - normal * distance] }
}
