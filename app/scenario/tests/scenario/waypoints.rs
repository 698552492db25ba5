//! Points on the way, as written in a file.

use crate::written::{load, solved_once, with};
use aghf_scenario::{Details, Quantity};
use serde_json::{Value, json};

const FAR: [f64; 7] = [0.6, 0.3, 0.2, 1.1, 0.1, 0.4, 0.1];

/// A motion of the Kinova from rest back to where it was.
fn back(keys: Value) -> Value {
    let (q, v) = ([0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0], [0.0; 7]);
    let scenario = json!({
        "robot": "kinova_gen3", "horizon_s": 3.0,
        "q_start": q, "v_start": v, "q_goal": q, "v_goal": v,
    });
    with(scenario, keys)
}

/// There and back, over a pose: the summary has the times, and the motion is there at them.
#[test]
fn a_motion_passes_its_points() {
    let poses = json!({ "frame": "end_effector_link", "position_m": [0.4, 0.2, 0.5] });
    let points = json!([{ "q": FAR, "stop": true }, { "poses": poses }]);
    let scenario = load("back", &back(json!({ "waypoints": points }))).expect("it is good");
    let report = solved_once(&scenario);
    let Details::Direct(details) = &report.summary.details else {
        panic!("it is by the direct method");
    };
    let [first, second] = details.waypoint_times_s[..] else {
        panic!("{:?}", details.waypoint_times_s);
    };
    assert!(0.0 < first && first < second && second < 3.0);
    let (x, _) = report.curve.at(first);
    for (i, far) in FAR.iter().enumerate() {
        assert!((x[i] - far).abs() < 1e-5 && x[7 + i].abs() < 1e-5, "{x}");
    }
}

/// The least horizon counts the ways there and back.
#[test]
fn the_least_horizon_is_there_and_back() {
    let one = load("there", &back(json!({ "q_goal": FAR }))).expect("it is good");
    let both = load("both", &back(json!({ "waypoints": [{ "q": FAR }] }))).expect("it is good");
    let (joint, limit, there) = one.least_horizon().expect("joints have limits");
    assert_eq!(limit, Quantity::Velocity);
    assert_eq!(both.least_horizon(), Some((joint, limit, 2.0 * there)));
    assert!(load("stay", &back(json!({}))).expect("it is good").least_horizon().is_none());
}

/// A first guess of poses is looked for, and configurations are checked before any search.
#[test]
fn guesses_are_in_the_set_and_points_are_checked() {
    let poses = |x: f64| json!([{ "poses": { "frame": "end_effector_link", "position_m": [x, 0.2, 0.5] } }]);
    let scenario = load("guess", &back(json!({ "waypoints": poses(0.4) }))).expect("it is good");
    let waypoints = scenario.waypoints_with_guesses().expect("it is reachable");
    assert!(!waypoints[0].guesses.is_empty() && waypoints[0].guesses[0] != scenario.file.q_start);
    let far = load("far", &back(json!({ "waypoints": poses(4.0) }))).expect("it is good");
    let error = far.waypoints_with_guesses().expect_err("it is beyond the reach").to_string();
    assert!(error.contains("waypoints[0]") && error.contains("add up to"), "{error}");
    let mut beyond = FAR;
    beyond[1] = 3.0;
    let beyond = load("beyond", &back(json!({ "waypoints": [{ "q": FAR }, { "q": beyond }] })));
    let error = beyond.expect("it is read").waypoints_with_guesses();
    let error = error.expect_err("it is beyond a limit").to_string();
    assert!(error.contains("waypoints[1]") && error.contains("joint_2"), "{error}");
}

/// A point has one of its two keys, and as many entries as the robot has joints.
#[test]
fn refuses_what_is_no_point() {
    let refused = |name: &str, points: Value, words: &str| {
        let error = load(name, &back(json!({ "waypoints": points }))).expect_err(words);
        assert!(error.contains("waypoints[0]") && error.contains(words), "{error}");
    };
    refused("none", json!([{}]), "one of the keys q and poses");
    refused("short", json!([{ "q": [1.0] }]), "7");
}
