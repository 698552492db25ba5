//! The least time, and the least effort in hardly more.

use crate::units::{cart, found, solved};
use crate::written::load;
use aghf_scenario::{HorizonBound, Quantity, Scenario};
use serde_json::json;

/// The least time of the cart, 2 kg, with 40 N: at 20 m/s^2 to 3 m/s, and as long to a stop.
const MIN_TIME: f64 = 1.5 / 3.0 + 3.0 / 20.0;

#[test]
fn the_least_time_is_near_that_of_full_force() {
    let file = cart(2.0, 40.0, json!({ "objective": "least-time", "continuity": "velocity" }));
    let details = solved("fast", &file);
    let ratio = details.horizon_s / MIN_TIME;
    assert!((1.0..1.06).contains(&ratio), "{ratio}");
    let bound = HorizonBound { least_s: 0.5, joint: "rail".to_owned(), limit: Quantity::Velocity };
    assert_eq!(details.horizon_bound, Some(bound));
    // A weight of time alone is the same.
    let alone = json!({ "objective": { "time": 3.0, "effort": 0.0 }, "continuity": "velocity" });
    let same = solved("alone", &cart(2.0, 40.0, alone));
    assert_eq!(same.horizon_s, details.horizon_s);
}

#[test]
fn limits_of_acceleration_and_jerk_bound_the_least_time() {
    let keys = json!({
        "objective": "least-time", "enforced_limits": { "acceleration": 10.0, "jerk": 200.0 },
    });
    let details = solved("smooth", &cart(2.0, 40.0, keys));
    let bound = details.horizon_bound.expect("it has limits");
    assert_eq!(bound.limit, Quantity::Acceleration);
    let ratio = details.horizon_s / bound.least_s;
    assert!((1.0..1.3).contains(&ratio), "{ratio}");
}

#[test]
fn a_balanced_motion_takes_hardly_longer_and_less_effort() {
    let [fast, balanced] = ["least-time", "balanced"].map(|objective| {
        let mut scenario = Scenario::load("limits_01").expect("generated");
        scenario.file.objective = serde_json::from_value(json!(objective)).expect("a preset");
        found(&scenario)
    });
    let ratio = balanced.horizon_s / fast.horizon_s;
    assert!((1.0..1.25 + 1e-6).contains(&ratio), "{ratio}");
    assert!(balanced.cost < 0.95 * fast.cost, "{} {}", balanced.cost, fast.cost);
}

#[test]
fn a_bound_of_the_horizon_is_kept() {
    let keys = json!({
        "objective": "least-time", "free_horizon": { "shortest_s": 0.9, "longest_s": 2.0 },
    });
    let details = solved("bound", &cart(2.0, 40.0, keys));
    assert!((details.horizon_s - 0.9).abs() < 1e-5, "{}", details.horizon_s);
}

/// The goal is one of two sets, and the end may move in it.
#[test]
fn the_goal_of_a_set_is_reached_in_least_time() {
    let pose = |x: f64| json!({ "frame": "cart", "position_m": [x, 0.0, 0.0], "tolerance_m": 0.01 });
    let mut file = cart(2.0, 40.0, json!({ "objective": "least-time", "continuity": "velocity" }));
    let keys = file.as_object_mut().expect("it is one");
    for key in ["q_goal", "v_goal"] {
        keys.remove(key);
    }
    file["goal"] = json!([pose(1.5), pose(-0.8)]);
    let scenario = load("set", &file).expect("it is good");
    let details = found(&scenario);
    let end = details.end.expect("the goal is a set");
    assert_eq!(end.goal, 1, "the nearer one");
    let least = 2.0 * (0.79_f64 / 20.0).sqrt();
    let ratio = details.horizon_s / least;
    assert!((1.0..1.1).contains(&ratio), "{ratio}");
    assert!(end.q[0] > -0.81 - 1e-6 && end.q[0] < -0.78, "{:?}", end.q);
}

/// A search for a faster motion that comes to no end is done again with a larger penalty, which finds one: without that
/// this motion takes 1.154 s.
#[test]
fn a_search_that_finds_no_minimum_is_done_again() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda/scenarios/table_under_pick_0080.json");
    let mut scenario = Scenario::load(file).expect("in the folder");
    scenario.file.objective = serde_json::from_value(json!("balanced")).expect("a preset");
    let details = found(&scenario);
    assert!(details.horizon_s < 1.152, "{}", details.horizon_s);
}
