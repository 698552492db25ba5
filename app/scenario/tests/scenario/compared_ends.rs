//! Motions to the best end of a goal that is a set, by the objective.

use crate::goal_ends::{kinova, pose_at};
use crate::written::{load, with};
use aghf_scenario::{Details, Solve};
use proptest::prelude::*;
use serde_json::{Value, json};

/// The duration of the motion for an objective, which is its cost, or the integral of the effort on a given horizon.
fn cost(name: &str, scenario: &Value) -> f64 {
    let scenario = load(name, scenario).expect("it is good");
    let summary = Solve::new(&scenario).run().expect("it is good").summary;
    assert!(summary.success, "{name}: {:?}", summary.failure);
    let Details::Direct(details) = summary.details else {
        panic!("by the direct method");
    };
    if scenario.file.objective.weighs_time() { details.horizon_s } else { details.cost }
}

/// The limits of accelerations and jerks, with which the duration of a motion is that of a real arm.
fn limited(goal: Value, objective: &str) -> Value {
    let keys = json!({
        "objective": objective, "robot_shape": "joint_frames",
        "enforced_limits": { "acceleration": 5.0, "jerk": 100.0 },
        "q_start": [0.2, 0.4, 0.1, 1.5, -0.2, 1.1, 0.3],
    });
    with(kinova(goal), keys)
}

proptest! {
    #![proptest_config(crate::common::config(4))]

    /// A set of poses contains the configuration from which its pose was made, so the motion to it costs no more,
    /// whatever the objective, near or far away; and where the horizon is an unknown its first guess changes nothing.
    #[test]
    fn a_goal_by_pose_costs_no_more_than_a_configuration_in_it(
        change in proptest::array::uniform7(-1.0..1.0),
        size in prop_oneof![0.02..0.1, 0.3..0.6, 1.0..1.5],
        objective in prop_oneof![Just("least-time"), Just("balanced"), Just("least-effort")],
        guess in 0.3..6.0,
    ) {
        let start = limited(json!([]), objective);
        let from = start["q_start"].as_array().expect("a list").iter().map(|q| q.as_f64().expect("a number"));
        let q: Vec<f64> = from.zip(change).map(|(q, change)| q + size * change).collect();
        let by_joints = with(start, json!({ "q_goal": q, "v_goal": vec![0.0; 7] }));
        let by_pose = limited(pose_at(&q), objective);
        let [joints, pose] = [cost("joints", &by_joints), cost("pose", &by_pose)];
        prop_assert!(pose <= 1.02 * joints, "{pose} {joints}");
        if objective != "least-effort" {
            let guessed = cost("guessed", &with(by_pose, json!({ "horizon_s": guess })));
            prop_assert!((guessed / pose - 1.0).abs() < 0.02, "{guessed} {pose}");
        }
    }
}

/// If the start is in the goal, the motion stays there for the shortest time.
#[test]
fn a_start_in_the_goal_is_at_once_the_end() {
    let start = limited(json!([]), "least-time");
    let q = start["q_start"].clone();
    let at: Vec<f64> = serde_json::from_value(q.clone()).expect("numbers");
    for objective in ["least-time", "balanced"] {
        let by_joints = with(limited(json!([]), objective), json!({ "q_goal": q, "v_goal": vec![0.0; 7] }));
        for scenario in [by_joints, limited(pose_at(&at), objective)] {
            let duration = cost("stay", &scenario);
            assert!(duration < 0.01, "{objective} {duration}");
        }
    }
}

/// Equal points on a given horizon are a motion at rest, or nearly so: gravity is cheaper elsewhere.
#[test]
fn a_start_that_is_waypoint_and_goal_is_solved() {
    let q = json!([0.2, 0.4, 0.1, 1.5, -0.2, 1.1, 0.3]);
    let equal = json!({ "q_goal": q, "v_goal": vec![0.0; 7], "waypoints": [{ "q": q }, { "q": q, "stop": true }] });
    assert!(cost("equal", &with(limited(json!([]), "least-effort"), equal)) > 0.0);
}
