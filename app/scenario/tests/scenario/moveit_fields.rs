//! Every field of MoveIt's messages and of `joint_limits.yaml` is read, refused by its name, or has no meaning and says
//! why; the guide has a row for each.

use crate::moveit::{files, import, request, scene};
use crate::written::folder;
use aghf_scenario::{JointTrajectory, moveit_fields};
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// The names of the fields by messages.
const NAMES: &str = include_str!("moveit_fields.txt");
const PAGE: &str = include_str!("../../src/guide/moveit.md");

/// The message and a field of each, in the order of the list.
fn fields() -> impl Iterator<Item = (&'static str, &'static str)> {
    let lines = NAMES.lines().filter(|line| !line.starts_with('#'));
    lines.flat_map(|line| {
        let (message, fields) = line.split_once(": ").expect("it has a message");
        fields.split(' ').map(move |field| (message, field))
    })
}

/// The treatment of a field in the page: read, accepted or refused.
fn treatment(message: &str, field: &str) -> &'static str {
    let start = format!("| `{message}` | `{field}` | ");
    let mut rows = PAGE.lines().filter_map(|line| line.strip_prefix(&start));
    let row = rows.next().unwrap_or_else(|| panic!("{start}: no row"));
    row.split_once(" | ").expect("it has columns").0
}

#[test]
fn the_page_has_a_row_for_each_field() {
    let table = moveit_fields();
    assert!(PAGE.contains(&table), "the table is now\n{table}");
    let listed: BTreeSet<_> = fields().collect();
    assert_eq!(listed.len(), fields().count(), "one is listed twice");
    assert_eq!(listed.len() + 2, table.lines().count(), "a row is of no field");
    for (message, field) in listed {
        assert!(["read", "accepted", "refused"].contains(&treatment(message, field)));
    }
}

/// A place of a message of this type: the file, 0 for the scene and 1 for the request, and the pointer to it.
fn place(message: &str) -> Option<(usize, &'static str)> {
    let on_the_way = "/path_constraints/position_constraints/0";
    Some(match message {
        "moveit_msgs/PlanningScene" => (0, ""),
        "moveit_msgs/AllowedCollisionMatrix" => (0, "/allowed_collision_matrix"),
        "moveit_msgs/AllowedCollisionEntry" => (0, "/allowed_collision_matrix/entry_values/0"),
        "moveit_msgs/LinkPadding" => (0, "/link_padding/0"),
        "moveit_msgs/LinkScale" => (0, "/link_scale/0"),
        "moveit_msgs/PlanningSceneWorld" => (0, "/world"),
        "moveit_msgs/CollisionObject" => (0, "/world/collision_objects/0"),
        "octomap_msgs/OctomapWithPose" => (0, "/world/octomap"),
        "octomap_msgs/Octomap" => (0, "/world/octomap/octomap"),
        "geometry_msgs/TransformStamped" => (0, "/fixed_frame_transforms/0"),
        "geometry_msgs/Polygon" => (0, "/world/collision_objects/0/primitives/0/polygon"),
        "moveit_msgs/MotionPlanRequest" => (1, ""),
        "moveit_msgs/TrajectoryConstraints" => (1, "/trajectory_constraints"),
        "moveit_msgs/RobotState" => (1, "/start_state"),
        "sensor_msgs/JointState" => (1, "/start_state/joint_state"),
        "sensor_msgs/MultiDOFJointState" => (1, "/start_state/multi_dof_joint_state"),
        "geometry_msgs/Transform" => (1, "/start_state/multi_dof_joint_state/transforms/0"),
        "moveit_msgs/Constraints" => (1, "/path_constraints"),
        "moveit_msgs/JointConstraint" => (1, "/goal_constraints/0/joint_constraints/0"),
        "moveit_msgs/PositionConstraint" => (1, on_the_way),
        "moveit_msgs/BoundingVolume" => (1, "/path_constraints/position_constraints/0/constraint_region"),
        "shape_msgs/SolidPrimitive" => (1, "/path_constraints/position_constraints/0/constraint_region/primitives/0"),
        "geometry_msgs/Pose" => (1, "/path_constraints/position_constraints/0/constraint_region/primitive_poses/0"),
        "std_msgs/Header" => (1, "/path_constraints/position_constraints/0/header"),
        "moveit_msgs/OrientationConstraint" => (1, "/path_constraints/orientation_constraints/0"),
        _ => return None,
    })
}

/// A scene and a request that contain a message of each type.
fn whole() -> [Value; 2] {
    let mut scene = scene();
    let object = json!({ "id": "post", "primitives": [{ "type": "sphere", "dimensions": [0.1], "polygon": {} }],
        "primitive_poses": [{ "position": [0, 0, 5], "orientation": [0, 0, 0, 1] }] });
    scene["world"]["collision_objects"] = json!([object]);
    scene["world"]["octomap"] = json!({ "octomap": {} });
    scene["allowed_collision_matrix"] = json!({ "entry_names": ["post"], "entry_values": [{ "enabled": [true] }] });
    scene["link_padding"] = json!([{ "link_name": "hand", "padding": 0.0 }]);
    scene["link_scale"] = json!([{ "link_name": "hand", "scale": 1.0 }]);
    let still = json!({ "translation": [0, 0, 0], "rotation": [0, 0, 0, 1] });
    scene["fixed_frame_transforms"] = json!([{ "child_frame_id": "world", "transform": still }]);
    let mut request = request();
    request["start_state"]["multi_dof_joint_state"] = json!({ "transforms": [still] });
    request["trajectory_constraints"] = json!({});
    let near = json!({ "header": {}, "link_name": "hand", "constraint_region": {
        "primitives": [{ "type": "sphere", "dimensions": [5] }],
        "primitive_poses": [{ "position": [0, 0, 0], "orientation": [0, 0, 0, 1] }] } });
    let upright = json!({ "link_name": "hand", "orientation": [0, 0, 0, 1], "absolute_x_axis_tolerance": 3,
        "absolute_y_axis_tolerance": 3, "absolute_z_axis_tolerance": 3 });
    request["path_constraints"] = json!({ "position_constraints": [near], "orientation_constraints": [upright] });
    [scene, request]
}

#[test]
fn a_field_with_nonsense_is_refused_by_its_name_or_has_no_meaning() {
    files();
    let made = |[scene, request]: &[Value; 2]| {
        let scenario = import(scene, request, None)?;
        Ok::<_, String>(serde_json::to_value(&scenario.file).expect("it is written"))
    };
    let good = whole();
    let expected = made(&good).expect("it is good");
    for (message, field) in fields() {
        let Some((file, pointer)) = place(message) else {
            let others = ["trajectory_msgs/", "joint_limits.yaml", "a joint of"];
            assert!(others.iter().any(|other| message.starts_with(other)), "{message}: it is not tried");
            continue;
        };
        let with = |key: &str, value: Value| {
            let mut bad = good.clone();
            bad[file].pointer_mut(pointer).expect(pointer)[key] = value;
            made(&bad)
        };
        let name = ["scene.yaml", "request.yaml"][file];
        let nonsense = with(field, json!({ "nonsense": 1 }));
        if treatment(message, field) == "accepted" {
            assert_eq!(nonsense.as_ref(), Ok(&expected), "{message}.{field}");
        } else {
            let error = nonsense.expect_err(&format!("{message}.{field}"));
            // A row of the matrix has two forms, and is named as a whole.
            let element = if field == "enabled" { "entry_values" } else { field };
            assert!(error.contains(name) && error.contains(element), "{field}: {error}");
        }
        let unknown = with("nonsense", json!(0));
        let unknown = unknown.expect_err(message);
        let is_row = message == "moveit_msgs/AllowedCollisionEntry";
        let words = if is_row { "entry_values" } else { "nonsense: it is no field of " };
        assert!(unknown.contains(words), "{message}: {unknown}");
    }
}

/// Refused fields may have the values that a message has by default.
#[test]
fn defaults_of_refused_fields_are_none() {
    files();
    let [mut scene, mut request] = whole();
    for value in [json!(null), json!([]), json!({})] {
        scene["robot_state"]["attached_collision_objects"] = value.clone();
        request["path_constraints"]["visibility_constraints"] = value;
        import(&scene, &request, None).expect("it is good");
    }
    request["start_state"]["joint_state"]["effort"] = json!([0.0]);
    scene["allowed_collision_matrix"]["default_entry_values"] = json!([false, false]);
    for add in [json!(0), json!("ADD"), json!("\0")] {
        scene["world"]["collision_objects"][0]["operation"] = add;
        import(&scene, &request, None).expect("it is good");
    }
    for (pointer, bad) in [
        ("/link_padding/0/padding", json!(0.01)),
        ("/link_scale/0/scale", json!(1.1)),
        ("/world/collision_objects/0/operation", json!("remove")),
        ("/world/collision_objects/0/operation", json!(1)),
        ("/allowed_collision_matrix/default_entry_values", json!([false, true])),
        ("/robot_state/attached_collision_objects", json!([{}])),
        ("/is_diff", json!(true)),
    ] {
        let mut scene = scene.clone();
        let (parent, key) = pointer.rsplit_once('/').expect("it has a key");
        scene.pointer_mut(parent).expect("it is there")[key] = bad;
        let error = import(&scene, &request, None).expect_err(pointer);
        let element = pointer[1..].replace("/0", "[0]").replace('/', ".");
        assert!(error.contains(&format!("scene.yaml: {element}")), "{error}");
    }
}

#[test]
fn fields_of_trajectories_and_limits_with_nonsense_are_refused_by_their_names() {
    files();
    let of = |wanted: &'static str| fields().filter(move |(message, _)| message.starts_with(wanted));
    let point = json!({ "positions": [0.0], "time_from_start": {} });
    let good = json!({ "header": {}, "joint_names": ["a"], "points": [point] });
    for (message, field) in of("trajectory_msgs/") {
        let mut bad = good.clone();
        let place = if message.ends_with("Point") { "/points/0" } else { "" };
        bad.pointer_mut(place).expect(place)[field] = json!({ "nonsense": 1 });
        let error = JointTrajectory::parse(&bad.to_string(), "m.yaml").expect_err(field);
        assert!(error.to_string().contains(field), "{error}");
        assert_eq!(treatment(message, field), "read");
    }
    let [scene, request] = whole();
    for (message, field) in of("joint_limits.yaml").chain(of("a joint of")) {
        let place = if message.starts_with('a') { "/joint_limits/shoulder" } else { "" };
        for key in [field, "nonsense"] {
            let mut limits = json!({ "joint_limits": { "shoulder": {} } });
            limits.pointer_mut(place).expect(place)[key] = json!({ "nonsense": 1 });
            std::fs::write(folder().join("limits.yaml"), limits.to_string()).expect("writable");
            let made = import(&scene, &request, Some("limits.yaml"));
            if key == field && treatment(message, field) == "accepted" {
                assert!(made.is_ok(), "{field}");
            } else {
                let error = made.map(|_| ()).expect_err(field);
                assert!(error.contains("limits.yaml: ") && error.contains(key), "{error}");
            }
        }
    }
}
