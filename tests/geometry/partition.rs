//! Convex pieces of meshes.

use super::hull::{Point, beyond};
use super::separation::distance_from_triangle;
use crate::common::config;
use aghf::geometry::{ConvexPiece, Triangle, convex_pieces, excess};
use proptest::prelude::*;

/// The triangles of a box along the axes.
fn cuboid(lower: [f64; 3], upper: [f64; 3]) -> Vec<Triangle> {
    let corner = |i: usize| Point::from_fn(|k, _| if i >> k & 1 == 0 { lower[k] } else { upper[k] });
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]].map(|t| t.map(corner));
    quads.into_iter().flat_map(halves).collect()
}

proptest! {
    #![proptest_config(config(128))]

    /// Each triangle is in one piece, and the surfaces of the pieces are within the excess that is stated.
    #[test]
    fn pieces_contain_the_triangles_and_keep_their_excess(
        sizes in prop::collection::vec((prop::array::uniform3(-0.3..0.3), prop::array::uniform3(0.02..0.2)), 1..4),
        most in 0.002..0.1,
    ) {
        let box_of = |(at, size): &([f64; 3], [f64; 3])| cuboid(*at, std::array::from_fn(|i| at[i] + size[i]));
        let triangles: Vec<Triangle> = sizes.iter().flat_map(box_of).collect();
        let pieces = convex_pieces(&triangles, most).expect("finite");
        prop_assert!(pieces.len() <= 8);
        for triangle in &triangles {
            let is_in = |piece: &ConvexPiece| triangle.iter().all(|p| beyond(piece, p) < 1e-9);
            prop_assert!(pieces.iter().any(is_in));
        }
        let stated = excess(&pieces, &triangles, 0.005).expect("finite");
        for (i, piece) in pieces.iter().enumerate() {
            for p in piece.triangles().map(|[a, b, c]| (a + b + c) / 3.0) {
                let off = triangles.iter().map(|t| distance_from_triangle(&p, t)).fold(f64::INFINITY, f64::min);
                let is_within = |(j, other): (usize, &ConvexPiece)| j != i && beyond(other, &p) < 2e-6;
                let is_hidden = pieces.iter().enumerate().any(is_within);
                prop_assert!(is_hidden || off <= stated, "{off} of {stated}");
            }
        }
    }
}

/// Two boxes in the shape of an L are two pieces, and one box is one.
#[test]
fn an_angle_is_two_pieces() {
    let mut triangles = cuboid([0.0; 3], [0.4, 0.1, 0.1]);
    let one = convex_pieces(&triangles, 0.005).expect("finite");
    assert_eq!((one.len(), one[0].corners.len()), (1, 8));
    assert!((one[0].volume() - 0.004).abs() < 1e-12);
    assert!(excess(&one, &triangles, 0.001).expect("finite") <= 0.001 + 1e-12);
    triangles.extend(cuboid([0.0; 3], [0.1, 0.1, 0.4]));
    let two = convex_pieces(&triangles, 0.005).expect("finite");
    assert_eq!(two.len(), 2);
    let volume: f64 = two.iter().map(ConvexPiece::volume).sum();
    assert!(volume < 0.0081, "{volume}");
    let whole: Vec<_> = triangles.iter().flatten().copied().collect();
    let hull = [ConvexPiece::hull(&whole).expect("finite")];
    // The middle of the hypotenuse is furthest from both legs.
    let most = excess(&hull, &triangles, 1e-4).expect("finite");
    assert!(most > 0.14 && most < 0.16, "{most}");
}

#[test]
fn senseless_input_is_refused() {
    let error = |result: aghf::error::Result<Vec<ConvexPiece>>| result.expect_err("senseless").to_string();
    assert!(error(convex_pieces(&[], 0.01)).contains("triangles"));
    assert!(error(convex_pieces(&cuboid([0.0; 3], [1.0; 3]), 0.0)).contains("excess"));
    assert!(error(convex_pieces(&cuboid([0.0; 3], [f64::NAN; 3]), 0.01)).contains("finite"));
}
