//! What a motion keeps clear of and which limits it breaks.

use aghf::motion::Sample;
use aghf::scenario::{Feasibility, Limit, Scenario};

/// A motion that does not exist: at rest, with these entries for joint 0 of Kinova.
fn samples(of_joint_0: &[(f64, f64, f64)]) -> Vec<Sample> {
    let vector = |x: f64| vec![x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let sample = |(i, (q, v, u)): (usize, &(f64, f64, f64))| Sample {
        t: i as f64,
        q: vector(*q),
        v: vector(*v),
        a: vector(0.0),
        u: vector(*u),
        qdot: vector(*v),
    };
    of_joint_0.iter().enumerate().map(sample).collect()
}

#[test]
fn broken_limits_are_told_and_enforced_ones_matter() {
    let mut scenario = Scenario::load("kinova_free_01").expect("built in");
    // Joint 0 of Kinova may be at 6.28 rad, move at 1.3963 rad/s and push with 39 N m.
    let motion = samples(&[(0.0, 0.0, 0.0), (6.38, -1.0, 39.0), (-6.78, 1.0, -49.0)]);
    let feasibility = Feasibility::of(&scenario, &motion).expect("of this robot");
    assert_eq!(feasibility.smallest_clearance_m, None, "no obstacles");
    let [position, torque] = &feasibility.limit_violations[..] else {
        panic!("{feasibility:?}");
    };
    assert_eq!((position.limit, position.at_s), (Limit::Position, 2.0));
    assert!((position.by - 0.5).abs() < 1e-12);
    assert_eq!((torque.limit, torque.at_s), (Limit::Torque, 2.0));
    assert!((torque.by - 10.0).abs() < 1e-12);
    assert!(feasibility.holds(&scenario, 0.0, 0.0), "none is enforced");
    scenario.file.enforced_limits.velocity = true;
    assert!(feasibility.holds(&scenario, 0.0, 0.0), "the speed is kept");
    scenario.file.enforced_limits.torque = true;
    assert!(!feasibility.holds(&scenario, 0.0, 0.0));
    assert!(
        feasibility.holds(&scenario, 0.0, 10.5),
        "within the tolerance"
    );
    let fast = samples(&[(0.0, 1.0, 0.0), (0.0, -2.0, 0.0)]);
    let fast = Feasibility::of(&scenario, &fast).expect("of this robot");
    let [speed] = &fast.limit_violations[..] else {
        panic!("{fast:?}");
    };
    assert_eq!((speed.limit, speed.at_s), (Limit::Velocity, 1.0));
    assert!((speed.by - (2.0 - 1.3963)).abs() < 1e-12 && !fast.holds(&scenario, 0.0, 0.0));
}

#[test]
fn a_collision_is_told() {
    let scenario = Scenario::load("kinova_gap_01").expect("it can be generated");
    let motion = |t: f64| {
        let mut sample = samples(&[(0.0, 0.0, 0.0)]).swap_remove(0);
        let ends = scenario.file.q_start.iter().zip(&scenario.file.q_goal);
        sample.q = ends.map(|(a, b)| a + (b - a) * t).collect();
        sample
    };
    let start = Feasibility::of(&scenario, &[motion(0.0)]).expect("of this robot");
    assert!(
        start.smallest_clearance_m.is_some_and(|m| m > 0.02) && start.holds(&scenario, 0.0, 0.0)
    );
    let line: Vec<_> = (0..=50).map(|i| motion(f64::from(i) / 50.0)).collect();
    let line = Feasibility::of(&scenario, &line).expect("of this robot");
    assert!(
        line.smallest_clearance_m.is_some_and(|m| m < -0.02) && !line.holds(&scenario, 0.0, 0.0)
    );
}
