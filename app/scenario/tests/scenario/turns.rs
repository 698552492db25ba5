//! The way of continuous joints.

use crate::written::{load, with};
use aghf_scenario::{DirectOptions, Solve};
use serde_json::{Value, json};

fn swing(keys: Value) -> Value {
    let swing = json!({
        "robot": "pendulum_2", "horizon_s": 3.0, "q_start": [3.1, 0.0], "v_start": [0.0, 0.0],
        "q_goal": [-3.1, 0.5], "v_goal": [0.0, 0.0],
    });
    with(swing, keys)
}

/// By default a continuous joint goes to the nearest position that is the same place, with a note, and the motion ends
/// there; a scenario that was read is the same when it is read again.
#[test]
fn a_continuous_joint_takes_the_short_way() {
    let scenario = load("turns", &swing(json!({}))).expect("it is good");
    let nearest = 2.0 * std::f64::consts::PI - 3.1;
    assert_eq!(scenario.file.q_goal, [nearest, 0.5]);
    let options = DirectOptions { starts: Some(1), ..DirectOptions::default() };
    let report = Solve::new(&scenario).options(options).run().expect("it is good");
    let words = "q_goal: continuous joint 'joint_1' goes to 3.183185307179586, 0.0832 rad away, which is the same \
                 place as -3.1, 6.2 rad away; with \"turns\": \"as_given\" it goes there";
    assert_eq!(report.summary.notes, [words]);
    assert!((report.curve.at(3.0).0[0] - nearest).abs() < 1e-9);
    let written = serde_json::to_value(&scenario.file).expect("numbers");
    let again = load("turns", &written).expect("it is good");
    assert_eq!(again.file, scenario.file);
    assert!(again.problem().is_ok_and(|p| p.goal()[0] == nearest));
}

/// A position that is meant as given stays, and so do those that are the nearest.
#[test]
fn turns_as_given_are_kept() {
    for (keys, first) in [
        (json!({ "turns": "as_given" }), -3.1),
        (json!({ "q_goal": [3.1832, 0.5] }), 3.1832),
        (json!({ "q_goal": [0.5, 0.5] }), 0.5),
        (json!({ "q_goal": [1e134, 0.5] }), 1e134),
        (json!({ "q_start": [0.0, 0.0], "q_goal": [std::f64::consts::PI, 0.5] }), std::f64::consts::PI),
    ] {
        let file = load("turns", &swing(keys)).expect("it is good").file;
        assert_eq!(file.q_goal, [first, 0.5]);
        let written = serde_json::to_value(&file).expect("numbers");
        assert_eq!(load("turns", &written).expect("it is good").file, file);
    }
}

/// The positions of a revolute joint are different places of its cables, so none is replaced.
#[test]
fn revolute_joints_go_where_they_are_sent() {
    let zeros = [0.0; 7];
    let file = load(
        "turns",
        &json!({
            "robot": "kinova_gen3", "horizon_s": 5.0, "q_start": [3.1, 0, 0, 0, 0, 0, 0], "v_start": zeros,
            "q_goal": [-3.1, 0, 0, 0, 0, 0, 0], "v_goal": zeros,
        }),
    );
    assert_eq!(file.expect("it is good").file.q_goal[0], -3.1);
}

/// Waypoints count from the point before, and the goal from the last one.
#[test]
fn waypoints_take_the_short_way() {
    let points = json!({ "waypoints": [{ "q": [-3.0, 7.0] }, { "q": [-2.0, 0.0] }] });
    let file = load("turns", &swing(points)).expect("it is good").file;
    let turn = 2.0 * std::f64::consts::PI;
    let points: Vec<_> = file.waypoints.iter().map(|point| point.q.clone().expect("a configuration")).collect();
    assert_eq!(points, [[turn - 3.0, 7.0 - turn], [turn - 2.0, 0.0]]);
    assert_eq!(file.q_goal, [turn - 3.1, 0.5]);
}

#[test]
fn other_words_are_refused() {
    let error = load("turns", &swing(json!({ "turns": "long" }))).expect_err("no such way");
    assert!(error.to_string().contains("turns"), "{error}");
}
