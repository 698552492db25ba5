//! Scenarios in which joints do not move.

use crate::written::{load, with};
use aghf::constraint::{AnyConstraint, CollisionSphere};
use aghf::dynamics::forward_kinematics;
use aghf::spatial::Placement;
use aghf_scenario::{DirectOptions, Quantity, Scenario, Solve};
use serde_json::{Value, json};

/// Kinova with two joints locked; the values are those of the five others.
pub fn five() -> Value {
    json!({
        "robot": "kinova_gen3", "locked_joints": { "joint_3": 0.5, "joint_5": -0.25 }, "horizon_s": 3.0,
        "robot_shape": "joint_frames",
        "q_start": [0.0, 0.5, 1.0, 0.5, 0.0], "v_start": [0.0, 0.0, 0.0, 0.0, 0.0],
        "q_goal": [0.5, 0.4, 1.0, 0.5, 0.0], "v_goal": [0.0, 0.0, 0.0, 0.0, 0.0],
    })
}

#[test]
fn the_joints_that_are_left_are_those_of_the_scenario() {
    let scenario = load("five", &five()).expect("it is good");
    let names: Vec<_> = scenario.model.joints().iter().map(|j| j.name()).collect();
    assert_eq!(names, ["joint_1", "joint_2", "joint_4", "joint_6", "joint_7"]);
    let [_, upper] = scenario.bound(Quantity::Position, 2).expect("it has one");
    assert_eq!(upper, 2.58, "that of joint 4");
    let written = serde_json::to_value(&scenario.file).expect("numbers");
    assert_eq!(written["locked_joints"], five()["locked_joints"]);
    let options = DirectOptions { starts: Some(1), ..Default::default() };
    let enforced = json!({ "enforced_limits": { "velocity": false, "torque": false } });
    let scenario = load("solved", &with(five(), enforced)).expect("it is good");
    let outcome = Solve::new(&scenario).options(options.clone()).run().expect("it is good");
    assert!(outcome.summary.success, "{:?}", outcome.summary);
    assert_eq!(outcome.curve.x().nrows(), 10);
}

/// The balls of the constraints, with their centres in the base frame.
fn balls(scenario: &Scenario, q: &[f64]) -> Vec<([f64; 3], f64)> {
    let mut placements = vec![Placement::identity(); scenario.model.dof()];
    forward_kinematics(&scenario.model, q, &mut placements).expect("lengths agree");
    let constraints = scenario.state_constraints();
    let [AnyConstraint::Spheres(clearance), ..] = &constraints[..] else {
        panic!("{constraints:?}");
    };
    let placed = |ball: &CollisionSphere| {
        let at = placements[ball.body.expect("it moves")];
        let centre = at.rotation * ball.centre + at.translation;
        (centre.into(), ball.radius)
    };
    clearance.balls.iter().map(placed).collect()
}

/// A link is where it was, also where it bends at a joint that is locked.
#[test]
fn the_shape_is_that_of_the_whole_robot() {
    let among = json!({
        "obstacles": [{ "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [0.0, 0.0, 9.0] } }],
        "robot_shape": { "swept_links": { "radius_m": 0.05 } },
    });
    let reduced = load("reduced", &with(five(), among.clone())).expect("it is good");
    let all = json!({
        "locked_joints": {}, "q_start": vec![0.0; 7], "v_start": vec![0.0; 7], "q_goal": vec![0.0; 7],
        "v_goal": vec![0.0; 7],
    });
    let whole = load("whole", &with(with(five(), among.clone()), all)).expect("it is good");
    let expected = balls(&whole, &[0.3, -0.4, 0.5, 0.6, -0.25, 0.8, 0.9]);
    let found = balls(&reduced, &[0.3, -0.4, 0.6, 0.8, 0.9]);
    // Balls of neighbours with one centre are one where the neighbours are one body.
    let at = |balls: &[([f64; 3], f64)], centre: [f64; 3]| -> f64 {
        let same = |c: &[f64; 3]| c.iter().zip(centre).all(|(a, b)| (a - b).abs() < 1e-14);
        let radii = balls.iter().filter(|(c, _)| same(c)).map(|(_, r)| *r);
        radii.fold(0.0, f64::max)
    };
    for (centre, _) in expected.iter().chain(&found) {
        let radius = at(&expected, *centre);
        assert!(radius > 0.0 && at(&found, *centre) == radius, "{centre:?}");
    }

    // What is locked to the base is no constraint, as nothing moves it, but it is looked at before the search.
    let base = with(
        with(five(), among),
        json!({
            "locked_joints": { "joint_1": 0.0, "joint_2": 0.5 },
            "obstacles": [{ "shape": { "sphere": { "radius_m": 0.02 } }, "pose": { "position_m": [0.0, 0.0, 0.28] } }],
        }),
    );
    let base = load("base", &base).expect("it is good");
    let moving = balls(&base, &base.file.q_start).len();
    assert!(moving > 0 && moving < expected.len(), "{moving}");
    let error = base.check_feasible().expect_err("the shoulder is in the way").to_string();
    let words = "base: q_start: a link that is locked to the base is ";
    assert!(error.starts_with(words) && error.contains("inside 'obstacles[0]'; that link does not move"), "{error}");
}
