//! Scenario files: good ones are read as they are written, bad ones are refused by an error that names file and key.

use crate::written::{folder, load_text, with};
use aghf::urdf::{UrdfOptions, load_robot_with};
use aghf_scenario::{EnforcedLimits, FlowOptions, RobotShape};
use serde_json::{Value, json};
use std::path::Path;

/// A good scenario to break.
fn good() -> Value {
    json!({
        "robot": "pendulum_2", "horizon_s": 2.0,
        "q_start": [-1.5, 0.25], "v_start": [0.0, 0.5], "q_goal": [1.5, 0.75], "v_goal": [1.0, 0.0],
        "sphere_obstacles": [{ "center_m": [0.0, 3.0, 0.5], "radius_m": 0.1 }],
        "half_spaces": [{ "normal": [0.0, 0.0, 0.5], "offset_m": -3.0 }],
        "robot_shape": { "swept_links": { "radius_m": 0.1, "spacing_m": 0.2 } },
        "enforced_limits": { "position": true, "velocity": false, "torque": false },
        "flow": { "degree": 7, "k": 1e5, "s_max": 10.0, "guess": "line_state", "k_cons": 1e3, "c_cons": 4.0 },
        "feedback": { "kp": 10.0, "kv": 5.0 }, "success_threshold": 0.125
    })
}

/// [`good`] with the value at `pointer` replaced.
fn good_but(pointer: &str, value: Value) -> Value {
    let mut scenario = good();
    *scenario.pointer_mut(pointer).expect("there is such a key") = value;
    scenario
}

/// Asserts that each text is refused with all words (between semicolons) in the message after the name of the file.
fn assert_refused<T: AsRef<str>>(cases: impl IntoIterator<Item = (T, &'static str)>) {
    let mut problems = Vec::new();
    for (text, words) in cases {
        match load_text("bad", text.as_ref()) {
            Ok(_) => problems.push(format!("accepted {}; want {words}", text.as_ref())),
            Err(error) if words.split("; ").all(|word| error.contains(word)) => {}
            Err(error) => problems.push(format!("{error}; want {words}")),
        }
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

#[test]
fn what_a_file_says_is_what_is_solved() {
    let scenario = load_text("bad", &good().to_string()).expect("it is good");
    assert_eq!(scenario.name, "bad", "it is called as its file");
    assert_eq!(
        serde_json::to_value(&scenario.file).expect("numbers"),
        good()
    );
    let settings = FlowOptions::default().settings(&scenario);
    let settings = settings.expect("it is good");
    assert_eq!(
        (
            settings.degree,
            settings.k,
            settings.s_max,
            settings.tolerance
        ),
        (7, 1e5, 10.0, 1e-4)
    );
    let options = FlowOptions {
        degree: Some(4),
        k: Some(3.0),
        s_max: Some(2.0),
        tolerance: Some(1e-3),
        ..Default::default()
    };
    let settings = options.settings(&scenario).expect("it is good");
    assert_eq!(
        (
            settings.degree,
            settings.k,
            settings.s_max,
            settings.tolerance
        ),
        (4, 3.0, 2.0, 1e-3)
    );
}

#[test]
fn what_a_file_leaves_out_is_all_limits_and_the_papers_choice_for_kinova() {
    let mut short = good();
    let about_obstacles = [
        "sphere_obstacles",
        "half_spaces",
        "robot_shape",
        "enforced_limits",
    ];
    let parameters = ["flow", "feedback", "success_threshold"];
    for key in about_obstacles.into_iter().chain(parameters) {
        short.as_object_mut().expect("it is one").remove(key);
    }
    let file = load_text("bad", &short.to_string())
        .expect("it is good")
        .file;
    assert_eq!(
        (file.flow.degree, file.flow.k, file.flow.s_max),
        (9, 1e9, 0.1)
    );
    assert_eq!((file.flow.k_cons, file.flow.c_cons), (1e9, 1.0));
    assert_eq!(file.robot_shape, RobotShape::JointFrames);
    assert_eq!(file.enforced_limits, EnforcedLimits::default());
    assert!(file.enforced_limits.any() && file.sphere_obstacles.is_empty());
    assert_eq!(
        (file.feedback.kp, file.feedback.kv, file.success_threshold),
        (10.0, 10.0, 0.05)
    );
}

#[test]
fn text_that_is_no_scenario() {
    assert_refused([
        ("", "line 1"),
        ("{ \"robot\": \"pendulum_2\"", "line 1"),
        ("{\n \"robot\": pendulum_2 }", "line 2"),
        ("[1, 2]", "scenario"),
        ("null", "scenario"),
    ]);
    let two = format!("{}{}", good(), good());
    assert_refused([(two, "trailing")]);
}

#[test]
fn keys_that_are_missing() {
    for key in [
        "robot",
        "horizon_s",
        "q_start",
        "v_start",
        "q_goal",
        "v_goal",
    ] {
        let mut scenario = good();
        scenario.as_object_mut().expect("it is one").remove(key);
        let error = load_text("bad", &scenario.to_string()).expect_err("a key is missing");
        assert!(error.contains(&format!("missing field `{key}`")), "{error}");
    }
    for key in ["kp", "kv"] {
        let mut scenario = good();
        scenario["feedback"]
            .as_object_mut()
            .expect("it is one")
            .remove(key);
        let error = load_text("bad", &scenario.to_string()).expect_err("a key is missing");
        assert!(error.contains(&format!("missing field `{key}`")), "{error}");
    }
}

#[test]
fn keys_that_are_unknown_or_repeated() {
    let mut cases = Vec::new();
    for (place, words) in [
        ("", "unknown field `horizn_s`"),
        ("/flow", "unknown field `horizn_s`"),
        ("/feedback", "unknown field `horizn_s`"),
    ] {
        let mut scenario = good();
        let object = scenario.pointer_mut(place).expect("it is there");
        object["horizn_s"] = json!(1.0);
        cases.push((scenario.to_string(), words));
    }
    let repeated = good().to_string().replacen('{', "{\"horizon_s\": 3.0, ", 1);
    cases.push((repeated, "duplicate field `horizon_s`"));
    assert_refused(cases);
}

#[test]
fn states_of_the_wrong_length() {
    for key in ["q_start", "v_start", "q_goal", "v_goal"] {
        for wrong in [json!([]), json!([1.0]), json!([1.0, 2.0, 3.0])] {
            let found = wrong.as_array().map_or(0, Vec::len);
            let text = good_but(&format!("/{key}"), wrong).to_string();
            let error = load_text("bad", &text).expect_err("the length is wrong");
            let expected = format!("{key}: the robot has 2 joints, but {found} values are given");
            assert_eq!(error, expected);
        }
    }
}

#[test]
fn numbers_out_of_their_range() {
    let cases = [
        ("/horizon_s", json!(0.0), "horizon_s: it is 0; positive"),
        ("/horizon_s", json!(-2.0), "horizon_s: it is -2; positive"),
        ("/flow/k", json!(-1.0), "flow.k: it is -1; positive"),
        ("/flow/k", json!(0), "flow.k: it is 0; positive"),
        (
            "/flow/s_max",
            json!(-0.5),
            "flow.s_max: it is -0.5; positive",
        ),
        ("/flow/s_max", json!(0.0), "flow.s_max: it is 0; positive"),
        (
            "/feedback/kp",
            json!(-3.0),
            "feedback.kp: it is -3; not negative",
        ),
        (
            "/feedback/kv",
            json!(-4.0),
            "feedback.kv: it is -4; not negative",
        ),
        (
            "/success_threshold",
            json!(0.0),
            "success_threshold: it is 0; positive",
        ),
        (
            "/success_threshold",
            json!(-1),
            "success_threshold: it is -1; positive",
        ),
    ];
    assert_refused(cases.map(|(key, value, words)| (good_but(key, value).to_string(), words)));
}

#[test]
fn degrees_that_are_too_small() {
    let degree = |p: usize| good_but("/flow/degree", json!(p)).to_string();
    assert_refused([
        (degree(1), "flow.degree: it is 1"),
        (degree(0), "flow.degree: it is 0"),
    ]);
}

/// Where the JSON is good but a value is of the wrong kind, the key must be told too.
#[test]
fn values_of_the_wrong_kind() {
    let cases = [
        ("/horizon_s", json!("two"), "horizon_s; two"),
        ("/horizon_s", json!(null), "horizon_s; null"),
        ("/q_goal", json!([1.0, "up"]), "q_goal; up"),
        ("/v_goal", json!(1.0), "v_goal"),
        ("/flow/degree", json!(7.5), "flow.degree; 7.5"),
        ("/flow/degree", json!(-7), "flow.degree; -7"),
        ("/flow/guess", json!("circle"), "flow.guess; circle"),
        ("/feedback", json!(10.0), "feedback"),
        ("/robot", json!(3), "robot"),
    ];
    assert_refused(cases.map(|(key, value, words)| (good_but(key, value).to_string(), words)));
}

#[test]
fn numbers_too_large_for_f64() {
    let huge = |what: &str| good().to_string().replace(what, "1e999");
    assert_refused([
        (huge("-1.5"), "out of range; q_start"),
        (huge("2.0"), "out of range; horizon_s"),
        (huge("100000.0"), "out of range; flow.k"),
        (huge("0.125"), "out of range; success_threshold"),
    ]);
}

#[test]
fn robots_that_do_not_exist_or_are_bad() {
    let path = folder().join("broken.urdf");
    std::fs::write(
        path,
        r#"<robot name="x"><link name="a"/><link name="b"/></robot>"#,
    )
    .expect("writable");
    let robot = |name: &str| good_but("/robot", json!(name)).to_string();
    assert_refused([
        (
            robot("pendulum_7"),
            "robot: ; pendulum_7; neither a file nor a built-in robot",
        ),
        (
            robot("arms/no.urdf"),
            "robot: ; arms/no.urdf; neither a file nor a built-in robot",
        ),
        (
            robot("broken.urdf"),
            "robot: ; broken.urdf; several root links; 'a'; 'b'",
        ),
        (robot(""), "robot: "),
    ]);
}

#[test]
fn bad_obstacles_are_refused() {
    let with = |key: &str, value: Value| with(good(), json!({ key: value })).to_string();
    let sphere = |centre: Value, radius: f64| {
        with(
            "sphere_obstacles",
            json!([{ "center_m": centre, "radius_m": radius }]),
        )
    };
    let floor = |normal: Value| {
        with(
            "half_spaces",
            json!([{ "normal": normal, "offset_m": 0.0 }]),
        )
    };
    let swept = |radius: f64, spacing: f64| {
        let shape = json!({ "swept_links": { "radius_m": radius, "spacing_m": spacing } });
        with("robot_shape", shape)
    };
    for good in [
        with("sphere_obstacles", json!([])),
        sphere(json!([0.0, 0.0, 1.0]), 0.1),
        floor(json!([0.0, 0.0, 2.0])),
        swept(0.0, 0.1),
        with("robot_shape", json!({ "swept_links": { "radius_m": 0.1 } })),
        with("enforced_limits", json!({ "position": true })),
    ] {
        load_text("bad", &good).expect("it is good");
    }
    assert_refused([
        (
            sphere(json!([0.0, 1.0]), 0.1),
            "sphere_obstacles[0].center_m; length 2",
        ),
        (
            sphere(json!([0.0, 0.0, 1.0]), 0.0),
            "sphere_obstacles[0]; positive radius",
        ),
        (
            sphere(json!([0.0, 0.0, 1.0]), -0.1),
            "sphere_obstacles[0]; positive radius",
        ),
        (floor(json!([0.0, 0.0, 0.0])), "half_spaces[0]; not zero"),
        (
            floor(json!([0.0, "up", 0.0])),
            "half_spaces[0].normal[1]; up",
        ),
        (swept(-0.1, 0.1), "robot_shape; not negative"),
        (swept(0.1, 0.0), "robot_shape; positive spacing"),
        (
            with("robot_shape", json!("balloon")),
            "robot_shape; balloon",
        ),
        (
            with("enforced_limits", json!({ "jerk": true })),
            "enforced_limits.jerk; unknown",
        ),
        (
            with("enforced_limits", json!(0.9)),
            "enforced_limits; position, velocity and torque",
        ),
        (
            with("free_horizon", json!(3)),
            "free_horizon; shortest_s, longest_s and weight",
        ),
        (
            good_but("/flow", json!({ "k_cons": 0.0 })).to_string(),
            "flow.k_cons; positive",
        ),
        (
            good_but("/flow", json!({ "c_cons": -1.0 })).to_string(),
            "flow.c_cons; positive",
        ),
    ]);
}

#[test]
fn a_robot_is_looked_for_beside_the_scenario() {
    let folder = folder();
    std::fs::create_dir_all(folder.join("arms")).expect("the folder is writable");
    let source = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .join("robots/pendulum_2/pendulum_2.urdf");
    let text = std::fs::read_to_string(source)
        .expect("it exists")
        .replace("joint_1", "shoulder");
    std::fs::write(folder.join("arms/mine.urdf"), text).expect("the folder is writable");
    let scenario = good_but("/robot", json!("arms/mine.urdf")).to_string();
    let scenario = load_text("bad", &scenario).expect("it is there");
    assert_eq!(scenario.model.joints()[0].name(), "shoulder");
    assert_eq!(scenario.model.name(), "pendulum_2", "as the file says");
    let (model, _) =
        load_robot_with("arms/mine.urdf", &folder, UrdfOptions::default()).expect("it is there");
    assert_eq!(model.joints()[0].name(), "shoulder");
}
