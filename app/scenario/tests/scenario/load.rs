//! Scenarios with what is given beside them.

use crate::written::{folder, load};
use aghf_scenario::{LoadOptions, Scenario};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A scenario whose robot has a mesh in the package `hand`, and the path of its file. The mesh is a triangle at `x = 1`
/// in `a` and at `x = 3` in `b`.
fn written() -> (Value, PathBuf) {
    let folder = folder();
    for (package, x) in [("a", 1.0), ("b", 3.0)] {
        std::fs::create_dir_all(folder.join(package)).expect("it is writable");
        let text = format!("v {x} 0 0\nv {x} 0.01 0\nv {x} 0 0.01\nf 1 2 3\n");
        std::fs::write(folder.join(package).join("tip.obj"), text).expect("it is writable");
    }
    let urdf = r#"<robot name="one"><link name="base"/><link name="tip">
        <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
        <collision><geometry><mesh filename="package://hand/tip.obj"/></geometry></collision></link>
        <joint name="turn" type="continuous"><parent link="base"/><child link="tip"/></joint></robot>"#;
    std::fs::write(folder.join("one.urdf"), urdf).expect("it is writable");
    let scenario = json!({
        "robot": "one.urdf", "packages": { "hand": "a" }, "horizon_s": 1.0, "q_start": [0.0], "v_start": [0.0],
        "q_goal": [1.0], "v_goal": [0.0], "robot_shape": { "collision": {} },
        "obstacles": [{ "shape": { "half_space": {} }, "pose": { "position_m": [0.0, 0.0, -9.0] } }],
    });
    (scenario, folder.join("hand.json"))
}

fn middle(scenario: &Scenario) -> f64 {
    scenario.scene.robot().balls[0].centre.x
}

#[test]
fn packages_are_relative_to_the_scenario_and_given_ones_hold() {
    let (file, path) = written();
    let scenario = load("hand", &file).expect("it is good");
    assert!((middle(&scenario) - 1.0).abs() < 0.1);
    assert_eq!(scenario.file.packages["hand"], folder().join("a"));
    let given =
        LoadOptions { packages: BTreeMap::from([("hand".to_owned(), folder().join("b"))]), ..LoadOptions::default() };
    let name = path.to_str().expect("it is text");
    let scenario = Scenario::load_for(name, &given).expect("it is good");
    assert!((middle(&scenario) - 3.0).abs() < 0.1);

    // A scenario that has been read is one from any folder.
    let text = serde_json::to_string(&scenario.file).expect("numbers");
    let same = Scenario::parse(&text, "same.json", &folder()).expect("it is good");
    assert_eq!(same.file.packages, scenario.file.packages);

    let mut without = file;
    without["packages"] = json!({});
    let error = load("hand", &without).expect_err("nobody says where it is");
    assert!(error.contains("--package hand=FOLDER"), "{error}");
    let twice = r#"{"packages": {"hand": "a", "hand": "b"}}"#;
    let error = crate::written::load_text("twice", twice).expect_err("which one");
    assert!(error.contains("duplicate field `hand`"), "{error}");
}
