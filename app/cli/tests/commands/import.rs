//! `aghf import` makes scenarios, whole ones or none.

use crate::command::{aghf, assert_bad_input, empty_folder};
use serde_json::{Value, json};
use std::path::Path;

const ROBOT: &str = r#"<robot name="small">
  <link name="base"/>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><origin xyz="0.3 0 0"/><geometry><cylinder radius="0.04" length="0.2"/></geometry></collision></link>
  <link name="hand"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="tip"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1.5" effort="50"/></joint>
  <joint name="wrist" type="revolute"><origin xyz="0.5 0 0"/><parent link="arm"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="50"/></joint>
  <joint name="glue" type="fixed"><parent link="hand"/><child link="tip"/></joint>
</robot>"#;

const SRDF: &str = r#"<robot name="small"><group name="arm"><joint name="shoulder"/><joint name="wrist"/></group>
  <disable_collisions link1="arm" link2="hand" reason="Adjacent"/></robot>"#;

pub const SCENE: &str = "
robot_state:
  joint_state: {name: [shoulder, wrist, glue], position: [0.25, 0.5, 7]}
  multi_dof_joint_state: {transforms: [{translation: [0, 0, 0], rotation: [0, 0, 0, 1]}], joint_names: [world]}
world:
  octomap: {header: {frame_id: world}, octomap: {data: []}}
  collision_objects:
    - id: table
      primitive_poses: [{position: [0.1, 0, -1], orientation: [0, 0, 0, 1]}]
      primitives: [{type: box, dimensions: [1, 2, 0.1]}]
    - id: shelf
      pose: {position: {x: 1, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 1, w: 0}}
      primitives:
        - {type: cylinder, dimensions: [0.4, 0.03]}
        - {type: 2, dimensions: [0.05]}
      primitive_poses:
        - {position: [0.1, 0.2, 0.5], orientation: [1, 0, 0, 0]}
        - {position: [0, 0, 2], orientation: [0, 0, 0, 1]}
";

pub const REQUEST: &str = "
group_name: arm
path_constraints: {name: '', joint_constraints: []}
start_state:
  joint_state: {name: [shoulder], position: [-0.5]}
goal_constraints:
  - joint_constraints:
      - {joint_name: shoulder, position: 1.0, weight: 1}
";

/// A request by pose, with an orientation on the way.
pub const POSE: &str = "
group_name: arm
start_state:
  joint_state: {name: [shoulder, wrist], position: [-0.5, 0.05]}
goal_constraints:
  - position_constraints:
      - header: {frame_id: base}
        link_name: hand
        target_point_offset: [0, 0, 0]
        constraint_region:
          primitives: [{type: sphere, dimensions: [0.01]}]
          primitive_poses: [{position: [0.3, 0.4, 0], orientation: [0, 0, 0, 1]}]
    orientation_constraints:
      - {link_name: hand, orientation: [0, 0, 0, 1], absolute_x_axis_tolerance: 0.2,
         absolute_y_axis_tolerance: 0.1, absolute_z_axis_tolerance: 4}
path_constraints:
  orientation_constraints:
    - {header: {frame_id: arm}, link_name: hand, orientation: [0, 0, 0, 1], absolute_x_axis_tolerance: 0.2,
       absolute_y_axis_tolerance: 0.1, absolute_z_axis_tolerance: 0.3}
";

/// A folder with a problem, a part of a file of which is replaced, or all of it.
pub fn folder(test: &str, file: &str, good: Option<&str>, bad: &str) -> std::path::PathBuf {
    let folder = empty_folder(test);
    let files = [
        ("robot.urdf", ROBOT),
        ("robot.srdf", SRDF),
        ("scene.yaml", SCENE),
        ("request.yaml", REQUEST),
        ("pose.yaml", POSE),
    ];
    for (name, text) in files {
        let good = good.unwrap_or(text);
        let text = if name == file {
            assert_eq!(text.matches(good).count(), 1, "{good}");
            text.replace(good, bad)
        } else {
            text.to_owned()
        };
        std::fs::write(folder.join(name), text).expect("the folder is writable");
    }
    folder
}

pub const IMPORT: [&str; 10] = [
    "import",
    "moveit",
    "scene.yaml",
    "request.yaml",
    "--urdf",
    "robot.urdf",
    "--srdf",
    "robot.srdf",
    "-o",
    "made.json",
];

/// The import of another request.
pub fn import_of(request: &str) -> [&str; 10] {
    IMPORT.map(|word| if word == "request.yaml" { request } else { word })
}

fn made(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("made.json")).expect("it was written");
    serde_json::from_str(&text).expect("it is JSON")
}

#[test]
fn a_problem_becomes_a_scenario() {
    let folder = folder("import", "", None, "");
    let run = aghf(&folder, &IMPORT);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let file = made(&folder);
    let robot = file["robot"].as_str().expect("text");
    assert!(Path::new(robot).is_absolute() && robot.ends_with("robot.urdf"), "{robot}");
    assert_eq!(file["locked_joints"], json!({ "wrist": 0.5 }), "the scene says where it is");
    assert_eq!([&file["q_start"], &file["q_goal"]], [&json!([-0.5]), &json!([1.0])]);
    // At 1.5 rad/s the way takes a second.
    let free = json!({ "shortest_s": 1.0, "longest_s": 15.0 });
    assert_eq!([&file["free_horizon"], &file["horizon_s"]], [&free, &json!(2.0)]);
    assert_eq!(file["objective"], json!("balanced"));
    let table = json!({ "name": "table", "shape": { "box": { "size_m": [1.0, 2.0, 0.1] } },
        "pose": { "position_m": [0.1, 0.0, -1.0] } });
    assert_eq!(file["obstacles"][0], table);
    // The object is turned by half a turn about z, the cylinder by another one about x.
    let pose = json!({ "position_m": [0.9, -0.2, 0.5], "orientation_xyzw": [0.0, 1.0, 0.0, 0.0] });
    let post = json!({ "cylinder": { "radius_m": 0.03, "length_m": 0.4 } });
    let post = json!({ "name": "shelf[0]", "shape": post, "pose": pose });
    assert_eq!(file["obstacles"][1], post);
    // The pose of the object turns a sphere too, though nobody sees it.
    let pose = json!({ "position_m": [1.0, 0.0, 2.0], "orientation_xyzw": [0.0, 0.0, 1.0, 0.0] });
    let ball = json!({ "name": "shelf[1]", "shape": { "sphere": { "radius_m": 0.05 } }, "pose": pose });
    assert_eq!(file["obstacles"][2], ball);
    assert_eq!(file["self_collision"], json!({ "ignored_pairs": [["arm", "hand"]] }));
    let shown = aghf(&folder, &["scenarios", "made.json"]);
    assert_eq!(shown.code, Some(0), "{}", shown.stderr);
    assert_bad_input(&folder, &IMPORT, "made.json; exists already; --force");
}

/// Links that the scene allows to overlap may; the names of objects mean no pair of links.
#[test]
fn pairs_that_the_scene_allows_may_overlap() {
    let matrix = "\nallowed_collision_matrix:
  entry_names: [hand, table, base]
  entry_values: [[true, true, true], {enabled: [true, true, true]}, [true, true, true]]\nrobot_state:\n";
    let folder = folder("import_allowed", "scene.yaml", Some("\nrobot_state:\n"), matrix);
    let with_base = ROBOT.replace(
        r#"<link name="base"/>"#,
        r#"<link name="base"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>"#,
    );
    std::fs::write(folder.join("robot.urdf"), with_base).expect("the folder is writable");
    let run = aghf(&folder, &IMPORT);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let pairs = json!({ "ignored_pairs": [["arm", "hand"], ["hand", "base"]] });
    assert_eq!(made(&folder)["self_collision"], pairs);
}

#[test]
fn a_joint_that_the_robot_lacks_is_told() {
    let folder = folder("import_wheel", "scene.yaml", Some("wrist, glue"), "wrist, wheel");
    let run = aghf(&folder, &IMPORT);
    let words = "joint 'wheel': the robot has none of this name, its position is not used";
    assert_eq!(run.code, Some(0));
    assert!(run.stderr.contains(words), "{}", run.stderr);
    assert_eq!(made(&folder)["locked_joints"], json!({ "wrist": 0.5 }));
}

/// Beyond a limit by rounding a position is set to it; farther beyond it stays as it is, for the checks of a solve.
#[test]
fn a_position_beyond_a_limit_by_rounding_is_set_to_it() {
    let folder = folder("import_limit", "scene.yaml", Some("wrist, glue"), "wrist, glue");
    let with = |lower: &str| {
        let robot = ROBOT.replacen("lower=\"-2\"", &format!("lower=\"{lower}\""), 1);
        std::fs::write(folder.join("robot.urdf"), robot).expect("the folder is writable");
    };
    with("-0.499998");
    let run = aghf(&folder, &IMPORT);
    let words = "joint 'shoulder': its position is 2.0e-6 beyond a limit, and was set to the limit";
    assert_eq!(run.code, Some(0));
    assert!(run.stderr.contains(words), "{}", run.stderr);
    assert_eq!(made(&folder)["q_start"], json!([-0.499998]));
    std::fs::remove_file(folder.join("made.json")).expect("it is there");
    with("-0.4999");
    let run = aghf(&folder, &IMPORT);
    assert!(run.code == Some(0) && !run.stderr.contains("beyond a limit"), "{}", run.stderr);
    assert_eq!(made(&folder)["q_start"], json!([-0.5]));
}

#[test]
fn a_request_by_pose_becomes_a_goal_and_a_condition_on_the_way() {
    let folder = folder("import_pose", "", None, "");
    let run = aghf(&folder, &import_of("pose.yaml"));
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let file = made(&folder);
    assert_eq!(file["q_start"], json!([-0.5, 0.05]));
    // The z axis is free, and the smaller of the other two tolerances holds.
    let along_z = json!({ "of_frame": [0.0, 0.0, 1.0], "direction": [0.0, 0.0, 1.0] });
    let goal = json!({ "frame": "hand", "position_m": [0.3, 0.4, 0.0], "tolerance_m": 0.01,
        "axis": along_z, "tolerance_rad": 0.1 });
    assert_eq!(file["goal"], json!([goal]));
    let poses = json!({ "frame": "hand", "relative_to": "arm",
        "orientation_xyzw": [0.0, 0.0, 0.0, 1.0], "tolerance_rad": 0.1 });
    assert_eq!(file["keep"], json!([{ "poses": poses }]));
    // Half a turn of the slower joint, at 1 rad/s, twice.
    let first = file["horizon_s"].as_f64().expect("a number");
    assert!((first - 2.0 * std::f64::consts::PI).abs() < 1e-9, "{first}");
    assert_eq!(file["free_horizon"]["shortest_s"], json!(0.1));
    let other = ["group_name: arm", "group_name: leg"];
    let folder = self::folder("import_group", "pose.yaml", Some(other[0]), other[1]);
    assert_bad_input(&folder, &import_of("pose.yaml"), "robot.srdf: group 'leg'");
}

#[test]
fn the_horizon_is_what_was_asked_for() {
    let folder = folder("horizon", "", None, "");
    let with = |more: &[&str]| {
        let run = aghf(&folder, &[&IMPORT, more, &["--force"]].concat());
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        made(&folder)
    };
    let given = with(&["--horizon", "3"]);
    assert_eq!([&given["horizon_s"], &given["free_horizon"]], [&json!(3.0), &Value::Null]);
    assert_eq!(given["objective"], Value::Null, "the least effort");
    let fast = with(&["--objective", "least-time"]);
    assert_eq!(fast["objective"], json!("least-time"));
    let between = with(&["--horizon-bounds", "2.5", "4"]);
    let free = json!({ "shortest_s": 2.5, "longest_s": 4.0 });
    assert_eq!([&between["horizon_s"], &between["free_horizon"]], [&json!(2.5), &free]);
}

#[test]
fn factors_of_a_request_scale_the_limits_of_a_file() {
    let folder = folder(
        "import_scaled",
        "request.yaml",
        Some("group_name: arm"),
        "max_velocity_scaling_factor: 0.1\nmax_acceleration_scaling_factor: 0.5",
    );
    let yaml = "joint_limits: {shoulder: {max_acceleration: 4, max_deceleration: -3}}";
    std::fs::write(folder.join("joint_limits.yaml"), yaml).expect("the folder is writable");
    let run = aghf(&folder, &[&IMPORT[..], &["--joint-limits", "joint_limits.yaml"]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let words = "joint 'shoulder': limits of acceleration and deceleration differ, the smaller of 4 and 3 holds";
    assert!(run.stderr.contains(words), "{}", run.stderr);
    let limits = &made(&folder)["enforced_limits"];
    assert_eq!([&limits["velocity"], &limits["acceleration"]], [&json!(0.1), &json!([1.5])]);
}

#[test]
fn a_goal_by_whole_turns_is_told() {
    let start = "joint_state: {name: [shoulder], position: [3.1]}";
    let request = REQUEST.replace("joint_state: {name: [shoulder], position: [-0.5]}", start);
    let folder = folder("import_turn", "request.yaml", None, &request.replace("1.0", "-3.1"));
    let robot = ROBOT.replacen("type=\"revolute\"", "type=\"continuous\"", 1);
    std::fs::write(folder.join("robot.urdf"), robot).expect("the folder is writable");
    let run = aghf(&folder, &IMPORT);
    let words = "joint 'shoulder': its goal was moved by 1 turn, as near as possible to its start";
    assert_eq!(run.code, Some(0));
    assert!(run.stderr.contains(words), "{}", run.stderr);
    assert_eq!(made(&folder)["q_goal"], json!([std::f64::consts::TAU - 3.1]));
}

#[test]
fn an_end_in_an_obstacle_is_told() {
    let inside = folder("inside", "scene.yaml", Some("[0.1, 0, -1]"), "[0.1, 0, 0]");
    let run = aghf(&inside, &IMPORT);
    assert_eq!(run.code, Some(0));
    assert!(
        run.stderr.contains("note: it has no solution: ") && run.stderr.contains("inside 'table'"),
        "{}",
        run.stderr
    );
}

#[test]
fn spheres_of_an_srdf_are_written_with_the_robot() {
    let spheres = r#"<link_sphere_approximation link="arm"><sphere center="0.1 0 0" radius="0.06"/>
        </link_sphere_approximation></robot>"#;
    let folder = folder("spheres", "robot.srdf", Some("</robot>"), spheres);
    let run = aghf(&folder, &["robots", "robot.urdf", "--srdf", "robot.srdf", "--urdf", "out.urdf"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let text = std::fs::read_to_string(folder.join("out.urdf")).expect("it was written");
    assert!(text.contains(r#"<sphere radius="0.06"/>"#) && !text.contains("cylinder"), "{text}");
}
