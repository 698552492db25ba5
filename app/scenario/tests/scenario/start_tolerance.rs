//! Starts a little outside of limits of positions.

use crate::written::{failures, load, sampled, solved_once, with};
use aghf::constraint::Bounds;
use aghf::curve::Curve;
use aghf_scenario::judge::{Tolerances, judge};
use aghf_scenario::{Quantity, Scenario, ScenarioTracker, ScenarioTrackerOptions};
use proptest::prelude::*;
use serde_json::{Value, json};

/// The limits of two joints of the arm, rad, and their indices.
const LIMITS: [(usize, f64); 2] = [(1, 2.25), (3, 2.58)];

/// An arm that starts with two joints beyond their upper or lower limits by these amounts.
fn outside(off: [f64; 2], keys: Value) -> Value {
    let mut start = [0.1, 0.5, 0.0, 1.6, 0.0, 0.5, 0.2];
    for ((joint, limit), off) in LIMITS.into_iter().zip(off) {
        start[joint] = off.signum() * limit + off;
    }
    let zeros = [0.0; 7];
    let base = json!({
        "robot": "kinova_gen3", "horizon_s": 4.0, "robot_shape": "joint_frames",
        "q_start": start, "v_start": zeros, "q_goal": [0.6, 0.4, 0.3, 1.2, 0.0, 0.9, 0.0], "v_goal": zeros,
        "enforced_limits": { "acceleration": 20.0 },
    });
    with(base, keys)
}

/// The largest distance of a joint from its limit between two times.
fn off(curve: &Curve, (joint, limit): (usize, f64), [from, to]: [f64; 2]) -> f64 {
    let times = (0..=1000).map(|k| from + (to - from) * f64::from(k) / 1000.0);
    times.map(|t| curve.at(t).0[joint].abs() - limit).fold(f64::NEG_INFINITY, f64::max)
}

proptest! {
    #![proptest_config(crate::common::config(4))]

    /// From outside by up to a hundredth, on either side, a motion goes no further out, is back in time, and is valid
    /// and certified; it is none of the scenario that accepts no such start.
    #[test]
    fn a_motion_returns_within_its_limits(
        exponents in proptest::array::uniform2(-6.0..-2.0), signs in any::<[bool; 2]>(), back in 0.1..0.4,
        objective in prop::sample::select(vec!["least-effort", "least-time"]),
    ) {
        let by: [f64; 2] = std::array::from_fn(|i| 10_f64.powf(exponents[i]) * if signs[i] { 1.0 } else { -1.0 });
        let tolerance = json!({ "position": 0.02, "back_s": back });
        let file = outside(by, json!({ "start_tolerance": tolerance, "objective": objective }));
        let scenario = load("outside", &file).expect("it is good");
        let report = solved_once(&scenario);
        let horizon = report.curve.horizon();
        prop_assert!(horizon >= back - 1e-9);
        for (of, by) in LIMITS.into_iter().zip(by) {
            prop_assert!(off(&report.curve, of, [0.0, horizon]) <= by.abs() + 5e-5);
            prop_assert!(off(&report.curve, of, [back, horizon]) <= 1e-6);
        }
        let notes = report.summary.notes.iter().filter(|note| note.contains("outside of its limit"));
        prop_assert_eq!(notes.count(), 2);
        let samples = sampled(&scenario, &report);
        let judged = |scenario: &Scenario| judge(scenario, &samples, Tolerances::default()).expect("its joints").valid;
        prop_assert!(judged(&scenario));
        prop_assert_eq!(failures(&scenario, &report), []);
        let mut strict = scenario.clone();
        strict.file.start_tolerance = None;
        // The judge accepts a thousandth.
        prop_assert!(by.iter().all(|by| by.abs() < 2e-3) || !judged(&strict));
        prop_assert!(failures(&strict, &report).iter().any(|failure| failure.promise == "position limits"));
    }
}

/// Without the key a start outside by the size of an encoder's error is accepted and one further out refused; the key
/// is in the scenario that was read.
#[test]
fn small_distances_are_accepted_by_default() {
    let read = |by: f64, keys: Value| load("default", &outside([by, by], keys));
    for by in [0.0, 5e-10] {
        assert_eq!(read(by, json!({})).expect("it is good").file.start_tolerance, None);
    }
    let scenario = read(-9e-5, json!({})).expect("it is good");
    scenario.check_feasible().expect("it may return");
    let start = scenario.file.start_tolerance.expect("it is completed");
    assert_eq!((start.position, start.back_s), (1e-4, 0.25));
    let bounds: Vec<_> = scenario.limits().into_iter().filter(|limit| limit.index == Some(1)).collect();
    let bounds = bounds.iter().filter(|limit| limit.quantity == Quantity::Position).map(|limit| limit.bounds);
    assert_eq!(bounds.collect::<Vec<_>>(), [[-2.25 - 9e-5 - 5e-5, 2.25], [-2.25, 2.25]]);
    for (by, keys) in [(2e-4, json!({})), (2e-5, json!({ "start_tolerance": { "position": 0.0 } }))] {
        let error = read(by, keys).expect("it is read").check_feasible().expect_err("it is too far out").to_string();
        assert!(error.contains("; a start_tolerance.position of "), "{error}");
    }
    let at_goal = json!({ "q_goal": [0.6, 2.25002, 0.3, 1.2, 0.0, 0.9, 0.0] });
    let error = read(2e-5, at_goal).expect("it is read").check_feasible().expect_err("no goal is").to_string();
    assert!(error.contains("q_goal: joint 'joint_2' has 2.25002 rad"), "{error}");
}

/// A scenario with another tolerance has its rows, as in a sweep, and keeps what was added in code.
#[test]
fn other_keys_have_their_own_rows() {
    let mut scenario = load("patched", &outside([1e-3; 2], json!({}))).expect("it is read");
    scenario.add_constraint(Bounds(Vec::new()));
    let rows = |scenario: &Scenario| scenario.constraints().stage.custom.iter().map(|rows| rows.dim()).sum::<usize>();
    assert_eq!((rows(&scenario), scenario.added_constraints()), (0, 1));
    let keys = json!({ "start_tolerance.position": 2e-3 });
    let accepted = scenario.with_keys(keys.as_object().expect("keys")).expect("it is good");
    assert_eq!((rows(&accepted), accepted.added_constraints()), (4, 1));
    let keys = json!({ "start_tolerance.position": 0.0 });
    let strict = accepted.with_keys(keys.as_object().expect("keys")).expect("it is read");
    assert_eq!((rows(&strict), strict.added_constraints()), (0, 1));
}

#[test]
fn tolerances_out_of_range_are_refused() {
    for (tolerance, words) in [
        (json!({ "position": -1e-3 }), "start_tolerance.position: it is -0.001 and must be"),
        (json!({ "back_s": 0.0 }), "start_tolerance.back_s: it is 0 and must be positive"),
        (json!({ "back_s": 4.0 }), "start_tolerance.back_s: it is 4 s, and horizon_s is 4 s"),
        (json!({ "clearance": 0.1 }), "start_tolerance.clearance: unknown field"),
    ] {
        let error = load("bad", &outside([1e-3; 2], json!({ "start_tolerance": tolerance }))).expect_err("refused");
        assert!(error.starts_with(words), "{error}");
    }
    let scenario = load("tracked", &outside([1e-5; 2], json!({}))).expect("it is good");
    let tracker = ScenarioTracker::new(scenario, &ScenarioTrackerOptions::default(), Default::default());
    let error = tracker.err().expect("it is refused").to_string();
    assert!(error.contains("it has to start within it"), "{error}");
    let slow = json!({ "start_tolerance": { "position": 0.9 } });
    let error =
        load("slow", &outside([0.8; 2], slow)).expect("it is read").check_feasible().expect_err("it is too far");
    let words = "start_tolerance.back_s: it is 0.25 s, and joint 'joint_2' is within its limit after 0.5";
    assert!(error.to_string().contains(words), "{error}");
}
