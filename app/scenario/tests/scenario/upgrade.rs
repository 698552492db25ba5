//! Scenario files of version 0.2 in the form of this version.

use crate::written::{load, with};
use aghf_scenario::{Scenario, ScenarioFile};
use serde_json::{Value, json};

/// A scenario of version 0.2 with every key of it that has another form now, in its documentation.
fn old() -> Value {
    json!({
        "robot": "kinova_gen3",
        "horizon_s": 2.0,
        "q_start": [0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0], "v_start": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "q_goal": [1.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0], "v_goal": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "sphere_obstacles": [{ "center_m": [0.4, -0.3, 0.2], "radius_m": 0.08 }],
        "box_obstacles": [{ "name": "shelf", "center_m": [0.0, 0.9, 0.5], "size_m": [0.6, 0.3, 0.02],
            "orientation_xyzw": [0.0, 0.0, 0.6, 0.8] }],
        "cylinder_obstacles": [{ "name": "post", "center_m": [-0.7, 0.0, 0.5], "radius_m": 0.05, "length_m": 1.0 }],
        "capsule_obstacles": [{ "ends_m": [[0.0, -0.9, 0.0], [0.0, -0.9, 1.0]], "radius_m": 0.05 }],
        "half_spaces": [{ "normal": [0.0, 0.0, 2.0], "offset_m": -0.3 }, { "normal": [-1, 0, 0], "offset_m": -1.5 }],
        "robot_shape": { "swept-links": { "radius_m": 0.05 } },
        "running_cost": { "velocity": 0.5, "torque": [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0] },
        "free_horizon": { "shortest_s": 0.5, "longest_s": 4.0, "weight": 30.0 },
        "free_final_velocity": true,
        "flow": { "p": 8, "k": 1e9, "s_max": 0.1, "guess": "line-state", "k_cons": 1e9, "c_cons": 1.0 }
    })
}

/// The same scenario in the form of this version, as its documentation has it.
fn now() -> Value {
    let half = 0.5_f64.sqrt();
    let mut now = old();
    for key in
        ["sphere_obstacles", "box_obstacles", "cylinder_obstacles", "capsule_obstacles", "half_spaces", "running_cost"]
    {
        now.as_object_mut().expect("it is one").remove(key);
    }
    with(
        now,
        json!({
            "obstacles": [
                { "shape": { "sphere": { "radius_m": 0.08 } }, "pose": { "position_m": [0.4, -0.3, 0.2] } },
                { "name": "shelf", "shape": { "box": { "size_m": [0.6, 0.3, 0.02] } },
                  "pose": { "position_m": [0.0, 0.9, 0.5], "orientation_xyzw": [0.0, 0.0, 0.6, 0.8] } },
                { "name": "post", "shape": { "cylinder": { "radius_m": 0.05, "length_m": 1.0 } },
                  "pose": { "position_m": [-0.7, 0.0, 0.5] } },
                { "shape": { "capsule": { "radius_m": 0.05, "length_m": 1.0 } },
                  "pose": { "position_m": [0.0, -0.9, 0.5] } },
                { "shape": { "half_space": {} }, "pose": { "position_m": [0.0, 0.0, -0.3] } },
                { "shape": { "half_space": {} },
                  "pose": { "position_m": [1.5, 0.0, 0.0], "orientation_xyzw": [0.0, -half, 0.0, half] } },
            ],
            "robot_shape": { "swept_links": { "radius_m": 0.05, "spacing_m": 0.05 } },
            "self_collision": "off",
            "continuity": "velocity",
            "objective": { "units": "si", "time": 30.0, "velocity": 0.5,
                "effort": [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0] },
            "free_horizon": { "shortest_s": 0.5, "longest_s": 4.0 },
            "flow": { "degree": 8, "k": 1e9, "s_max": 0.1, "guess": "line_state", "k_cons": 1e9, "c_cons": 1.0 },
        }),
    )
}

fn upgraded(scenario: &Value) -> Result<ScenarioFile, String> {
    ScenarioFile::upgrade(&scenario.to_string(), "old.json").map_err(|e| e.to_string())
}

/// The free horizon, the running cost and all obstacles are those of version 0.2.
#[test]
fn every_key_has_its_form_of_today() {
    let [found, wanted] = [upgraded(&old()).expect("it is one"), load("now", &now()).expect("it is good").file];
    for (found, wanted) in found.obstacles.iter().zip(&wanted.obstacles) {
        assert_eq!((&found.name, found.shape), (&wanted.name, wanted.shape));
        assert_eq!(found.pose.position_m, wanted.pose.position_m);
        let turns = [found, wanted].map(|obstacle| obstacle.pose.orientation_xyzw.unwrap_or([0.0, 0.0, 0.0, 1.0]));
        let apart = turns[0].iter().zip(turns[1]).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-15, "{turns:?}");
    }
    let rest = |file: ScenarioFile| ScenarioFile { obstacles: Vec::new(), ..file };
    assert_eq!(found.obstacles.len(), wanted.obstacles.len());
    assert_eq!(rest(found), rest(wanted));
}

#[test]
fn an_upgraded_file_is_a_scenario_and_stays_as_it_is() {
    let once = upgraded(&old()).expect("it is one");
    let again = upgraded(&serde_json::to_value(&once).expect("numbers")).expect("it is one");
    assert_eq!(again, once);
    let loaded = Scenario::new(once.clone(), "old", std::path::Path::new("")).expect("it is good");
    assert_eq!(loaded.file, once);
    // Nothing is written out for a file of this version.
    let plain = json!({ "robot": "pendulum_1", "horizon_s": 2.0, "q_start": [0.0], "v_start": [0.0],
        "q_goal": [1.0], "v_goal": [0.0] });
    let of_today = upgraded(&with(plain.clone(), json!({ "obstacles": [] }))).expect("it is one");
    assert_eq!((&of_today.robot_shape, &of_today.self_collision, of_today.continuity), (&None, &None, None));
    let of_then = upgraded(&plain).expect("it is one");
    assert!(of_then.robot_shape.is_some() && of_then.self_collision.is_some() && of_then.continuity.is_some());
}

/// The balls of a box with cells of 6 cm stuck out of its faces by 2.2 cm.
#[test]
fn a_spacing_becomes_an_excess() {
    let shape = |words: Value| {
        let file = upgraded(&with(old(), json!({ "robot_shape": words }))).expect("it is one");
        serde_json::to_value(file.robot_shape).expect("numbers")
    };
    let excess = shape(json!({ "collision": { "spacing_m": 0.06 } }))["collision"]["excess_m"].clone();
    assert!((excess.as_f64().expect("a number") - 0.03 * (3_f64.sqrt() - 1.0)).abs() < 1e-15);
    assert_eq!(shape(json!("joint-frames")), "joint_frames");
}

#[test]
fn a_key_without_a_translation_is_refused_by_its_place() {
    let mut problems = Vec::new();
    for (keys, words) in [
        (json!({ "colour": 1 }), "old.json: colour: unknown field `colour`"),
        (json!({ "box_obstacles": 3 }), "old.json: box_obstacles: invalid type"),
        (json!({ "box_obstacles": [{ "center_m": [0, 0, 0] }] }), "old.json: box_obstacles[0]: missing field `size_m`"),
        (
            json!({ "sphere_obstacles": [{ "center_m": [0, 0, 0], "radius_m": 1, "mass": 1 }] }),
            "old.json: sphere_obstacles[0]: unknown field `mass`",
        ),
        (
            json!({ "sphere_obstacles": [{ "center_m": [0, 0, 0], "radius_m": 1, "orientation_xyzw": [0, 0, 0, 1] }] }),
            "old.json: sphere_obstacles[0]: unknown field `orientation_xyzw`",
        ),
        (
            json!({ "capsule_obstacles": [{ "ends_m": [[0, 0, 0]], "radius_m": 1 }] }),
            "old.json: capsule_obstacles[0]: invalid length 1",
        ),
        (
            json!({ "half_spaces": [{ "normal": [0, 0, 0], "offset_m": 1 }] }),
            "old.json: half_spaces[0]: the direction has length zero",
        ),
        (json!({ "running_cost": { "jolt": 1 } }), "old.json: running_cost: version 0.2 had no weight `jolt`"),
        (json!({ "objective": "balanced" }), "old.json: running_cost: its weights are in SI units"),
        (
            json!({ "objective": { "units": "si", "velocity": 1 } }),
            "old.json: running_cost: it is `velocity` now, which is there too",
        ),
        (json!({ "obstacles": 1 }), "old.json: sphere_obstacles: its obstacles are in the list `obstacles` now"),
        (json!({ "flow": { "p": 8, "degree": 9 } }), "old.json: flow.p: it is `degree` now, which is there too"),
        (
            json!({ "robot_shape": { "collision": { "spacing_m": "fine" } } }),
            "old.json: robot_shape.collision.spacing_m: invalid type",
        ),
        (json!({ "horizon_s": "two" }), "old.json: horizon_s: invalid type"),
    ] {
        let error = upgraded(&with(old(), keys)).err().unwrap_or_else(|| "accepted".to_owned());
        if !error.starts_with(words) {
            problems.push((error, words));
        }
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

#[test]
fn a_key_that_is_there_twice_is_refused() {
    let twice = old().to_string().replacen('{', "{\"half_spaces\": [], ", 1);
    let error = ScenarioFile::upgrade(&twice, "old.json").expect_err("twice").to_string();
    assert!(error.contains("duplicate field `half_spaces`"), "{error}");
}

/// The same table refuses the keys elsewhere, by those of this version.
#[test]
fn a_former_key_is_refused_by_the_new_one() {
    let mut problems = Vec::new();
    for (key, words) in [
        ("sphere_obstacles", "\"obstacles\": [{\"shape\": {\"sphere\": {\"radius_m\": r}}"),
        ("capsule_obstacles", "\"capsule\": {\"radius_m\": r, \"length_m\": l}"),
        ("half_spaces", "\"half_space\": {}"),
        ("running_cost", "\"objective\": {\"units\": \"si\", \"effort\": w"),
        ("free_horizon", "\"time\": w"),
        ("flow", "flow.p: the key has its whole name: \"degree\""),
        ("robot_shape", "\"excess_m\" is needed"),
    ] {
        let value = match key {
            "robot_shape" => json!({ "collision": { "spacing_m": 0.1 } }),
            _ => old()[key].clone(),
        };
        let error = load("bad", &with(now(), json!({ key: value }))).err();
        let error = error.unwrap_or_else(|| "accepted".to_owned());
        if !(error.contains(words) && error.contains("--upgrade")) {
            problems.push((error, words));
        }
    }
    assert!(problems.is_empty(), "{problems:#?}");
}
