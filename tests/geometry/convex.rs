//! Convex bodies with a radius.

use super::hull::{Point, points};
use crate::common::config;
use aghf::geometry::{Convex, Shape, Solid};
use aghf::spatial::Placement;
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;

pub fn placement() -> impl Strategy<Value = Placement<f64>> {
    let three = || prop::array::uniform3(-1.5..1.5).prop_map(Vector3::from);
    (three(), three()).prop_map(|(turn, at)| Placement::new(Rotation3::new(turn).into_inner(), at))
}

pub fn solid() -> impl Strategy<Value = Solid> {
    (0_usize..4, prop::array::uniform3(0.02..0.4), placement()).prop_map(|(kind, [a, b, c], placement)| {
        let shape = match kind {
            0 => Shape::Sphere { radius: a },
            1 => Shape::Cuboid { half_extents: Vector3::new(a, b, c) },
            2 => Shape::Cylinder { radius: a, half_length: b },
            _ => Shape::Capsule { radius: a, half_length: b },
        };
        Solid { placement, shape }
    })
}

pub fn body() -> impl Strategy<Value = Convex> {
    let solid = solid().prop_map(|solid| Convex::of_solid(&solid).expect("it has ends"));
    let hull = (points(4..60), 0.0..0.1).prop_map(|(points, radius)| Convex::of_corners(points, radius));
    prop_oneof![solid, hull]
}

proptest! {
    #![proptest_config(config(256))]

    /// The extent of a solid is its largest distance along the direction, that of corners their largest one.
    #[test]
    fn extents_are_those_of_the_shape(points in points(1..80), n in prop::array::uniform3(-1.0..1.0)) {
        let n: Point = Vector3::from(n).try_normalize(1e-3).unwrap_or_else(Vector3::x);
        let most = points.iter().map(|p| n.dot(p)).fold(f64::NEG_INFINITY, f64::max);
        let body = Convex::of_corners(points, 0.01);
        prop_assert!((body.extent(&n) - most - 0.01).abs() < 1e-12);
        prop_assert!(body.corners().iter().any(|corner| *corner == body.furthest(&n)));
        let shape = Shape::Cylinder { radius: 0.3, half_length: 0.2 };
        let cylinder = Convex::of_solid(&Solid { placement: Placement::identity(), shape }).expect("it has ends");
        prop_assert!((cylinder.extent(&n) - 0.3 * n.x.hypot(n.y) - 0.2 * n.z.abs()).abs() < 1e-12);
    }

    /// A body that is moved extends as far in the direction that is moved; its ball contains it.
    #[test]
    fn a_body_moves_with_its_placement(body in body(), at in placement(), n in prop::array::uniform3(-1.0..1.0)) {
        let n: Point = Vector3::from(n).try_normalize(1e-3).unwrap_or_else(Vector3::x);
        let turned = at.rotation * n;
        let extent = body.moved(&at).extent(&turned);
        prop_assert!((extent - body.extent(&n) - turned.dot(&at.translation)).abs() < 1e-12);
        let ball = body.ball();
        prop_assert!(body.extent(&n) <= n.dot(&ball.centre) + ball.radius + 1e-12);
        let point = Convex::of_corners(vec![Vector3::zeros()], 0.1).ball();
        prop_assert_eq!((point.centre, point.radius), (Vector3::zeros(), 0.1));
    }
}
