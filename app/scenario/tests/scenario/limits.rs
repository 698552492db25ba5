//! Limits of the joints are constraints unless a scenario says otherwise: which, to what share, of which joints.

use crate::written::{load, with};
use aghf::constraint::AnyConstraint;
use aghf::curve::{Chebyshev, Curve};
use aghf::model::Limits;
use aghf_scenario::{Enforced, EnforcedLimits, Feasibility, Quantity, Scenario};
use nalgebra::DMatrix;
use serde_json::{Value, json};

const ALL: [Quantity; 3] = [Quantity::Position, Quantity::Velocity, Quantity::Torque];

/// A scenario that says nothing of limits.
fn plain(robot: &str, n: usize) -> Value {
    let zeros = vec![0.0; n];
    json!({
        "robot": robot, "robot_shape": "joint_frames", "horizon_s": 2.0,
        "q_start": zeros, "v_start": zeros, "q_goal": zeros, "v_goal": zeros,
    })
}

fn kinova(name: &str, enforced: Value) -> Scenario {
    let scenario = with(plain("kinova_gen3", 7), json!({ "enforced_limits": enforced }));
    load(name, &scenario).expect("it is good")
}

/// The limits of the URDF as bounds.
fn of_robot(limits: &Limits, limit: Quantity) -> [f64; 2] {
    match limit {
        Quantity::Position => [limits.lower, limits.upper],
        Quantity::Velocity => [-limits.velocity, limits.velocity],
        Quantity::Torque => [-limits.effort, limits.effort],
        _ => panic!("{limit:?}"),
    }
}

/// The number of rows of each constraint on the state, and of those on the control.
fn rows(scenario: &Scenario) -> (Vec<usize>, usize) {
    let constraints = scenario.state_constraints();
    let rows = constraints.iter().map(|constraint| match constraint {
        AnyConstraint::Bounds(bounds) => bounds.0.len(),
        other => panic!("{other:?}"),
    });
    (rows.collect(), scenario.torque_limits().dim())
}

#[test]
fn all_limits_of_the_robot_are_enforced_unless_said() {
    let scenario = load("default", &plain("kinova_gen3", 7)).expect("it is good");
    for (i, joint) in scenario.model.joints().iter().enumerate() {
        for limit in ALL {
            let expected = of_robot(joint.limits(), limit);
            assert_eq!(scenario.bound(limit, i), Some(expected));
        }
    }
    assert_eq!(rows(&scenario), (vec![14, 14], 14));
    assert!(!scenario.is_free());
    assert_eq!(scenario.bound(Quantity::Torque, 7), None, "there are seven");
    // Keys that are missing are not false.
    let one = kinova("one", json!({ "velocity": false }));
    assert_eq!(rows(&one), (vec![14], 14));
    let none = json!({ "position": false, "velocity": false, "torque": false });
    let none = kinova("none", none);
    assert_eq!(rows(&none), (vec![], 0));
    assert_eq!(none.torque_limits().0, [None; 0]);
    assert_eq!(none.file.enforced_limits, EnforcedLimits::NONE);
    assert!(none.is_free());
    // A robot without limits has none to enforce.
    let pendulum = load("pendulum", &plain("pendulum_2", 2)).expect("it is good");
    assert!(pendulum.is_free() && pendulum.file.enforced_limits.any());
}

#[test]
fn a_share_of_the_limits_of_some_joints() {
    let scenario = load(
        "share",
        &with(
            plain("digit_v3_pinned", 22),
            json!({ "enforced_limits": {
                "position": 0.5,
                "velocity": { "share": 0.8, "joints": ["left_hip_pitch", "left_knee"] },
                "torque": { "joints": ["left_knee"] },
            } }),
        ),
    );
    let scenario = scenario.expect("it is good");
    for (i, joint) in scenario.model.joints().iter().enumerate() {
        let limits = joint.limits();
        let [lower, upper] = scenario.bound(Quantity::Position, i).expect("it has a range");
        let half = 0.25 * (limits.upper - limits.lower);
        let middle = 0.5 * (limits.upper + limits.lower);
        assert!((lower - (middle - half)).abs() < 1e-12, "{}", joint.name());
        assert!((upper - (middle + half)).abs() < 1e-12, "{}", joint.name());
        let most = 0.8 * limits.velocity;
        let [knee, hip] = ["left_knee", "left_hip_pitch"].map(|name| name == joint.name());
        let speed = scenario.bound(Quantity::Velocity, i);
        assert_eq!(speed, (knee || hip).then_some([-most, most]));
        let torque = scenario.bound(Quantity::Torque, i);
        assert_eq!(torque, knee.then_some([-limits.effort, limits.effort]));
    }
    assert_eq!(rows(&scenario), (vec![44, 4], 2));
}

#[test]
fn what_is_written_is_read_again() {
    let full = |enforced: &Value| json!({ "position": enforced, "velocity": true, "torque": false });
    for enforced in [
        json!(true),
        json!(false),
        json!(0.8),
        json!({ "share": 0.8, "joints": ["joint_1", "joint_3"] }),
        json!({ "share": 1.0, "joints": [] }),
    ] {
        let file = kinova("again", full(&enforced)).file;
        let written = serde_json::to_value(&file.enforced_limits).expect("numbers");
        assert_eq!(written, full(&enforced));
    }
    // Different words for the same.
    for (enforced, short) in [(json!(1), json!(true)), (json!({}), json!(true)), (json!({ "share": 0.8 }), json!(0.8))]
    {
        let file = kinova("short", full(&enforced)).file;
        let written = serde_json::to_value(&file.enforced_limits).expect("numbers");
        assert_eq!(written, full(&short));
    }
}

/// A share of one joint's limit is enforced; the whole limits of the others are reported and do not affect success.
#[test]
fn what_is_not_enforced_of_a_limit_breaks_no_success() {
    let mut scenario = kinova(
        "verdict",
        json!({
            "position": false,
            "velocity": { "share": 0.5, "joints": ["joint_1"] },
            "torque": false,
        }),
    );
    // Both joints may do 1.3963 rad/s.
    let most = scenario.model.joints()[0].limits().velocity;
    let speeds = |scenario: &Scenario, v: [f64; 2]| {
        let x = DMatrix::from_fn(14, 3, |i, _| if i < 7 { 0.0 } else { *v.get(i - 7).unwrap_or(&0.0) });
        let curve = Curve::new(Chebyshev::new(2, 1.0).expect("a good degree"), x);
        let found = Feasibility::of(scenario, &curve.expect("sizes agree")).expect("of this robot");
        let all = found.limit_violations.iter().filter(|v| v.limit == Quantity::Velocity);
        let in_limits = |by: f64| (by / most * 1e9).round() * 1e-9;
        let told = all.map(|v| (v.joint.clone(), in_limits(v.by), v.enforced));
        (found.holds(0.0), told.collect::<Vec<_>>())
    };
    let [first, second] = ["joint_1", "joint_2"].map(|name| Some(name.to_owned()));
    assert_eq!(speeds(&scenario, [0.49 * most, 0.99 * most]), (true, vec![]));
    let (holds, told) = speeds(&scenario, [0.49 * most, 2.0 * most]);
    assert_eq!((holds, told), (true, vec![(second, 1.0, false)]));
    // Beyond the whole limit too, and told once.
    let (holds, told) = speeds(&scenario, [-2.0 * most, 0.0]);
    assert_eq!((holds, told), (false, vec![(first.clone(), 1.5, true)]));
    scenario.file.enforced_limits.velocity = Enforced::No;
    let (holds, told) = speeds(&scenario, [-2.0 * most, 0.0]);
    assert_eq!((holds, told), (true, vec![(first, 1.0, false)]));
}
