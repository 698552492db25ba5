//! Given accelerations at the ends, so that one motion continues another.

use crate::written::{failures, load, sampled, solved_once, with};
use aghf::curve::Curve;
use aghf::direct::DirectSettings;
use aghf_scenario::judge::{Check, Outcome, Tolerances, judge};
use aghf_scenario::{RestOptions, Scenario, Solve, SolveOptions, SolveReport};
use proptest::prelude::*;
use serde_json::{Value, json};

const N: usize = 7;

fn arm(keys: Value) -> Value {
    let zeros = [0.0; N];
    let base = json!({
        "robot": "kinova_gen3", "horizon_s": 2.0, "robot_shape": "joint_frames",
        "q_start": [0.0, 0.5, 0.0, 1.6, 0.0, 1.0, 0.0], "v_start": zeros,
        "q_goal": [0.8, 0.9, 0.2, 1.9, 0.0, 0.9, 0.0], "v_goal": zeros,
        "enforced_limits": { "acceleration": 4.0, "jerk": 40.0 },
    });
    with(base, keys)
}

/// The acceleration at the start or the end of a curve.
fn acceleration(curve: &Curve, is_end: bool) -> Vec<f64> {
    let (_, rates) = curve.at(if is_end { curve.horizon() } else { 0.0 });
    rates.as_slice()[N..].to_vec()
}

/// The outcome of the judge about accelerations, of a motion that is valid, and certified but for what the search
/// accepts.
fn judged(scenario: &Scenario, report: &SolveReport) -> Outcome {
    for failure in failures(scenario, report) {
        let accepted = DirectSettings::FEASIBLE * failure.bound.abs().max(1.0);
        assert!((failure.value - failure.bound).abs() <= accepted, "{failure:?}");
    }
    let judgement = judge(scenario, &sampled(scenario, report), Tolerances::default()).expect("its joints");
    assert!(judgement.valid, "{judgement:?}");
    judgement.checks.iter().find(|row| row.check == Check::Continuity).expect("it is checked").outcome
}

proptest! {
    #![proptest_config(crate::common::config(3))]

    /// A motion that passes a configuration at a velocity, and one that starts there with the acceleration of the
    /// first: by each objective, within limits of acceleration and jerk, the joint motion has no jump.
    #[test]
    fn motions_join_in_acceleration(
        way in proptest::array::uniform7(-0.3..0.3), v in proptest::array::uniform7(-0.4..0.4),
        to in proptest::array::uniform7(-0.4..0.4),
        objective in prop::sample::select(vec!["least-effort", "least-time"]),
    ) {
        let from = [0.4, 0.7, 0.1, 1.7, 0.0, 0.95, 0.0];
        let about = |off: [f64; N]| -> Vec<f64> { from.iter().zip(off).map(|(q, off)| q + off).collect() };
        let middle = json!({ "q_goal": about(way), "v_goal": v, "objective": objective });
        let first = load("joined_first", &arm(middle)).expect("it is good");
        let before = solved_once(&first);
        judged(&first, &before);
        let a = acceleration(&before.curve, true);
        let keys = json!({ "q_start": about(way), "v_start": v, "a_start": a, "q_goal": about(to),
            "objective": objective });
        let second = load("joined_second", &arm(keys.clone())).expect("it is good");
        let after = solved_once(&second);
        prop_assert_eq!(judged(&second, &after), Outcome::Pass);
        let largest = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let jump = largest(&acceleration(&after.curve, false), &a);
        prop_assert!(jump < 1e-6, "{jump}");
        // The motion is no other scenario's.
        let other: Vec<f64> = a.iter().map(|a| a + 2e-3).collect();
        let other = load("joined_other", &arm(with(keys, json!({ "a_start": other })))).expect("it is good");
        prop_assert!(failures(&other, &after).iter().any(|failure| failure.promise == "start acceleration"));
    }
}

/// An end at rest in a given acceleration, and an end at speed in none.
#[test]
fn a_goal_has_its_acceleration_too() {
    let a = [0.5, -0.5, 0.2, 0.0, 0.1, 0.3, -0.2];
    for keys in [
        json!({ "a_goal": a }),
        json!({ "a_goal": [0, 0, 0, 0, 0, 0, 0], "v_goal": a }),
        json!({ "a_goal": a, "free_final_velocity": true }),
        json!({ "a_goal": a, "goal": { "frame": "end_effector_link", "position_m": [0.4, 0.2, 0.5] } }),
    ] {
        let wanted: Vec<f64> = serde_json::from_value(keys["a_goal"].clone()).expect("numbers");
        let scenario = load("goal", &arm(keys)).expect("it is good");
        let report = solved_once(&scenario);
        let found = acceleration(&report.curve, true);
        assert!(found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-7), "{found:?}");
        assert_eq!(judged(&scenario, &report), Outcome::Pass);
    }
}

#[test]
fn accelerations_that_no_motion_has_are_refused() {
    let refused = |keys: Value, words: &str| {
        let scenario = load("refused", &arm(keys)).expect("it is good");
        let error = Solve::new(&scenario).run().expect_err("it is refused").to_string();
        assert!(error.contains(words), "{error}");
    };
    let push = |a: f64| [0.0, a, 0.0, 0.0, 0.0, 0.0, 0.0];
    refused(json!({ "a_start": push(4.1) }), "a_start: joint 'joint_2' has 4.1 rad/s^2, its enforced acceleration");
    let strong = json!({ "a_goal": push(600.0), "enforced_limits": { "torque": true } });
    refused(strong, "N m for the given acceleration, its enforced torque limit is");
    let scenario = load("flow", &arm(json!({ "a_goal": push(0.0), "enforced_limits": {} }))).expect("it is good");
    let error = Solve::new(&scenario)
        .options(SolveOptions::Duals(RestOptions::default()))
        .run()
        .expect_err("it is refused")
        .to_string();
    assert!(error.contains("a_goal: supported by the method 'direct' only"), "{error}");
}
