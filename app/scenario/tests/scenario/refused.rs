//! Bad scenario files: each is refused by an error that names file and key.

use crate::file::good;
use crate::locked::five;
use crate::passive::hanging;
use crate::written::{folder, load, load_text, with};
use aghf_scenario::Scenario;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// By the good scenario that is changed: keys with other values, the key that the error names, and words of its
/// condition, once per kind of message.
const CASES: &str = include_str!("refused.json");

/// The fault of a refusal that should name this key in these words, if it has one.
fn problem(result: Result<Scenario, String>, key: &str, words: &str) -> Option<String> {
    let error = result.err().unwrap_or_else(|| "accepted".to_owned());
    let good = error.starts_with(&format!("{key}: ")) && error.contains(words);
    (!good).then(|| format!("{error}; want {key}: {words}"))
}

#[test]
fn each_is_refused_by_key() {
    let cases: BTreeMap<String, Vec<Vec<Value>>> = serde_json::from_str(CASES).expect("lists");
    assert_eq!(cases.len(), 3);
    let mut problems = Vec::new();
    for (name, cases) in cases {
        let base = match name.as_str() {
            "good" => good(),
            "locked" => five(),
            _ => hanging(json!({})),
        };
        load("good", &base).expect("it is good");
        for case in cases {
            let [key, words] = [1, 2].map(|i| case.get(i).and_then(Value::as_str).unwrap_or(""));
            let loaded = load("bad", &with(base.clone(), case[0].clone()));
            problems.extend(problem(loaded, key, words));
        }
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

#[test]
fn texts_that_are_no_scenario_are_refused() {
    let (good, five) = (good().to_string(), five().to_string());
    let mut problems = Vec::new();
    for (text, key, words) in [
        (String::new(), "scenario", "line 1"),
        ("{\n \"robot\": pendulum_2 }".to_owned(), "robot", "line 2"),
        ("[1, 2]".to_owned(), "scenario", "a list"),
        ("null".to_owned(), "scenario", "null"),
        (good.clone() + &good, "scenario", "trailing"),
        (good.replacen('{', "{\"horizon_s\": 3.0, ", 1), "scenario", "duplicate"),
        (five.replace("\"joint_3\":", "\"joint_5\":"), "locked_joints", "duplicate"),
        (good.replace("-1.5", "1e999"), "q_start[0]", "out of range"),
        (good.replace("100000.0", "1e999"), "flow.k", "out of range"),
    ] {
        problems.extend(problem(load_text("bad", &text), key, words));
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

#[test]
fn keys_that_are_missing_are_named() {
    for key in ["robot", "horizon_s", "q_start", "v_start"] {
        let mut without = good();
        without.as_object_mut().expect("it is one").remove(key);
        let words = format!("missing field `{key}`");
        assert_eq!(problem(load("bad", &without), "scenario", &words), None);
    }
}

#[test]
fn a_bad_robot_is_named_by_its_file() {
    let robot = r#"<robot name="x"><link name="a"/><link name="b"/></robot>"#;
    std::fs::write(folder().join("broken.urdf"), robot).expect("writable");
    let loaded = load("bad", &with(good(), json!({ "robot": "broken.urdf" })));
    assert_eq!(problem(loaded, "robot", "several root links"), None);
}

#[test]
fn too_many_pairs_of_balls_and_obstacles_are_refused() {
    let many = vec![json!({ "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [5, 5, 5] } }); 100];
    let fine = json!({ "swept_links": { "radius_m": 0.05, "spacing_m": 1e-3 } });
    let keys = json!({ "obstacles": many, "robot_shape": fine });
    let words = "100 obstacles and 1002 balls";
    assert_eq!(problem(load("bad", &with(good(), keys)), "obstacles", words), None);
}

/// A quaternion whose length is not 1 is refused wherever there is one, also if its square overflows or vanishes.
#[test]
fn quaternions_of_another_length_are_refused() {
    type Place = fn(Value) -> Value;
    let places: [Place; 5] = [
        |turn| {
            let pose = json!({ "position_m": [0, 0, 3], "orientation_xyzw": turn });
            json!({ "obstacles": [{ "shape": { "half_space": {} }, "pose": pose }] })
        },
        |turn| json!({ "goal": { "frame": "link_2", "orientation_xyzw": turn } }),
        |turn| json!({ "keep": [{ "poses": { "frame": "link_2", "orientation_xyzw": turn } }] }),
        |turn| {
            let pose = json!({ "position_m": [0, 0, 0], "orientation_xyzw": turn });
            json!({ "keep": [{ "poses": { "frame": "link_2", "box": { "size_m": [1, 1, null], "pose": pose } } }] })
        },
        |turn| json!({ "waypoints": [{ "poses": { "frame": "link_2", "orientation_xyzw": turn } }] }),
    ];
    for place in places {
        for length in [0.0, 5e-324, 1e-170, 1e-155, 0.9, 1.1, 1e155, 1e200, f64::MAX] {
            let turn = json!([0.0, length, 0.0, 0.0]);
            let error = load("turned", &with(good(), place(turn))).expect_err("it is refused");
            assert!(error.contains("the orientation x y z w has length"), "{length}: {error}");
        }
    }
}
