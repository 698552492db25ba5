//! Goals that are sets of poses, as written in a file.

use crate::written::{load, with};
use aghf::constraint::Constraint;
use serde_json::{Value, json};

const TOOL: &str = "end_effector_link";

fn kinova(goal: Value) -> Value {
    json!({
        "robot": "kinova_gen3", "horizon_s": 2.0,
        "q_start": [0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0], "v_start": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "goal": goal,
    })
}

fn tool(keys: Value) -> Value {
    with(json!({ "frame": TOOL }), keys)
}

/// The numbers of equalities and inequalities of each key; a list has one alternative per entry.
#[test]
fn each_key_has_its_rows() {
    let plane = json!({ "box": { "size_m": [null, 0.2, 0], "pose": { "position_m": [0.1, 0, 0.3] } } });
    let axis = json!({ "axis": { "of_frame": [0, 0, 1], "direction": [0, 0, -1] } });
    let cases = [
        (json!({ "position_m": [0.4, 0, 0.3] }), [3, 0]),
        (json!({ "position_m": [0.4, 0, 0.3], "tolerance_m": 0.01 }), [0, 1]),
        (plane, [1, 2]),
        (json!({ "orientation_xyzw": [0, 0, 0, 1] }), [3, 1]),
        (json!({ "orientation_xyzw": [0, 0, 0, 1], "tolerance_rad": 0.1 }), [0, 1]),
        (axis.clone(), [2, 1]),
        (with(axis, json!({ "tolerance_rad": 0.1, "position_m": [0.4, 0, 0.3] })), [3, 1]),
        (json!({ "position_m": [0.4, 0, 0.3], "relative_to": "shoulder_link" }), [3, 0]),
    ];
    for (keys, expected) in &cases {
        let scenario = load("rows", &kinova(tool(keys.clone()))).expect("it is good");
        let goal = scenario.goal.expect("a set");
        let rows = &goal.alternatives[0];
        let held = (0..rows.dim()).filter(|row| rows.row_set(*row).is_equality).count();
        assert_eq!([held, rows.dim() - held], *expected, "{keys}");
    }
    let list: Vec<_> = cases.iter().map(|(keys, _)| tool(keys.clone())).collect();
    let scenario = load("list", &kinova(json!(list))).expect("it is good");
    assert_eq!(scenario.goal.map(|goal| goal.alternatives.len()), Some(cases.len()));
    // The end is by default at rest, and searched from the start.
    assert_eq!(scenario.file.q_goal, scenario.file.q_start);
    assert_eq!(scenario.file.v_goal, [0.0; 7]);
}

#[test]
fn goals_without_sense_are_refused() {
    let position = json!({ "position_m": [0.4, 0, 0.3] });
    let sized = |size: Value| json!({ "box": { "size_m": size, "pose": { "position_m": [0, 0, 0] } } });
    let direction = |v: Value| json!({ "axis": { "of_frame": [0, 0, 1], "direction": v } });
    for (goal, words) in [
        (json!({ "frame": "tool", "position_m": [0, 0, 0] }), "goal.frame: the robot has no link 'tool' that moves"),
        (json!({ "frame": "base_link", "position_m": [0, 0, 0] }), "goal.frame: the robot has no link"),
        (tool(json!({})), "goal: one of the keys position_m, box, orientation_xyzw and axis is needed"),
        (tool(with(sized(json!([1, 1, 1])), position.clone())), "goal.box: it excludes position_m"),
        (tool(sized(json!([1, -1, 1]))), "goal.box.size_m: an edge has -1 m"),
        (tool(with(position.clone(), json!({ "tolerance_m": -0.1 }))), "goal.tolerance_m: "),
        (
            tool(json!({ "tolerance_m": 0.1, "orientation_xyzw": [0, 0, 0, 1] })),
            "goal.tolerance_m: it needs position_m",
        ),
        (tool(json!({ "orientation_xyzw": [0, 0, 0, 2] })), "goal.orientation_xyzw: "),
        (tool(json!({ "orientation_xyzw": [0, 0, 0, 1], "tolerance_rad": 4.0 })), "goal.tolerance_rad: "),
        (tool(with(position, json!({ "tolerance_rad": 0.1 }))), "goal.tolerance_rad: it needs"),
        (tool(direction(json!([0, 0, 0]))), "goal.axis: "),
        (
            tool(with(direction(json!([0, 0, 1])), json!({ "orientation_xyzw": [0, 0, 0, 1] }))),
            "goal.axis: it excludes",
        ),
        (json!([tool(json!({ "position_m": [0.4, 0, 0.3] })), tool(json!({}))]), "goal[1]: one of the keys"),
        (tool(json!({ "position_m": [0, 0, 0], "relative_to": "hand" })), "goal.relative_to: the robot has no link"),
    ] {
        let error = load("refused", &kinova(goal)).expect_err("it is refused");
        assert!(error.starts_with(words), "{error}; want {words}");
    }
}

#[test]
fn the_flow_knows_no_goal_that_is_a_set() {
    let goal = tool(json!({ "position_m": [0.4, 0, 0.3] }));
    let scenario = load("by_flow", &kinova(goal)).expect("it is good");
    let options = aghf_scenario::FlowOptions::default();
    let found = aghf_scenario::Solve::new(&scenario).options(options).run();
    let error = found.expect_err("by the direct method alone").to_string();
    assert!(error.contains("goal: supported by the method 'direct' only, not by 'flow'"), "{error}");
}
