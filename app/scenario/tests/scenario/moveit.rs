//! Everything that a planning request of MoveIt asks for is in the scenario; the command is tested in `app/cli`.

use crate::written::folder;
use aghf_scenario::{MoveIt, MoveItHorizon, Preset, Scenario};
use serde_json::{Value, json};
use std::collections::BTreeMap;

const LINK: &str = r#"<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><sphere radius="0.05"/></geometry></collision></link>"#;

/// Writes a robot of a limited shoulder and a continuous wrist, and its SRDF.
pub fn files() {
    let urdf = format!(
        r#"<robot name="small"><link name="base"/><link name="arm">{LINK}<link name="hand">{LINK}
        <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
          <limit lower="-2" upper="2" velocity="1.5" effort="50"/></joint>
        <joint name="wrist" type="continuous"><origin xyz="0.5 0 0"/><parent link="arm"/><child link="hand"/>
          <axis xyz="0 0 1"/><limit velocity="1" effort="50"/></joint></robot>"#
    );
    let srdf = r#"<robot name="small"><disable_collisions link1="arm" link2="hand" reason="Adjacent"/></robot>"#;
    for (name, text) in [("robot.urdf", urdf.as_str()), ("robot.srdf", srdf)] {
        std::fs::write(folder().join(name), text).expect("the folder is writable");
    }
}

pub fn scene() -> Value {
    let state = json!({ "joint_state": { "name": ["shoulder", "wrist"], "position": [0.25, 0.5] } });
    json!({ "robot_state": state, "world": { "collision_objects": [] } })
}

/// A motion of the shoulder by 1.5 rad.
pub fn request() -> Value {
    json!({
        "start_state": { "joint_state": { "name": ["shoulder"], "position": [-0.5] } },
        "goal_constraints": [{ "joint_constraints": [{ "joint_name": "shoulder", "position": 1.0 }] }],
    })
}

/// The scenario of these messages and a file of limits in the folder of the test.
pub fn import(scene: &Value, request: &Value, limits: Option<&str>) -> Result<Scenario, String> {
    let [scene, request] = [("scene.yaml", scene), ("request.yaml", request)].map(|(name, message)| {
        let path = folder().join(name);
        std::fs::write(&path, message.to_string()).expect("the folder is writable");
        path
    });
    let of_folder = |name: &str| folder().join(name);
    let problem = MoveIt {
        scene,
        request,
        urdf: of_folder("robot.urdf").display().to_string(),
        packages: BTreeMap::new(),
        mimic: Default::default(),
        srdf: Some(of_folder("robot.srdf")),
        joint_limits: limits.map(of_folder),
        excess: 0.005,
        horizon: MoveItHorizon::Free,
        objective: Preset::Balanced,
    };
    problem.scenario("made.json").map_err(|error| error.to_string())
}

/// The request with these keys more, and limits from this file.
fn made(keys: Value, limits: Option<&str>) -> Result<Scenario, String> {
    files();
    let mut request = request();
    for (key, value) in keys.as_object().expect("keys") {
        request[key] = value.clone();
    }
    if let Some(limits) = limits {
        std::fs::write(folder().join("limits.yaml"), limits).expect("the folder is writable");
    }
    import(&scene(), &request, limits.map(|_| "limits.yaml"))
}

fn limits_of(scenario: &Scenario) -> Value {
    serde_json::to_value(&scenario.file.enforced_limits).expect("it is written")
}

const LIMITS: &str = "
default_velocity_scaling_factor: 0.5
default_acceleration_scaling_factor: 0.25
joint_limits:
  shoulder: {has_velocity_limits: true, max_velocity: 1, has_acceleration_limits: true, max_acceleration: 4,
    has_jerk_limits: true, max_jerk: 30}
";

#[test]
fn factors_scale_the_limits_and_the_horizon() {
    let tenth = json!({ "max_velocity_scaling_factor": 0.1 });
    let scenario = made(tenth, None).expect("it is good");
    assert_eq!(limits_of(&scenario)["velocity"], json!(0.1));
    // 1.5 rad at a tenth of 1.5 rad/s.
    let free = scenario.file.free_horizon.expect("it is free");
    assert!((free.shortest_s - 10.0).abs() < 1e-12, "{free:?}");
    for none in [json!({}), json!({ "max_velocity_scaling_factor": 0, "max_acceleration_scaling_factor": 0.0 })] {
        let scenario = made(none, None).expect("it is good");
        assert_eq!(limits_of(&scenario), json!({ "position": true, "velocity": true, "torque": true }));
    }
    let both = json!({ "max_velocity_scaling_factor": 0.1, "max_acceleration_scaling_factor": 0.01 });
    let limits = limits_of(&made(both, Some(LIMITS)).expect("it is good"));
    let expected = json!({ "position": true, "velocity": 0.1, "torque": true, "max_velocity": [0.1],
        "acceleration": [0.04], "jerk": [30.0] });
    assert_eq!(limits, expected);
    // Without factors of the request those of the file hold.
    let scenario = made(json!({}), Some(LIMITS)).expect("it is good");
    let expected = json!({ "position": true, "velocity": 0.5, "torque": true, "max_velocity": [0.5],
        "acceleration": [1.0], "jerk": [30.0] });
    assert_eq!(limits_of(&scenario), expected);
}

/// From rest to rest 1.5 rad take 2 sqrt(1.5 / 0.004) s, far more than the 3 s at half of 1 rad/s.
#[test]
fn the_horizon_is_long_enough_for_accelerations_and_speeds() {
    let slow = json!({ "max_acceleration_scaling_factor": 0.001 });
    let free = made(slow, Some(LIMITS)).expect("it is good").file.free_horizon.expect("it is free");
    assert!(free.longest_s > 2.0 * (1.5_f64 / 0.004).sqrt(), "{free:?}");
    assert!((free.shortest_s - 3.0).abs() < 1e-12, "{free:?}");
    // The hand is 0.5 m from the shoulder.
    let slow = json!({ "max_cartesian_speed": 0.001, "cartesian_speed_limited_link": "hand" });
    let free = made(slow, None).expect("it is good").file.free_horizon.expect("it is free");
    assert!(free.longest_s > 1.5 * 0.5 / 0.001, "{free:?}");
    assert!((free.shortest_s - 1.0).abs() < 1e-12, "{free:?}");
}

#[test]
fn factors_that_cannot_be_kept_are_refused() {
    for factor in [1.5, -0.1] {
        for key in ["max_velocity_scaling_factor", "max_acceleration_scaling_factor"] {
            let error = made(json!({ key: factor }), Some(LIMITS)).map(|_| ()).expect_err(key);
            assert!(error.contains(&format!("request.yaml: {key}: it is {factor}, a factor is")), "{error}");
        }
    }
    let tenth = json!({ "max_acceleration_scaling_factor": 0.1 });
    for limits in [None, Some("joint_limits: {wrist: {max_acceleration: 2}}")] {
        let error = made(tenth.clone(), limits).map(|_| ()).expect_err("nothing to scale");
        let words = "request.yaml: max_acceleration_scaling_factor: it is 0.1, but joint 'shoulder' has no known \
            limit that it could scale; --joint-limits names";
        assert!(error.contains(words), "{error}");
    }
    made(json!({ "max_acceleration_scaling_factor": 1 }), None).expect("it scales nothing");
    // A velocity of zero in a URDF is none.
    let path = folder().join("robot.urdf");
    let urdf = std::fs::read_to_string(&path).expect("it is there");
    std::fs::write(path, urdf.replace("velocity=\"1.5\"", "velocity=\"0\"")).expect("writable");
    let mut request = request();
    request["max_velocity_scaling_factor"] = json!(0.1);
    let error = import(&scene(), &request, None).map(|_| ()).expect_err("nothing to scale");
    assert!(error.contains("max_velocity_scaling_factor: it is 0.1, but joint 'shoulder' has no"), "{error}");
}

#[test]
fn velocities_of_the_start_are_kept() {
    let start = |velocity: Value| {
        let state = json!({ "name": ["wrist", "shoulder"], "position": [0.1, -0.5], "velocity": velocity });
        made(json!({ "start_state": { "joint_state": state } }), None)
    };
    assert_eq!(start(json!([0, 0.2])).expect("it is good").file.v_start, [0.2]);
    assert_eq!(start(json!([])).expect("it is good").file.v_start, [0.0]);
    for (velocity, words) in [
        (json!([0.1]), "start_state.joint_state: it has 2 names, but 1 velocities"),
        (json!([0.1, 0]), "start_state.joint_state: joint 'wrist' moves at 0.1, and is not planned"),
    ] {
        let error = start(velocity).map(|_| ()).expect_err(words);
        assert!(error.contains(words), "{error}");
    }
    let state = json!({ "name": ["shoulder"], "position": [-0.5], "effort": [3] });
    let error = made(json!({ "start_state": { "joint_state": state } }), None).map(|_| ());
    let error = error.expect_err("it has an effort");
    assert!(error.contains("start_state.joint_state.effort: it is not read: "), "{error}");
}

#[test]
fn a_speed_of_a_link_is_kept() {
    let speed = |most: f64, link: &str| {
        let key = "cartesian_speed_limited_link";
        made(json!({ "max_cartesian_speed": most, key: link }), None)
    };
    let kept = |scenario: Scenario| serde_json::to_value(&scenario.file.keep).expect("it is written");
    let expected = json!([{ "speed": { "frame": "hand", "point_m": [0.0, 0.0, 0.0], "most_m_s": 0.2 } }]);
    assert_eq!(kept(speed(0.2, "hand").expect("it is good")), expected);
    let of_humble = json!({ "max_cartesian_speed": 0.2, "cartesian_speed_end_effector_link": "hand" });
    assert_eq!(kept(made(of_humble, None).expect("it is good")), expected);
    for none in [0.0, -1.0] {
        assert_eq!(kept(speed(none, "hand").expect("it is good")), json!([]));
    }
    for (link, words) in [("", "it is needed with"), ("tool", "the robot has no link 'tool'")] {
        let error = speed(0.2, link).map(|_| ()).expect_err(words);
        assert!(error.contains(&format!("cartesian_speed_limited_link: {words}")), "{error}");
    }
}

/// 3.1 and -3.1 rad are 0.083 rad apart on a continuous joint; on another one they are not the same angle.
#[test]
fn the_goal_of_a_continuous_joint_is_near_its_start() {
    for (start, goal, near, turns) in [
        (3.1, -3.1, 3.183_185_307_179_586, "1 turn"),
        (12.6, 0.1, 12.666_370_614_359_172, "2 turns"),
        (-7.0, 0.0, -std::f64::consts::TAU, "-1 turn"),
        (0.5, -0.5, -0.5, ""),
    ] {
        let joint = json!({ "joint_name": "wrist", "position": goal });
        let scenario = made(
            json!({
                "start_state": { "joint_state": { "name": ["wrist", "shoulder"], "position": [start, 0] } },
                "goal_constraints": [{ "joint_constraints": [joint] }],
            }),
            None,
        );
        let scenario = scenario.expect("it is good");
        assert!((scenario.file.q_goal[0] - near).abs() < 1e-12, "{:?}", scenario.file.q_goal);
        let notes = scenario.load_notes.iter().map(ToString::to_string);
        let notes: Vec<_> = notes.filter(|note| note.contains("turn")).collect();
        let expected = format!("joint 'wrist': its goal was moved by {turns}, as near as possible to its start");
        let expected = if turns.is_empty() { vec![] } else { vec![expected] };
        assert_eq!(notes, expected);
    }
}

#[test]
fn frames_that_are_not_the_base_are_refused() {
    files();
    let object = json!({ "id": "post", "header": { "frame_id": "hand" }, "primitives": [{ "type": "sphere",
        "dimensions": [0.1] }], "primitive_poses": [{ "position": [0, 0, 5], "orientation": [0, 0, 0, 1] }] });
    let moved = json!({ "transform": { "translation": [0, 0, 1], "rotation": [0, 0, 0, 1] } });
    for (key, value, words) in [
        ("world", json!({ "collision_objects": [object] }), "'post'.header.frame_id: the frame 'hand' is not the base"),
        ("fixed_frame_transforms", json!([moved]), "fixed_frame_transforms[0].transform: it moves a frame"),
    ] {
        let mut scene = scene();
        scene[key] = value;
        let error = import(&scene, &request(), None).map(|_| ()).expect_err(words);
        assert!(error.contains(words), "{error}");
    }
}

/// A rotation vector with a free axis allows other rotations than Euler angles.
#[test]
fn a_rotation_vector_has_no_free_axis() {
    let turned = |parameterization: u8, about_z: f64| {
        let upright = json!({ "link_name": "hand", "orientation": [0, 0, 0, 1], "absolute_x_axis_tolerance": 0.1,
            "absolute_y_axis_tolerance": 0.1, "absolute_z_axis_tolerance": about_z,
            "parameterization": parameterization });
        made(json!({ "path_constraints": { "orientation_constraints": [upright] } }), None).map(|_| ())
    };
    assert_eq!([turned(0, 4.0), turned(0, 0.1), turned(1, 0.1)], [Ok(()), Ok(()), Ok(())]);
    for (parameterization, about_z) in [(1, 4.0), (2, 0.1)] {
        let error = turned(parameterization, about_z).expect_err("it is not read");
        assert!(error.contains("orientation_constraints[0].parameterization: it is"), "{error}");
    }
}
