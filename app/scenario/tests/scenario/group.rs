//! Scenarios that plan the joints of a group.

use crate::written::{folder, load, solved_once, with};
use aghf::urdf::summarised;
use aghf_scenario::{LoadOptions, Scenario};
use serde_json::{Value, json};

/// An arm of two joints with a gripper of two fingers, the second of which follows the first, and a camera on a joint
/// that moves nothing with inertia.
fn files() -> Value {
    let link = |name: &str, mass: f64| {
        format!(
            r#"<link name="{name}"><inertial><mass value="{mass}"/><origin xyz="0.1 0 0"/>
            <inertia ixx="{mass}" ixy="0" ixz="0" iyy="{mass}" iyz="0" izz="{mass}"/></inertial></link>"#
        )
    };
    let joint = |name: &str, kind: &str, [parent, child]: [&str; 2], more: &str| {
        format!(
            r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
            <axis xyz="0 1 0"/><origin xyz="0.3 0 0"/>{more}</joint>"#
        )
    };
    let limit =
        |lower: f64, upper: f64| format!(r#"<limit lower="{lower}" upper="{upper}" velocity="2" effort="90"/>"#);
    let finger = limit(0.01, 0.1) + r#"<mimic joint="first" multiplier="2" offset="0.001"/>"#;
    let text = ["base", "upper", "lower", "left", "right"].map(|name| link(name, 1.0)).concat()
        + r#"<link name="camera"/>"#
        + &joint("shoulder", "revolute", ["base", "upper"], &limit(-2.0, 2.0))
        + &joint("elbow", "revolute", ["upper", "lower"], &limit(-2.0, 2.0))
        + &joint("first", "prismatic", ["lower", "left"], &limit(0.01, 0.04))
        + &joint("second", "prismatic", ["lower", "right"], &finger)
        + &joint("pan", "continuous", ["lower", "camera"], "");
    let srdf = r#"<robot name="arm"><group name="arm"><chain base_link="base" tip_link="lower"/></group>
        <group name="hand"><joint name="first"/><joint name="second"/></group>
        <group name="head"><joint name="pan"/></group>
        <group name="first"><joint name="first"/></group>
        <group_state name="open" group="hand"><joint name="first" value="0.03"/></group_state>
        <group_state name="open" group="head"><joint name="pan" value="1.5"/></group_state>
        <group_state name="bad" group="hand"><joint name="third" value="0.03"/></group_state></robot>"#;
    let folder = folder();
    std::fs::write(folder.join("arm.urdf"), format!("<robot name=\"arm\">{text}</robot>")).expect("it is writable");
    std::fs::write(folder.join("arm.srdf"), srdf).expect("it is writable");
    json!({
        "robot": "arm.urdf", "srdf": "arm.srdf", "group": "arm", "horizon_s": 2.0,
        "q_start": [0.0, 0.2], "v_start": [0.0, 0.0], "q_goal": [0.3, -0.2], "v_goal": [0.0, 0.0],
    })
}

/// The locked joints of a scenario, in the order of their names.
fn locked(scenario: &Scenario) -> Vec<(&str, f64)> {
    let locked = scenario.file.locked_joints.iter();
    locked.map(|(name, q)| (name.as_str(), *q)).collect()
}

#[test]
fn joints_outside_of_the_group_are_held() {
    let scenario = load("arm", &files()).expect("it is good");
    let names: Vec<_> = scenario.model.joints().iter().map(|j| j.name()).collect();
    // By the names of the joints on each link.
    assert_eq!(names, ["shoulder", "elbow"]);
    assert_eq!(locked(&scenario), [("first", 0.01), ("pan", 0.0), ("second", 0.021)]);
    assert!(scenario.load_notes.iter().all(|note| !note.bears_on_motion()));
    solved_once(&scenario);

    let open = load("open", &with(files(), json!({ "held_state": "open" }))).expect("it is good");
    assert_eq!(locked(&open), [("first", 0.03), ("pan", 1.5), ("second", 0.061)]);
    let keys = json!({ "held_state": "open", "locked_joints": { "second": 0.05, "pan": -1.0 } });
    let given = load("given", &with(files(), keys)).expect("it is good");
    assert_eq!(locked(&given), [("first", 0.03), ("pan", -1.0), ("second", 0.05)]);

    // What was read is the same without the SRDF.
    let mut written = serde_json::to_value(&open.file).expect("numbers");
    assert!(written.get("srdf").is_none() && written.get("group").is_none());
    written["robot"] = json!(folder().join("arm.urdf"));
    let again = Scenario::parse(&written.to_string(), "again.json", &folder().join("none"));
    assert_eq!(locked(&again.expect("it is good")), locked(&open));
}

#[test]
fn a_group_and_its_file_may_be_given_beside_the_scenario() {
    let mut file = files();
    for key in ["srdf", "group"] {
        file.as_object_mut().expect("it is one").remove(key);
    }
    let error = load("given", &file).expect_err("a joint mimics another");
    assert!(error.starts_with("robot: ") && error.contains("it mimics joint 'first'"), "{error}");
    let given =
        LoadOptions { srdf: Some(folder().join("arm.srdf")), group: Some("arm".to_owned()), ..LoadOptions::default() };
    let path = folder().join("given.json");
    let scenario = Scenario::load_for(path.to_str().expect("it is text"), &given);
    assert_eq!(locked(&scenario.expect("it is good")).len(), 3);
}

#[test]
fn groups_that_cannot_be_planned_are_refused_by_key() {
    let keys = json!({ "mimic": "independent", "held_state": "open" });
    let mut alone = with(files(), keys);
    alone.as_object_mut().expect("it is one").remove("group");
    let mut nowhere = files();
    nowhere.as_object_mut().expect("it is one").remove("srdf");
    for (scenario, words) in [
        (alone, "held_state: it is given without a group"),
        (nowhere, "srdf: the group is in an SRDF, which is not given"),
        (with(files(), json!({ "srdf": "none.srdf" })), "srdf: "),
        (with(files(), json!({ "group": "leg" })), "group: ; arm.srdf: group 'leg': there is no such group"),
        (
            with(files(), json!({ "held_state": "shut" })),
            "held_state: ; group_state 'shut': there is no such state; there are '",
        ),
        (with(files(), json!({ "held_state": "bad" })), "held_state: ; the robot has no joint 'third'"),
        (
            with(files(), json!({ "group": "hand" })),
            "group: joint 'second' mimics 'first', and they cannot move together; {\"second\": POSITION}",
        ),
        (with(files(), json!({ "group": "first" })), "group: joint 'second' mimics 'first'"),
        (
            with(files(), json!({ "locked_joints": { "first": 0.5 } })),
            "locked_joints: ; 'first': locked at 0.5, outside [0.01, 0.04]",
        ),
    ] {
        let error = load("bad", &scenario).expect_err(words);
        let all = words.split("; ").all(|word| error.contains(word));
        assert!(all && error.starts_with(words.split("; ").next().unwrap_or_default()), "{error}\n{words}");
    }
    // The other finger is held where the file says.
    let keys = json!({
        "group": "first", "locked_joints": { "second": 0.05 }, "q_start": [0.02], "v_start": [0.0], "q_goal": [0.03],
        "v_goal": [0.0],
    });
    let scenario = load("first", &with(files(), keys)).expect("it is good");
    assert_eq!(scenario.model.joints()[0].name(), "first");
}

/// The arm on a floating base, with and without the base in the group.
#[test]
fn joints_of_several_degrees_are_held_outside_of_the_group() {
    let file = files();
    let path = folder().join("arm.urdf");
    let text = std::fs::read_to_string(&path).expect("it was written");
    let floats = r#"<link name="world"/><joint name="float" type="floating"><parent link="world"/>
        <child link="base"/><origin xyz="0 0 1"/></joint></robot>"#;
    std::fs::write(folder().join("mobile.urdf"), text.replace("</robot>", floats)).expect("a file");
    let srdf = r#"<robot name="arm"><group name="arm"><chain base_link="base" tip_link="lower"/></group>
        <group name="whole"><chain base_link="world" tip_link="lower"/></group>
        <disable_collisions link1="base" link2="tail"/></robot>"#;
    std::fs::write(folder().join("mobile.srdf"), srdf).expect("a file");
    let mobile = with(file, json!({ "robot": "mobile.urdf", "srdf": "mobile.srdf" }));
    let scenario = load("mobile", &mobile).expect("its base is held");
    let names: Vec<_> = scenario.model.joints().iter().map(|j| j.name()).collect();
    assert_eq!(names, ["shoulder", "elbow"]);
    let notes = summarised(&scenario.load_notes);
    let expected = [
        "joint 'float': floating, held at the origin of the joint",
        "link 'tail': the SRDF has a pair of links with it, and the robot does not have it",
    ];
    assert_eq!(notes, expected);
    for (key, words) in [
        (json!({ "group": "whole" }), "group: it has the joint 'float', which is floating"),
        (json!({ "group": null }), "joint 'float': floating joints are not supported"),
    ] {
        let error = load("mobile", &with(mobile.clone(), key)).expect_err(words);
        assert!(error.contains(words), "{error}");
    }
}
