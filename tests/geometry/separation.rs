//! The closest points of convex bodies.

use super::convex::solid;
use super::hull::{Point, beyond, points};
use crate::common::config;
use aghf::geometry::{Convex, ConvexPiece, Gap, Placed, Shape, Solid, Triangle, gap};
use proptest::prelude::*;

pub fn distance_from_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let along = b - a;
    let share = ((p - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (p - (a + along * share)).norm()
}

/// The distance of a point from a triangle, by its face or its edges.
pub fn distance_from_triangle(p: &Point, [a, b, c]: &Triangle) -> f64 {
    let normal = (b - a).cross(&(c - a)).normalize();
    let is_within =
        [(a, b), (b, c), (c, a)].iter().all(|(from, to)| normal.cross(&(*to - *from)).dot(&(p - *from)) >= 0.0);
    let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| distance_from_segment(p, from, to));
    let nearest = edges.into_iter().fold(f64::INFINITY, f64::min);
    if is_within { normal.dot(&(p - a)).abs() } else { nearest }
}

/// The distance between two segments by their ends and by their common normal.
fn distance_of_segments([a, b]: [Point; 2], [c, d]: [Point; 2]) -> f64 {
    let ends = [
        distance_from_segment(&a, &c, &d),
        distance_from_segment(&b, &c, &d),
        distance_from_segment(&c, &a, &b),
        distance_from_segment(&d, &a, &b),
    ];
    let least = ends.into_iter().fold(f64::INFINITY, f64::min);
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv, uw, vw) = (u.dot(&u), u.dot(&v), v.dot(&v), u.dot(&w), v.dot(&w));
    let det = uu * vv - uv * uv;
    let [s, t] = [(uv * vw - vv * uw) / det, (uu * vw - uv * uw) / det];
    let is_within = det > 0.0 && (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    if is_within { (w + u * s - v * t).norm().min(least) } else { least }
}

/// The distance between the surfaces of two pieces, by all pairs of a corner and a face and of two edges.
fn distance_by_features(a: &ConvexPiece, b: &ConvexPiece) -> f64 {
    let mut least = f64::INFINITY;
    for (one, other) in [(a, b), (b, a)] {
        for face in other.triangles() {
            least = one.corners.iter().map(|p| distance_from_triangle(p, &face)).fold(least, f64::min);
        }
    }
    let edges = |piece: &ConvexPiece| -> Vec<[Point; 2]> {
        piece.triangles().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).collect()
    };
    for one in edges(a) {
        least = edges(b).into_iter().map(|other| distance_of_segments(one, other)).fold(least, f64::min);
    }
    least
}

/// The shape of a body.
#[derive(Clone, Debug)]
enum Form {
    Solid(Solid),
    Hull(ConvexPiece),
}

/// The number of directions in which overlaps are examined.
const DIRECTIONS: u32 = 500;

fn member() -> impl Strategy<Value = (Convex, Form)> {
    let of_hull = points(4..60).prop_map(|points| {
        let piece = ConvexPiece::hull(&points).expect("finite");
        (Convex::of_corners(piece.corners.clone(), 0.0), Form::Hull(piece))
    });
    prop_oneof![solid().prop_map(|solid| (Convex::of_solid(&solid).expect("it has ends"), Form::Solid(solid))), of_hull]
}

/// The distance by which a point is outside of a body, m.
fn outside(form: &Form, p: &Point) -> f64 {
    match form {
        Form::Solid(solid) => solid.distance(p),
        Form::Hull(piece) => beyond(piece, p),
    }
}

proptest! {
    #![proptest_config(config(256))]

    #[test]
    fn closest_points_are_those_of_the_nearest_features(
        a in points(4..12),
        b in points(4..12),
        off in prop::array::uniform3(-1.5..1.5),
    ) {
        let [a, b] = [a, b].map(|points| ConvexPiece::hull(&points).expect("finite"));
        let moved = ConvexPiece { corners: b.corners.iter().map(|c| c + Point::from(off)).collect(), ..b };
        let bodies = [&a, &moved].map(|piece| Convex::of_corners(piece.corners.clone(), 0.0));
        let [first, second] = bodies.each_ref().map(|convex| Placed { convex, placement: None });
        let Gap { distance, points: [p, q] } = gap(&[first, second]);
        if distance <= 0.0 {
            // No plane of a face separates them by more than rounding.
            let apart = |piece: &ConvexPiece, other: &ConvexPiece| {
                let least = |[a, b, c]: Triangle| {
                    let normal = (b - a).cross(&(c - a)).normalize();
                    other.corners.iter().map(|p| normal.dot(&(p - a))).fold(f64::INFINITY, f64::min)
                };
                piece.triangles().map(least).fold(f64::NEG_INFINITY, f64::max)
            };
            prop_assert!(apart(&a, &moved).max(apart(&moved, &a)) < 1e-7);
            return Ok(());
        }
        prop_assert!(beyond(&a, &p) < 1e-9 && beyond(&moved, &q) < 1e-9);
        let by_features = distance_by_features(&a, &moved);
        prop_assert!(((p - q).norm() - by_features).abs() < 1e-9, "{} and {by_features}", (p - q).norm());
    }

    /// The proof of a distance: nearest points within the bodies, and a plane across them with as large a gap. Where
    /// the bodies overlap, no direction has a gap.
    #[test]
    fn distances_are_proved_by_points_and_a_plane(a in member(), b in member()) {
        let [first, second] = [&a, &b].map(|(convex, _)| Placed { convex, placement: None });
        let Gap { distance, points: [p, q] } = gap(&[first, second]);
        let gap_along = |n: &Point| -a.0.extent(&-n) - b.0.extent(n);
        if distance > 0.0 {
            let proved = gap_along(&((p - q) / (p - q).norm()));
            prop_assert!((proved - distance).abs() <= 1e-12, "{proved} {distance}");
            // At the rim of a disc the points are less exact: of 300 000 pairs, one is 9e-6 m further apart.
            let has_disc = |form: &Form| matches!(form, Form::Solid(Solid { shape: Shape::Cylinder { .. }, .. }));
            let most = if has_disc(&a.1) || has_disc(&b.1) { 1e-5 } else { 1e-9 };
            let length = (p - q).norm();
            prop_assert!((-1e-12..=most).contains(&(length - distance)), "{length} {distance}");
            prop_assert!(outside(&a.1, &p) <= 1e-9 && outside(&b.1, &q) <= 1e-9, "{p} {q}");
        } else {
            // Directions at nearly equal distances, on a spiral.
            let spiral = (0..DIRECTIONS).map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(DIRECTIONS);
                let (y, x) = (2.399_963 * f64::from(i)).sin_cos();
                Point::new(x, y, 0.0) * (1.0 - z * z).sqrt() + Point::z() * z
            });
            let best = spiral.map(|n| gap_along(&n)).fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(best <= 1e-9, "{best} {distance}");
        }
    }
}
