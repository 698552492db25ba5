//! Bounds of the motion of balls.

use aghf::constraint::CollisionSphere;
use aghf::model::random_tree;
use aghf_scenario::judge::{Reach, carriers};
use nalgebra::Vector3;
use proptest::array::uniform3;
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
}
