//! The plane that separates two bodies best.

use super::convex::{body, placement};
use crate::common::config;
use aghf::geometry::{Convex, Placed, Plane, Solid, Until, gap, gap_to};
use aghf::scalar::{Lanes, Wide};
use aghf::spatial::Placement;
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;

const WIDTHS: [f64; 2] = [0.03, 0.002];

fn in_lanes(at: &Placement<f64>) -> Placement<Wide> {
    Placement::new(at.rotation.map(Wide::splat), at.translation.map(Wide::splat))
}

proptest! {
    #![proptest_config(config(256))]

    /// Between bodies that are apart the gap of the plane is their distance but for the smoothing, in lanes and alone,
    /// from any direction, and no other normal has a larger one.
    #[test]
    fn the_gap_is_the_distance((a, b) in (body(), body()), (at, to) in (placement(), placement()), off in -1.0..1.0) {
        let bodies = [Placed { convex: &a, placement: Some(&at) }, Placed { convex: &b, placement: Some(&to) }];
        let exact = gap(&bodies);
        let radii = a.radius + b.radius;
        let away = at.point(&a.ball().centre) - to.point(&b.ball().centre);
        prop_assume!(exact.distance + radii > 1e-3 && away.norm() > 1e-3);
        // At the rim of a disc, which a cylinder alone has, the points are less exact.
        let has_disc = |body: &Convex| body.corners().len() == 2 && body.radius == 0.0;
        let most = if has_disc(&a) || has_disc(&b) { 1e-5 } else { 1e-9 };
        let distance = (exact.points[0] - exact.points[1]).norm().copysign(exact.distance);
        prop_assert!((-1e-12..most).contains(&(distance - exact.distance)), "{distance} {exact:?}");

        let plane = Plane::between(&bodies, (|| away, None), WIDTHS, Until::Value);
        let least = exact.distance + radii - WIDTHS[1] * (a.excess() + b.excess());
        prop_assert!((least - 1e-9..=exact.distance + radii + 1e-9).contains(&plane.gap), "{} {exact:?}", plane.gap);
        let other = Vector3::new(off, 1.0 - off, off * off);
        let from_other = Plane::between(&bodies, (|| other, None), WIDTHS, Until::Value);
        prop_assert!((from_other.gap - plane.gap).abs() < 1e-8, "{} {}", from_other.gap, plane.gap);
        // And from the plane at other places, from a little to half a turn off, or the same ones.
        for turn in [0.0, 1e-6, 1e-2, 3.0] {
            let moved = Placement::new(Rotation3::new(other * turn).into_inner() * at.rotation, at.translation);
            let nearby = [Placed { convex: &a, placement: Some(&moved) }, bodies[1]];
            let hint = Plane::between(&nearby, (|| away, None), WIDTHS, Until::Value).hint();
            let from_hint = Plane::between(&bodies, (|| away, Some((&hint, true))), WIDTHS, Until::Derivatives);
            prop_assert!((from_hint.gap - plane.gap).abs() < 1e-8, "{turn} {} {}", from_hint.gap, plane.gap);
            let off = from_hint.points[0] - plane.points[0];
            prop_assert!(off.norm() < 1e-5, "{turn} {off}");
        }

        let [p, q] = [at, to].map(|at| in_lanes(&at));
        let wide = [Placed { convex: &a, placement: Some(&p) }, Placed { convex: &b, placement: Some(&q) }];
        let wide = Plane::between(&wide, (|| away.map(Wide::splat), None), WIDTHS, Until::Value);
        prop_assert!(wide.gap.0.iter().all(|gap| (gap - plane.gap).abs() < 1e-9));
        prop_assert_eq!(wide.normal.map(|x| x.0[0]), wide.normal.map(|x: Lanes<f64, 4>| x.0[3]));
        // With less than the gap asked for, the plane is one that has it.
        let enough = Plane::between(&bodies, (|| away, None), WIDTHS, Until::Gap(0.5 * plane.gap));
        prop_assert!(enough.gap >= 0.5 * plane.gap && enough.gap <= plane.gap + 1e-9);
    }

    /// Where bodies overlap, the plane is the same from any plane nearby that is not followed, and one that is followed
    /// is at least as good as that across the direction of the search.
    #[test]
    fn planes_of_overlaps_are_followed_or_not((a, b) in (body(), body()), (at, to) in (placement(), placement())) {
        let to = Placement::new(to.rotation, at.point(&a.ball().centre) + 0.1 * to.translation);
        let bodies = [Placed { convex: &a, placement: Some(&at) }, Placed { convex: &b, placement: Some(&to) }];
        let away = at.point(&a.ball().centre) - to.point(&b.ball().centre);
        prop_assume!(away.norm() > 1e-3);
        let anew = Plane::between(&bodies, (|| away, None), WIDTHS, Until::Value);
        prop_assume!(anew.gap < 0.0);
        for side in [Vector3::x(), Vector3::y(), -Vector3::z()] {
            let far = Placement::new(to.rotation, to.translation + side);
            let apart = [bodies[0], Placed { convex: &b, placement: Some(&far) }];
            let hint = Plane::between(&apart, (|| -side, None), WIDTHS, Until::Value).hint();
            let from = |follow| Plane::between(&bodies, (|| away, Some((&hint, follow))), WIDTHS, Until::Value);
            prop_assert_eq!(from(false).gap, anew.gap);
            let n = away.normalize();
            let across = a.moved(&at).extent(&-n) - a.radius + b.moved(&to).extent(&n) - b.radius;
            let most = across + WIDTHS[1] * (a.excess() + b.excess());
            prop_assert!(from(true).gap >= -most - 1e-9, "{} {most}", from(true).gap);
        }
    }

    /// Where bodies overlap, moving one of them along the normal by the depth separates them.
    #[test]
    fn the_depth_of_an_overlap_separates((a, b) in (body(), body()), (at, to) in (placement(), placement())) {
        let to = Placement::new(to.rotation, at.point(&a.ball().centre) + 0.1 * to.translation);
        let bodies = [Placed { convex: &a, placement: Some(&at) }, Placed { convex: &b, placement: Some(&to) }];
        let found = gap(&bodies);
        prop_assume!(found.distance < -1e-6);
        let [p, q] = found.points;
        prop_assert!(((q - p).norm() + found.distance).abs() < 1e-6);
        // By a tenth of a millimetre more, so that they do not touch.
        let moved = Placement::new(at.rotation, at.translation + (q - p) * (1.0 - 1e-4 / found.distance));
        let apart = gap(&[Placed { convex: &a, placement: Some(&moved) }, bodies[1]]);
        prop_assert!(apart.distance > 0.5e-4, "{found:?} {apart:?}");
    }

    #[test]
    fn a_half_space_has_the_distance_along_its_normal(a in body(), at in placement(), offset in -1.0..1.0) {
        let normal = Vector3::new(0.6, 0.0, 0.8);
        let placed = Placed { convex: &a, placement: Some(&at) };
        let found = gap_to(&placed, (&Solid::half_space(&normal, offset), None));
        let extent = a.moved(&at).extent(&-normal);
        prop_assert!((found.distance + extent + offset).abs() < 1e-9);
        let plane = Plane::of_half_space(&placed, &normal, offset, WIDTHS[1]);
        let off = found.distance + a.radius - plane.gap;
        prop_assert!((-1e-12..=WIDTHS[1] * a.excess() + 1e-12).contains(&off));
    }
}
