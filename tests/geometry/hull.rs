//! Convex hulls of points.

use crate::common::config;
use aghf::geometry::{ConvexPiece, Triangle};
use nalgebra::Vector3;
use proptest::prelude::*;

pub type Point = Vector3<f64>;

pub fn points(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Point>> {
    let point = prop::array::uniform3(-0.5..0.5).prop_map(Point::from);
    prop::collection::vec(point, count)
}

/// The largest distance of a point beyond a face of a piece, m.
pub fn beyond(piece: &ConvexPiece, p: &Point) -> f64 {
    let height = |[a, b, c]: Triangle| {
        let normal = (b - a).cross(&(c - a));
        normal.normalize().dot(&(p - a))
    };
    piece.triangles().map(height).fold(f64::NEG_INFINITY, f64::max)
}

proptest! {
    #![proptest_config(config(256))]

    #[test]
    fn a_hull_contains_its_points_and_has_corners_among_them(points in points(4..60)) {
        let hull = ConvexPiece::hull(&points).expect("finite");
        prop_assert!(hull.volume() > 0.0);
        for p in &points {
            prop_assert!(beyond(&hull, p) < 1e-9);
        }
        for corner in &hull.corners {
            prop_assert!(points.contains(corner), "{corner}");
        }
    }

    /// Points in a plane, on a line or in one place have a hull of some thickness that contains them.
    #[test]
    fn flat_sets_of_points_have_hulls(points in points(1..20), kept in 0..3_usize) {
        let flat: Vec<_> = points.iter().map(|p| Point::from_fn(|i, _| if i < kept { p[i] } else { 0.25 })).collect();
        let hull = ConvexPiece::hull(&flat).expect("finite");
        for p in &flat {
            prop_assert!(beyond(&hull, p) < 1e-9);
        }
        prop_assert!(hull.corners.iter().all(|c| c.z >= 0.25 - 1e-3 && c.z <= 0.25 + 1e-3));
    }
}
