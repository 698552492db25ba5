//! Links of a robot, by balls and by the bodies within them.

use super::convex::body;
use crate::common::{config, robot};
use aghf::dynamics::forward_kinematics;
use aghf::geometry::{CollisionGeometry, Convex, Placed, Sphere, gap};
use aghf::spatial::Placement;
use proptest::prelude::*;

proptest! {
    #![proptest_config(config(64))]

    /// The gap of two links is the least of their bodies, and that of their balls if these are the robot.
    #[test]
    fn the_gap_of_links_is_the_least_of_their_bodies(
        (first, second) in (prop::collection::vec(body(), 1..5), prop::collection::vec(body(), 1..5)),
        most in 0.01..3.0,
    ) {
        let model = robot("kinova_gen3");
        let mut placements = vec![Placement::identity(); model.dof()];
        forward_kinematics(&model, &vec![0.3; model.dof()], &mut placements).expect("lengths agree");
        let mut geometry = CollisionGeometry::default();
        for (link, body, parts) in [("first", 4, &first), ("second", 1, &second)] {
            parts.iter().for_each(|part| geometry.add(link, Some(body), part.clone()));
        }
        let trees = geometry.trees();
        prop_assert_eq!(trees.len(), 2);
        let of = [&trees[0], &trees[1]];
        let placed = |convex: &'_ Convex, body: usize| (convex.clone(), placements[body]);
        let bodies = |(a, p): &(Convex, Placement<f64>), (b, q): &(Convex, Placement<f64>)| {
            let [a, b] = [(a, p), (b, q)].map(|(convex, at)| Placed { convex, placement: Some(at) });
            gap(&[a, b]).distance
        };
        let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (placed(a, 4), placed(b, 1))));
        let least = pairs.map(|(a, b)| bodies(&a, &b)).fold(f64::INFINITY, f64::min);
        let expected = if least < most { least } else { f64::INFINITY };
        prop_assert_eq!(geometry.gap_within(of, &placements, most).expect("its bodies"), expected);
        prop_assert_eq!(geometry.overlap(of, &placements).expect("its bodies"), least <= 0.0);
        prop_assert!(geometry.gap_within(of, &placements[..2], most).is_err());

        geometry.parts.clear();
        let ball = |i: usize| {
            let ball = geometry.balls[i];
            let place = &placements[ball.body.expect("it is on a body")];
            Sphere { centre: place.point(&ball.centre), radius: ball.radius }
        };
        let count = first.len();
        let gaps = (0..count).flat_map(|i| (count..geometry.balls.len()).map(move |j| ball(i).gap(&ball(j))));
        let least = gaps.fold(f64::INFINITY, f64::min);
        prop_assert_eq!(geometry.gap_within(of, &placements, 10.0).expect("its bodies"), least);
    }
}
