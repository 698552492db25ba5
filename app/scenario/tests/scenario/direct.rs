//! Solves by the direct method of scenarios with obstacles, limits and a free horizon.

use crate::common::direct::solved_within;
use crate::written::{load, with};
use aghf::direct::{DirectSettings, FreeHorizon};
use aghf_scenario::{Details, DirectOptions, Scenario, Solve, Verdict};
use serde_json::json;

#[test]
fn an_arm_among_spheres_keeps_clear() {
    let scenario = Scenario::load("kinova_obstacles_01").expect("built in");
    let outcome = Solve::new(&scenario).run().expect("valid");
    let summary = outcome.summary;
    assert!(summary.success, "{summary:?}");
    assert!(summary.control_effort < 29.0, "{summary:?}");
    let clearance = summary.feasibility.smallest_clearance_m;
    assert!(clearance.is_some_and(|m| m >= -1e-6), "{clearance:?}");
}

/// Here the first start does not end at a minimum within the constraints, and one of the next does. What is told of is
/// the best of those that did.
#[test]
fn what_converged_is_told_of_rather_than_what_stalled() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda/scenarios/table_under_pick_0080.json");
    let scenario = Scenario::load(file).expect("it is there");
    let report = Solve::new(&scenario).run().expect("valid");
    let Details::Direct(details) = &report.summary.details else {
        panic!("it is a direct solve");
    };
    assert!(details.start_costs.len() > 1, "the first start did not stall, find another scenario");
    assert!(report.summary.success, "{:?}", report.summary);
    assert_eq!(details.minima[0].cost, details.cost);
    assert!(details.minima.is_sorted_by(|a, b| a.cost < b.cost));
}

#[test]
fn an_arm_keeps_clear_on_pieces() {
    let scenario = Scenario::load("kinova_obstacles_01").expect("built in");
    let options = DirectOptions { degree: Some(9), segments: Some(2), ..Default::default() };
    let summary = Solve::new(&scenario).options(options.clone()).run().expect("valid").summary;
    assert!(summary.success && (summary.segments, summary.degree) == (2, 9), "{summary:?}");
}

/// A longest horizon beyond a feasible one never costs more, although the motion on one horizon breaks limits on a
/// shorter one.
#[test]
fn a_free_horizon_within_limits_costs_no_more_than_a_given_one() {
    let mut scenario = Scenario::load("limits_11").expect("generated");
    let given = scenario.file.horizon_s;
    let weight = 100.0;
    let solved = |scenario: &Scenario, free_horizon| {
        let settings = DirectSettings { starts: 1, free_horizon, ..DirectSettings::constrained() };
        let kept = scenario.constraints();
        let problem = scenario.problem().expect("valid");
        let solution = solved_within(&problem, &settings, &kept);
        assert!(solution.converged, "{solution:?}");
        solution.cost + weight * solution.curve.horizon()
    };
    let at_the_given = solved(&scenario, None);
    scenario.file.horizon_s = 1.6 * given;
    let free = FreeHorizon { shortest: 0.5 * given, longest: 4.0 * given, weight };
    let at_the_best = solved(&scenario, Some(free));
    assert!(at_the_best <= at_the_given, "{at_the_best} {at_the_given}");
}

/// An obstacle that no motion comes near is as none: the same starts, points and bits.
#[test]
fn a_far_obstacle_changes_nothing() {
    let ball = json!({
        "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [10.0, 10.0, 10.0] },
    });
    for name in ["kinova_free_01", "kinova_free_04", "pendulum_3_swingup"] {
        let free = Scenario::load(name).expect("built in");
        let keys = serde_json::to_value(&free.file).expect("numbers");
        let far = load(name, &with(keys, json!({ "obstacles": [ball] }))).expect("it is good");
        let [free, far] = [free, far].map(|scenario| {
            let report = Solve::new(&scenario).run().expect("valid");
            assert!(report.summary.success, "{name}");
            report
        });
        assert_eq!(free.curve.x(), far.curve.x(), "{name}");
        assert_eq!(free.summary.control_effort, far.summary.control_effort);
    }
}

/// A motion between states so far apart that its torques overflow is not valid.
#[test]
fn a_motion_whose_torques_overflow_is_not_valid() {
    let scenario = json!({
        "robot": "pendulum_2", "horizon_s": 2.0,
        "q_start": [-1e134, 0], "v_start": [0, 0], "q_goal": [1.0, 0.5], "v_goal": [0, 0],
        "enforced_limits": { "position": false, "velocity": false, "torque": false }
    });
    let scenario = load("far", &scenario).expect("it is good");
    let options = DirectOptions { starts: Some(1), ..Default::default() };
    let report = Solve::new(&scenario).options(options).run();
    let summary = report.expect("a result").summary;
    assert_eq!(summary.verdict, Verdict::NotValid);
    let failure = summary.failure.expect("there are reasons");
    assert!(failure.contains("torques of the motion are not finite"), "{failure}");
}

/// The cost of a motion that breaks its limits is that of the motion, and of the iterate that it comes from.
#[test]
fn the_cost_of_a_motion_that_is_not_valid_is_its_own() {
    let link = "link_1";
    let scenario = json!({
        "robot": "pendulum_2", "horizon_s": 1.0,
        "q_start": [0, 0], "v_start": [0, 0], "q_goal": [1.0, 0.5], "v_goal": [0, 0],
        "keep": [{ "speed": { "frame": link, "point_m": [0, 0, -0.5], "most_m_s": 0.1 } }]
    });
    let scenario = load("slow", &scenario).expect("it is good");
    let summary = Solve::new(&scenario).run().expect("a result").summary;
    let Details::Direct(details) = &summary.details else {
        panic!("it is a direct solve");
    };
    assert_eq!(summary.verdict, Verdict::NotValid);
    let apart = (details.cost / summary.control_effort - 1.0).abs();
    assert!(apart < 1e-3, "{} and {}", details.cost, summary.control_effort);
    // The excess is a speed: the point has to be faster than half a radian per second on average.
    let speed = &summary.feasibility.limit_violations[0];
    assert!(speed.unit == "m/s" && (0.2..3.0).contains(&speed.by), "{speed}");
}

/// A kept speed bounds the time too.
#[test]
fn a_kept_speed_has_a_least_time() {
    let scenario = json!({
        "robot": "pendulum_2", "horizon_s": 3.0, "objective": "least-time",
        "q_start": [0, 0], "v_start": [0, 0], "q_goal": [0.4, 0.2], "v_goal": [0, 0],
        "keep": [{ "speed": { "frame": "link_1", "point_m": [0, 0, -0.5], "most_m_s": 0.5 } }]
    });
    load("fast", &scenario).expect("it is accepted");
}
