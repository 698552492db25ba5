//! Limits of velocity, acceleration and jerk that come with a robot.

use crate::written::{folder, load, with};
use aghf_scenario::{Quantity, Scenario};
use serde_json::{Value, json};

/// Three joints with limits of rates in their URDF, of which the last one has none, and a file of MoveIt.
fn files() -> Value {
    let mut text = "<link name=\"base\"/>".to_owned();
    for (parent, child, rates) in [
        ("base", "a", "acceleration=\"5\" deceleration=\"4\" jerk=\"60\""),
        ("a", "b", "deceleration=\"7\""),
        ("b", "c", ""),
    ] {
        text += &format!(
            r#"<link name="{child}"><inertial><mass value="1"/>
            <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
            <joint name="turn_{child}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
            <limit lower="-2" upper="2" velocity="1" effort="9" {rates}/></joint>"#
        );
    }
    let yaml = "joint_limits:\n  turn_a:\n    has_velocity_limits: true\n    max_velocity: 2\n    \
        has_acceleration_limits: true\n    max_acceleration: 3\n    has_jerk_limits: false\n    max_jerk: 9\n  \
        turn_c:\n    has_acceleration_limits: true\n    max_acceleration: 2.5\n    has_deceleration_limits: true\n    \
        max_deceleration: 1.5\n    has_jerk_limits: true\n    max_jerk: 40.0\n  wheel:\n    max_acceleration: 1\n";
    let folder = folder();
    std::fs::write(folder.join("three.urdf"), format!("<robot name=\"three\">{text}</robot>")).expect("it is writable");
    std::fs::write(folder.join("joint_limits.yaml"), yaml).expect("it is writable");
    json!({
        "robot": "three.urdf", "horizon_s": 9.0, "q_start": [0.0, 0.0, 0.0], "v_start": [0.0, 0.0, 0.0],
        "q_goal": [0.1, 0.1, 0.1], "v_goal": [0.0, 0.0, 0.0],
    })
}

/// The scenario with limits of acceleration and jerk from these sources.
fn limited(acceleration: Value, jerk: Value) -> Result<Scenario, String> {
    let limits = json!({ "acceleration": acceleration, "jerk": jerk });
    load("limited", &with(files(), json!({ "enforced_limits": limits })))
}

fn of(scenario: &Scenario, limit: Quantity) -> Vec<Option<f64>> {
    let bounds = (0..scenario.model.dof()).map(|joint| scenario.bound(limit, joint));
    bounds.map(|bound| bound.map(|[_, most]| most)).collect()
}

#[test]
fn limits_are_those_of_the_files_in_the_order_of_the_joints() {
    let scenario = limited(json!("urdf"), json!("urdf")).expect("it is good");
    assert_eq!(of(&scenario, Quantity::Acceleration), [Some(4.0), Some(7.0), None]);
    assert_eq!(of(&scenario, Quantity::Jerk), [Some(60.0), None, None]);
    let written = serde_json::to_value(&scenario.file.enforced_limits).expect("numbers");
    assert_eq!(written["acceleration"], json!([4.0, 7.0, null]));

    let file = json!({ "file": "joint_limits.yaml" });
    let scenario = limited(file.clone(), file.clone()).expect("it is good");
    assert_eq!(of(&scenario, Quantity::Acceleration), [Some(3.0), None, Some(1.5)]);
    assert_eq!(of(&scenario, Quantity::Jerk), [None, None, Some(40.0)]);

    // Of the joints that are planned.
    let keys = json!({
        "enforced_limits": { "acceleration": file }, "locked_joints": { "turn_a": 0.0 },
        "q_start": [0.0, 0.0], "v_start": [0.0, 0.0], "q_goal": [0.1, 0.1], "v_goal": [0.0, 0.0],
    });
    let scenario = load("held", &with(files(), keys)).expect("it is good");
    assert_eq!(of(&scenario, Quantity::Acceleration), [None, Some(1.5)]);
}

/// Of two limits of velocity the smaller one holds; that of the robot, a share of it or none.
#[test]
fn velocities_are_the_smaller_ones() {
    let file = json!({ "file": "joint_limits.yaml" });
    for (velocity, source, bounds) in [
        (json!(true), file.clone(), [Some(1.0), Some(1.0), Some(1.0)]),
        (json!(false), file.clone(), [Some(2.0), None, None]),
        (json!(0.5), json!([0.6, 0.4, null]), [Some(0.5), Some(0.4), Some(0.5)]),
        (json!(false), json!("urdf"), [Some(1.0), Some(1.0), Some(1.0)]),
        (json!(true), json!(0.25), [Some(0.25), Some(0.25), Some(0.25)]),
    ] {
        let keys = json!({ "enforced_limits": { "velocity": velocity, "max_velocity": source } });
        let scenario = load("fast", &with(files(), keys.clone())).expect("it is good");
        assert_eq!(of(&scenario, Quantity::Velocity), bounds, "{keys}");
    }
    // It is a constraint, and it counts for the least horizon.
    let keys = json!({ "enforced_limits": { "max_velocity": [0.01, null, null] } });
    let error = load("slow", &with(files(), keys)).expect("it is good").check_feasible();
    let error = error.expect_err("0.1 rad take ten seconds").to_string();
    assert!(error.contains("joint 'turn_a' needs at least 10"), "{error}");
    let keys = json!({ "enforced_limits": { "max_velocity": 0.0 } });
    let error = load("none", &with(files(), keys)).expect_err("it is no limit");
    assert!(error.starts_with("enforced_limits.max_velocity: it is 0"), "{error}");
}

#[test]
fn limits_that_are_not_there_or_no_limits_are_refused() {
    let error = |acceleration: Value| limited(acceleration, json!(9.0)).expect_err("it is bad");
    for (source, words) in [
        (json!({ "file": "none.yaml" }), "none.yaml"),
        (
            json!("file"),
            "a number is needed, a list with a number or null for each joint, \"urdf\" or {\"file\": PATH}",
        ),
        (json!([1.0, null]), "it has 2 entries, 3 are needed"),
        (json!([1.0, null, 0.0]), "it is 0 and must be a positive number"),
    ] {
        let error = error(source);
        assert!(error.starts_with("enforced_limits.acceleration: ") && error.contains(words), "{error}");
    }
    let keys = json!({ "enforced_limits": { "power": "urdf" } });
    let error = load("bad", &with(files(), keys)).expect_err("robots have no powers");
    assert!(error.starts_with("enforced_limits.power: ") && error.contains("no limits of power"), "{error}");
    let file = json!({ "file": "joint_limits.yaml" });
    for (yaml, words) in [
        (
            "joint_limits: {turn_a: {has_acceleration_limits: true}}",
            "joint_limits.turn_a.max_acceleration: it is missing",
        ),
        (
            "joint_limits: {turn_a: {has_acceleration_limits: true, max_acceleration: -1}}",
            "joint_limits.turn_a.max_acceleration: it is -1 and must be a positive number",
        ),
        ("joint_limits: {wheel: {has_acceleration_limits: true, max_acceleration: 1}}", "no joint that is planned has"),
        ("joint_limits: {turn_a: {max_acceleration: fast}}", "joint_limits.turn_a.max_acceleration: "),
        ("{}", "missing field `joint_limits`"),
    ] {
        let keys = json!({ "enforced_limits": { "acceleration": file } });
        let scenario = with(files(), keys);
        std::fs::write(folder().join("joint_limits.yaml"), yaml).expect("it is writable");
        let error = load("bad", &scenario).expect_err(words);
        assert!(error.starts_with("enforced_limits.acceleration: ") && error.contains(words), "{error}");
    }
    let scenario = files();
    let urdf = std::fs::read_to_string(folder().join("three.urdf")).expect("it is there");
    for (from, to, words) in [
        ("acceleration=\"5\"", "acceleration=\"fast\"", "joint 'turn_a': its limit of acceleration is NaN"),
        ("deceleration=\"7\"", "deceleration=\"0\"", "joint 'turn_b': its limit of acceleration is 0"),
    ] {
        std::fs::write(folder().join("three.urdf"), urdf.replace(from, to)).expect("it is writable");
        let keys = json!({ "enforced_limits": { "acceleration": "urdf" } });
        let error = load("bad", &with(scenario.clone(), keys)).expect_err(words);
        assert!(error.contains(words), "{error}");
    }
}
