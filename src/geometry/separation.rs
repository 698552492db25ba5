//! The closest points of convex bodies.

use nalgebra::Vector3;
use parry3d_f64::math::{Pose, Vector as Coordinates};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points as gjk};
use parry3d_f64::shape::SupportMap;

/// A convex body in the base frame, by its points that are furthest in directions.
pub trait Support {
    /// A point of the body that is furthest in a direction.
    fn furthest(&self, direction: &Vector3<f64>) -> Vector3<f64>;
}

/// A body as the library of the algorithm sees it.
struct Body<'a, T>(&'a T);

impl<T: Support> SupportMap for Body<'_, T> {
    fn local_support_point(&self, direction: Coordinates) -> Coordinates {
        let [x, y, z] = self.0.furthest(&Vector3::new(direction.x, direction.y, direction.z)).into();
        Coordinates::new(x, y, z)
    }
}

/// The points of two bodies that are closest to each other, m; `None` if they touch or overlap. By the algorithm of
/// Gilbert, Johnson and Keerthi.
#[must_use]
pub fn closest_points<A: Support, B: Support>(a: &A, b: &B) -> Option<[Vector3<f64>; 2]> {
    let (a, b) = (Body(a), Body(b));
    let here = Pose::IDENTITY;
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(&here, &a, &b, Coordinates::X));
    match gjk(&here, &a, &b, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(p, q, _) => Some([p, q].map(|p| Vector3::new(p.x, p.y, p.z))),
        _ => None,
    }
}
