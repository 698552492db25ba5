//! A tracker that owns its scenario.

use crate::common::assert_refused;
use crate::written::load;
use aghf::direct::{Outcome, Safety};
use aghf::motion::Interrupt;
use aghf_scenario::{Obstacle, ScenarioTracker, ScenarioTrackerOptions};
use serde_json::{Value, json};

/// An arm with a ball at a height, changed.
fn arm(height: f64, change: impl Fn(&mut Value)) -> Value {
    let zeros = [0.0; 7];
    let mut file = json!({
        "robot": "kinova_gen3", "horizon_s": 1.2, "robot_shape": "joint_frames",
        "q_start": [0.0, 0.6, 0.0, 1.6, 0.0, 0.8, 0.0], "v_start": zeros,
        "q_goal": [0.5, 0.9, 0.0, 1.2, 0.0, 0.8, 0.0], "v_goal": zeros,
        "obstacles": [ball(height)], "clearance_m": { "obstacles": 0.05 },
    });
    change(&mut file);
    file
}

fn ball(height: f64) -> Value {
    json!({ "name": "ball", "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [0.5, 0.0, height] } })
}

fn obstacles(list: Value) -> Vec<Obstacle> {
    serde_json::from_value(list).expect("they are obstacles")
}

fn tracker(file: &Value, options: Value) -> aghf::Result<ScenarioTracker> {
    let options: ScenarioTrackerOptions = serde_json::from_value(options).expect("options");
    let scenario = load("arm", file).expect("it is a scenario");
    ScenarioTracker::new(scenario, &options, Interrupt::default())
}

#[test]
fn a_tracker_of_a_scenario_arrives_at_a_moved_goal() {
    let mut tracker = tracker(&arm(2.0, |_| {}), json!({ "search": { "degree": 9 } })).expect("good");
    let file = tracker.scenario().file.clone();
    let (mut state, mut goal) = ([file.q_start, file.v_start].concat(), file.q_goal);
    for k in 0..2000 {
        if k == 20 {
            goal[0] += 0.1;
            tracker.set_goal(&goal, 1.0).expect("it is good");
        }
        let step = tracker.step(&state, 0.004 * f64::from(k)).expect("good");
        state = [&step.command.q[..], &step.command.v].concat();
        assert_eq!(step.safety, Safety::Kept);
        if k > 20 && step.outcome == Outcome::Finished {
            let error = state.iter().zip(&goal).map(|(x, goal)| (x - goal).abs());
            assert!(error.fold(0.0, f64::max) < 1e-9);
            return;
        }
    }
    panic!("it never finished");
}

/// Obstacles keep the clearance of the scenario, and may become more or fewer.
#[test]
fn moved_obstacles_are_kept_clear_of() {
    let file = arm(2.0, |_| {});
    let mut tracker = tracker(&file, json!({ "search": { "degree": 9 } })).expect("good");
    let state = [tracker.scenario().file.q_start.clone(), vec![0.0; 7]].concat();
    assert_eq!(tracker.step(&state, 0.0).expect("good").safety, Safety::Kept);
    // The tool is at a height of 0.28 m, at a distance of 0.52 m.
    for (height, list) in [(0.41, json!([ball(0.41), ball(2.0)])), (0.2, json!([ball(0.2)]))] {
        tracker.set_obstacles(&obstacles(list)).expect("good");
        let Safety::Violated { row, by, .. } = tracker.step(&state, 0.0).expect("good").safety else {
            panic!("the ball at {height} is too near");
        };
        assert!(by > 1e-3, "{by}");
        assert!(tracker.label(row).quantity.is_clearance());
    }
    tracker.set_obstacles(&[]).expect("good");
    assert_eq!(tracker.step(&state, 0.0).expect("good").safety, Safety::Kept);
}

#[test]
fn a_scenario_that_cannot_be_tracked_is_refused() {
    let new = |change: &dyn Fn(&mut Value), options: Value| tracker(&arm(2.0, change), options).map(|_| ());
    let none = || json!({});
    let least_time = |file: &mut Value| file["objective"] = json!("least-time");
    assert_refused(new(&least_time, none()), "objective: it is 'least-time'");
    let moving = |file: &mut Value| file["v_goal"][1] = json!(0.5);
    assert_refused(new(&moving, none()), "joint 1 is not at rest");
    let point = |file: &mut Value| file["waypoints"] = json!([{ "q": file["q_start"] }]);
    assert_refused(new(&point, none()), "waypoints");
    assert_refused(new(&|_| {}, json!({ "deadline_s": -1.0 })), "deadline_s: it is -1");
    assert_refused(new(&|_| {}, json!({ "bandwidth": 0.0 })), "bandwidth");
    let unknown = serde_json::from_value::<ScenarioTrackerOptions>(json!({ "speed": 1.0 }));
    assert!(unknown.is_err_and(|error| error.to_string().contains("`speed`")));
    let mut tracker = tracker(&arm(2.0, |_| {}), json!({ "search": { "degree": 9 } })).expect("good");
    let mut bad = ball(2.0);
    bad["shape"]["sphere"]["radius_m"] = json!(-1.0);
    let refused = tracker.set_obstacles(&obstacles(json!([ball(2.0), bad])));
    assert_refused(refused, "obstacles[1]: radius_m has -1");
}
