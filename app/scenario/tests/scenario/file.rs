//! Scenario files are read as they are written.

use crate::written::{folder, load_text, with};
use aghf::urdf::{UrdfOptions, load_robot_with};
use aghf_scenario::{EnforcedLimits, FlowOptions, ScenarioFile};
use serde_json::{Value, json};
use std::path::Path;

/// A scenario with many keys.
pub fn good() -> Value {
    json!({
        "robot": "pendulum_2", "horizon_s": 2.0,
        "q_start": [-1.5, 0.25], "v_start": [0.0, 0.5], "q_goal": [1.5, 0.75], "v_goal": [1.0, 0.0],
        "obstacles": [
            { "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [0.0, 3.0, 0.5] } },
            { "name": "floor", "shape": { "half_space": {} }, "pose": { "position_m": [0.0, 0.0, -3.0] } },
        ],
        "robot_shape": { "swept_links": { "radius_m": 0.1, "spacing_m": 0.2 } },
        "enforced_limits": { "position": true, "velocity": false, "torque": false },
        "flow": { "degree": 7, "k": 1e5, "s_max": 10.0, "guess": "line_state", "k_cons": 1e3, "c_cons": 4.0 },
        "feedback": { "kp": 10.0, "kv": 5.0 }, "success_threshold": 0.125
    })
}

#[test]
fn what_a_file_says_is_what_is_solved() {
    let scenario = load_text("bad", &good().to_string()).expect("it is good");
    assert_eq!(scenario.name, "bad", "it is called as its file");
    assert_eq!(serde_json::to_value(&scenario.file).expect("numbers"), good());
    let settings = FlowOptions::default().settings(&scenario).expect("it is good");
    assert_eq!((settings.degree, settings.k, settings.s_max, settings.tolerance), (7, 1e5, 10.0, 1e-4));
    let options =
        FlowOptions { degree: Some(4), k: Some(3.0), s_max: Some(2.0), tolerance: Some(1e-3), ..Default::default() };
    let settings = options.settings(&scenario).expect("it is good");
    assert_eq!((settings.degree, settings.k, settings.s_max, settings.tolerance), (4, 3.0, 2.0, 1e-3));
}

#[test]
fn what_a_file_leaves_out_is_all_limits_and_the_papers_choice_for_kinova() {
    let mut short = good();
    let about_obstacles = ["obstacles", "robot_shape", "enforced_limits"];
    let parameters = ["flow", "feedback", "success_threshold"];
    for key in about_obstacles.into_iter().chain(parameters) {
        short.as_object_mut().expect("it is one").remove(key);
    }
    let file = load_text("bad", &short.to_string()).expect("it is good").file;
    assert_eq!((file.flow.degree, file.flow.k, file.flow.s_max), (9, 1e9, 0.1));
    assert_eq!((file.flow.k_cons, file.flow.c_cons), (1e9, 1.0));
    assert_eq!((file.robot_shape, &file.self_collision), (None, &None));
    assert_eq!(file.enforced_limits, EnforcedLimits::default());
    assert!(file.enforced_limits.any() && file.obstacles.is_empty());
    assert_eq!((file.feedback.kp, file.feedback.kv, file.success_threshold), (10.0, 10.0, 0.05));
}

#[test]
fn keys_of_a_program_are_by_default_those_of_a_file() {
    let [q_start, v_start, q_goal, v_goal] = [[-1.5, 0.25], [0.0, 0.5], [1.5, 0.75], [1.0, 0.0]];
    let text = json!({
        "robot": "pendulum_2", "horizon_s": 2.0,
        "q_start": q_start, "v_start": v_start, "q_goal": q_goal, "v_goal": v_goal
    });
    let read: ScenarioFile = serde_json::from_value(text).expect("it is good");
    let [start, goal] = [[q_start, v_start], [q_goal, v_goal]].map(|of| of.map(Vec::from));
    let made = ScenarioFile::new("pendulum_2".to_owned(), 2.0, start, goal);
    assert_eq!(made, read);
}

#[test]
fn a_robot_is_looked_for_beside_the_scenario() {
    let folder = folder();
    std::fs::create_dir_all(folder.join("arms")).expect("the folder is writable");
    let source = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("robots/pendulum_2/pendulum_2.urdf");
    let text = std::fs::read_to_string(source).expect("it exists").replace("joint_1", "shoulder");
    std::fs::write(folder.join("arms/mine.urdf"), text).expect("the folder is writable");
    let scenario = with(good(), json!({ "robot": "arms/mine.urdf" })).to_string();
    let scenario = load_text("bad", &scenario).expect("it is there");
    assert_eq!(scenario.model.joints()[0].name(), "shoulder");
    assert_eq!(scenario.model.name(), "pendulum_2", "as the file says");
    let (model, _) = load_robot_with("arms/mine.urdf", &folder, UrdfOptions::default()).expect("it is there");
    assert_eq!(model.joints()[0].name(), "shoulder");
}
