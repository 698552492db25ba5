//! Bounds bound.

use aghf::constraint::CollisionSphere;
use aghf::model::random_tree;
use aghf_scenario::judge::{Cubic, Reach, carriers};
use nalgebra::Vector3;
use proptest::array::{uniform2, uniform3};
use proptest::collection::vec;

/// The number of joints.
const N: usize = 6;

proptest::proptest! {
    #![proptest_config(crate::common::config(256))]

    /// No ball is farther away than its bound, wherever its joints are within theirs.
    #[test]
    fn balls_stay_within_their_reach(
        seed in 0..1000u64, body in 0..N, centre in uniform3(-1.0..1.0f64),
        q in vec(-3.0..3.0f64, N), ways in vec(0.0..1.5f64, N), shares in vec(vec(-1.0..1.0f64, N), 20),
    ) {
        let model = random_tree(N, seed).expect("six joints");
        let ball = CollisionSphere { body: Some(body), centre: Vector3::from(centre), radius: 0.1 };
        let path = carriers(&model, ball.body);
        let mut reach = Reach::new(&model);
        reach.place(&q).expect("six joints");
        let before = reach.centre(&ball);
        let way = reach.way(&before, &path, &ways);
        // Corners are among the worst, so half of the shares are taken to the ends.
        for (k, shares) in shares.iter().enumerate() {
            let share = |i: usize| if k % 2 == 0 { shares[i] } else { shares[i].signum() };
            let moved: Vec<f64> = (0..N).map(|i| q[i] + ways[i] * share(i)).collect();
            reach.place(&moved).expect("six joints");
            let found = (reach.centre(&ball) - before).norm();
            proptest::prop_assert!(found <= way + 1e-12, "{found}, {way}");
        }
    }

    /// It is sharp: a small move of one joint uses it up.
    #[test]
    fn the_reach_of_one_joint_is_sharp(seed in 0..1000u64, body in 0..N, q in vec(-3.0..3.0f64, N)) {
        let model = random_tree(N, seed).expect("six joints");
        let ball = CollisionSphere { body: Some(body), centre: Vector3::new(0.3, -0.2, 0.4), radius: 0.1 };
        let path = carriers(&model, ball.body);
        let mut reach = Reach::new(&model);
        for i in &path {
            let mut moved = q.clone();
            reach.place(&q).expect("six joints");
            let before = reach.centre(&ball);
            let ways: Vec<f64> = (0..N).map(|j| if j == *i { 1e-4 } else { 0.0 }).collect();
            let way = reach.way(&before, &path, &ways);
            moved[*i] += 1e-4;
            reach.place(&moved).expect("six joints");
            let found = (reach.centre(&ball) - before).norm();
            proptest::prop_assert!((found - way).abs() <= 1e-8 * way + 1e-12, "{found}, {way}");
        }
    }

    /// The extrema of a cubic are at its ends, where it turns and where it is fastest, and its way from the middle of a
    /// part is bounded.
    #[test]
    fn cubics_stay_within_their_extrema(
        q in uniform2(-2.0..2.0f64), v in uniform2(-8.0..8.0f64), interval in 0.01..2.0f64,
        part in uniform2(0.0..1.0f64),
    ) {
        let cubic = Cubic::new(q, v, interval);
        for (end, s) in [0.0, 1.0].into_iter().enumerate() {
            proptest::prop_assert!((cubic.position(s) - q[end]).abs() < 1e-12);
            proptest::prop_assert!((cubic.velocity(s) - v[end]).abs() < 1e-10);
        }
        let range = |values: &[f64]| {
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            [least, most]
        };
        let ends = [Some(0.0), Some(1.0)];
        let turns: Vec<f64> = ends.into_iter().chain(cubic.turns()).flatten().map(|s| cubic.position(s)).collect();
        let fastest = ends.into_iter().chain([cubic.fastest([0.0, 1.0])]).flatten();
        let fastest: Vec<f64> = fastest.map(|s| cubic.velocity(s)).collect();
        let [positions, velocities] = [range(&turns), range(&fastest)];
        let part = [part[0].min(part[1]), part[0].max(part[1])];
        let (middle, way) = (cubic.position(0.5 * (part[0] + part[1])), cubic.way_from_middle(part));
        for k in 0..=500 {
            let s = f64::from(k) / 500.0;
            let (position, velocity) = (cubic.position(s), cubic.velocity(s));
            proptest::prop_assert!(position >= positions[0] - 1e-9 && position <= positions[1] + 1e-9);
            proptest::prop_assert!(velocity >= velocities[0] - 1e-9 && velocity <= velocities[1] + 1e-9);
            let within = part[0] + (part[1] - part[0]) * s;
            proptest::prop_assert!((cubic.position(within) - middle).abs() <= way + 1e-12);
        }
        let rate = (cubic.velocity(0.501) - cubic.velocity(0.499)) / (0.002 * interval);
        proptest::prop_assert!((cubic.acceleration(0.5) - rate).abs() <= 1e-6 * (1.0 + rate.abs()));
    }
}
