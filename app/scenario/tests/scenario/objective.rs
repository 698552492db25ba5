//! The keys of a scenario that say what the direct method is to find: read and solved.

use crate::written::load;
use aghf_scenario::{Details, DirectDetails, DirectOptions, FlowOptions, Solve, SolveReport};
use serde_json::{Value, json};

/// A scenario without what may be left out.
fn plain() -> Value {
    json!({
        "robot": "pendulum_2", "horizon_s": 1.5,
        "q_start": [0.0, 0.0], "v_start": [0.0, 0.0], "q_goal": [1.0, 0.5], "v_goal": [0.0, 0.0],
    })
}

/// The same with some keys more.
fn with(keys: Value) -> Value {
    let mut scenario = plain();
    for (key, value) in keys.as_object().expect("it is one") {
        scenario[key] = value.clone();
    }
    scenario
}

fn solved(name: &str, keys: Value) -> (SolveReport, DirectDetails) {
    let scenario = load(name, &with(keys)).expect("it is good");
    let options = DirectOptions {
        degree: Some(9),
        // So many that what is compared are the best minima of each scenario.
        starts: Some(24),
        ..Default::default()
    };
    let outcome = Solve::new(&scenario).options(options.clone()).run().expect("it is good");
    let Details::Direct(details) = outcome.summary.details.clone() else {
        panic!("it is a direct solve");
    };
    assert!(outcome.summary.success, "{:?}", outcome.summary);
    (outcome, *details)
}

#[test]
fn the_horizon_is_that_of_all_pieces() {
    let scenario = load("pieces", &plain()).expect("it is good");
    let options = DirectOptions { degree: Some(6), segments: Some(2), starts: Some(1), ..Default::default() };
    let outcome = Solve::new(&scenario).options(options.clone()).run().expect("it is good");
    let Details::Direct(details) = outcome.summary.details else {
        panic!("it is a direct solve");
    };
    assert_eq!(details.horizon_s, 1.5);
}

#[test]
fn what_a_file_says_is_kept() {
    let keys = json!({
        "free_final_velocity": true,
        "objective": {
            "units": "si", "time": 4.0, "effort": [1.0, 0.5], "velocity": 0.25, "acceleration": 0.0, "jerk": 0.0,
        },
        "free_horizon": { "shortest_s": 0.5, "longest_s": 3.0 },
    });
    let file = load("kept", &with(keys.clone())).expect("it is good").file;
    let again = serde_json::to_value(&file).expect("numbers");
    for (key, value) in keys.as_object().expect("it is one") {
        assert_eq!(&again[key], value, "{key}");
    }
    let short = with(json!({ "objective": { "velocity": [1.0, 2.0] } }));
    let cost = load("short", &short).expect("it is good").file.objective;
    let cost = serde_json::to_value(cost).expect("numbers");
    let all = json!({
        "units": "scaled", "time": 0.0, "effort": 1.0, "velocity": [1.0, 2.0], "acceleration": 0.0, "jerk": 0.0,
    });
    assert_eq!(cost, all);
    let file = serde_json::to_value(load("plain", &plain()).expect("it is good").file);
    let file = file.expect("numbers");
    for key in ["free_final_velocity", "objective", "free_horizon"] {
        assert_eq!(file.get(key), None, "what is not asked for is not written");
    }
}

#[test]
fn the_flow_refuses_what_it_does_not_know() {
    let flow = FlowOptions::default();
    for keys in
        [json!({ "free_final_velocity": true }), json!({ "free_horizon": { "shortest_s": 1.0, "longest_s": 2.0 } })]
    {
        let key = keys.as_object().expect("it is one").keys().next();
        let key = key.expect("there is one").clone();
        let scenario = load("flow", &with(keys)).expect("it is good");
        let error = Solve::new(&scenario).options(flow.clone()).run().expect_err("the flow has no such key");
        let words = format!("flow: {key}: supported by the method 'direct' only, not by 'flow'");
        assert!(error.to_string().starts_with(&words), "{error}");
    }
}

/// It finds the motion that it finds without, and says so.
#[test]
fn the_flow_minimises_the_effort_alone_with_a_note() {
    let weights = json!({ "objective": { "units": "si", "acceleration": 1.0 } });
    let [alone, weighted] = [("effort", plain()), ("weighted", with(weights))].map(|(name, file)| {
        let flow = FlowOptions { k: Some(1e5), s_max: Some(10.0), ..Default::default() };
        let scenario = load(name, &file).expect("it is good");
        Solve::new(&scenario).options(flow.clone()).run().expect("it is good")
    });
    assert_eq!(weighted.curve.x(), alone.curve.x());
    let [end] = &alone.summary.notes[..] else {
        panic!("{:?}", alone.summary.notes);
    };
    assert!(end.contains("which is no minimum"), "{end}");
    let note = "objective: the published flow minimises the control effort alone";
    assert_eq!(weighted.summary.notes, [note, end]);
    let (direct, _) = solved("direct", json!({ "objective": { "units": "si", "acceleration": 1.0 } }));
    assert_eq!(direct.summary.notes, [""; 0], "the direct method knows it");
}

/// The summary tells what was minimised and what was found.
#[test]
fn what_was_found_is_told() {
    let (plain, details) = solved("fixed", json!({}));
    assert_eq!(details.horizon_s, 1.5);
    let effort = plain.summary.control_effort;
    // The quadratures agree to 1e-3.
    assert!((details.cost - effort).abs() < 2e-3 * effort);

    let (free, details) = solved("velocity", json!({ "free_final_velocity": true }));
    assert!((details.cost - free.summary.control_effort).abs() < 2e-3 * effort);
    assert!(free.summary.control_effort < effort);
    let end = free.curve.x().column(9);
    assert!(end.as_slice()[..2] == [1.0, 0.5] && end.rows(2, 2).amax() > 0.1);

    let weights = json!({ "units": "si", "effort": 2.0, "velocity": 30.0 });
    let (slow, details) = solved("cost", json!({ "objective": weights }));
    let cost = details.cost;
    assert!(slow.summary.control_effort > effort && cost > 2.0 * slow.summary.control_effort);

    let bounds = json!({ "shortest_s": 0.4, "longest_s": 2.5 });
    let timed = json!({ "units": "si", "time": 600.0 });
    let (found, details) = solved("horizon", json!({ "free_horizon": bounds, "objective": timed }));
    let horizon = details.horizon_s;
    assert_eq!(horizon, found.curve.chebyshev(0).horizon());
    assert!(horizon > 0.4 && horizon < 1.5, "{horizon}");
    let total = found.summary.control_effort + 600.0 * horizon;
    assert!((details.cost - total).abs() < 2e-3 * total);
    assert!(total < effort + 600.0 * 1.5);

    // All at once, and above a floor: the robot has no limits.
    let all = json!({
        "free_final_velocity": true, "objective": { "units": "si", "time": 600.0, "velocity": 1.0 },
        "free_horizon": bounds, "obstacles": [{ "shape": { "half_space": {} },
        "pose": { "position_m": [0.0, 0.0, -1.9] } }],
    });
    let (_, details) = solved("all", all);
    assert!(details.horizon_s < 1.5 && details.largest_violation.is_some());
}
