//! The closest points of convex bodies.

use super::{Convex, Placed, Plane, Solid, Until, WIDTHS};
use crate::spatial::placed_point;
use nalgebra::Vector3;
use parry3d_f64::math::{Pose, Vector as Coordinates};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points as gjk};
use parry3d_f64::shape::SupportMap;

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

/// The points of two bodies without their radii that are closest to each other, m; `None` if they touch or overlap. By
/// the algorithm of Gilbert, Johnson and Keerthi.
fn closest_points([a, b]: &[Placed<'_, f64, f64>; 2]) -> Option<[Vector3<f64>; 2]> {
    let (a, b) = (Body(a), Body(b));
    let here = Pose::IDENTITY;
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(&here, &a, &b, Coordinates::X));
    match gjk(&here, &a, &b, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(p, q, _) => Some([p, q].map(|p| Vector3::new(p.x, p.y, p.z))),
        _ => None,
    }
}

/// The distance of two bodies.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// The distance, m; where they overlap, the negative depth or less.
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
    if let Some([p, q]) = closest_points(bodies) {
        let off = p - q;
        let distance = off.norm();
        if distance > 0.0 {
            return along(off / distance, distance, [p, q]);
        }
    }
    let centre = |body: &Placed<'_, f64, f64>| placed_point(body.placement, &body.convex.ball().centre);
    let off = centre(a) - centre(b);
    let start = if off.norm() > 0.0 { off } else { Vector3::z() };
    let normal = Plane::between(bodies, (|| start, None), WIDTHS, Until::Value).normal;
    let point = a.furthest(&-normal);
    let distance = normal.dot(&(point - b.furthest(&normal)));
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
