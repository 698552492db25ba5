//! Obstacles of every shape and the collision shapes of the robot.

use crate::written::{folder, load, solved_once, with};
use aghf::constraint::{AnyConstraint, Constraint};
use aghf::dynamics::forward_kinematics;
use aghf::geometry::{Shape, Sphere};
use aghf::spatial::Placement;
use aghf::urdf::builtin_robot;
use aghf_scenario::{RobotShape, Scenario, link_shapes};
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::path::Path;

/// The start of every problem of MotionBenchMaker.
const READY: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];

/// A Panda among obstacles of every shape.
pub fn panda() -> Value {
    json!({
        "robot": "panda", "horizon_s": 2.0,
        "q_start": READY, "v_start": [0, 0, 0, 0, 0, 0, 0],
        "q_goal": [0.5, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], "v_goal": [0, 0, 0, 0, 0, 0, 0],
        "robot_shape": { "collision": {} },
        "obstacles": [
            { "shape": { "box": { "size_m": [0.2, 0.4, 0.6] } }, "pose": { "position_m": [0.0, 0.0, 2.0] } },
            { "name": "lid", "shape": { "box": { "size_m": [1, 1, 0.1] } },
              "pose": { "position_m": [0.0, 2.0, 0.0], "orientation_xyzw": [0.0, 0.0, 0.6, 0.8] } },
            { "name": "post", "shape": { "cylinder": { "radius_m": 0.1, "length_m": 3.0 } },
                "pose": { "position_m": [2.0, 0.0, 0.0] } },
            { "shape": { "capsule": { "radius_m": 0.2, "length_m": 1.0 } },
                "pose": { "position_m": [0.0, -2.0, -0.5] } }
        ],
        "self_collision": { "ignored_pairs": [["panda_link0", "panda_link1"], ["panda_hand", "panda_link6"]] }
    })
}

#[test]
fn obstacles_are_placed_as_the_keys_say() {
    let scenario = load("placed", &panda()).expect("it is good");
    let solids: Vec<_> = scenario.scene.obstacles().iter().map(|o| o.solid).collect();
    let half_extents = Vector3::new(0.1, 0.2, 0.3);
    assert_eq!(solids[0].shape, Shape::Cuboid { half_extents });
    assert_eq!(solids[0].placement.translation, Vector3::new(0.0, 0.0, 2.0));
    // A turn about z by the angle whose half has the sine 0.6.
    let [sin, cos] = [2.0 * 0.6 * 0.8, 0.8 * 0.8 - 0.6 * 0.6];
    let x = solids[1].placement.rotation.column(0).into_owned();
    assert!((x - Vector3::new(cos, sin, 0.0)).norm() < 1e-15);
    let (radius, half_length) = (0.1, 1.5);
    let post = Shape::Cylinder { radius, half_length };
    assert_eq!(solids[2].shape, post);
    // The ends of the segment are on the surface of a capsule moved in by its radius, those beyond are outside.
    for (z, distance) in [(0.0, -0.2), (-1.0, -0.2), (0.3, 0.1), (-1.3, 0.1)] {
        let found: f64 = solids[3].distance(&Vector3::new(0.0, -2.0, z));
        assert!((found - distance).abs() < 1e-15, "{found}, {distance}");
    }
    let names: Vec<_> = scenario.scene.obstacles().iter().map(|o| &*o.name).collect();
    assert_eq!(names, ["obstacles[0]", "lid", "post", "obstacles[3]"]);
}

/// The clearance is that of the nearest ball, and a ball that touches an obstacle is told by link and obstacle.
#[test]
fn clearances_and_overlaps_are_those_of_the_balls_of_the_links() {
    let model = builtin_robot("panda").expect("built in");
    let robot = link_shapes(&model, Path::new(""), 0.05).expect("spheres");
    assert_eq!((robot.balls.len(), robot.links.len()), (59, 59));
    let mut placements = vec![Placement::identity(); 7];
    forward_kinematics(&model, &READY, &mut placements).expect("lengths agree");
    // A box below the lowest ball of the hand.
    let balls = robot.placed(&placements).expect("lengths agree");
    let bottom = |b: &Sphere| b.centre.z - b.radius;
    let in_front = balls.iter().zip(&robot.links).filter(|(b, _)| b.centre.x > 0.3);
    let lowest = in_front.min_by(|(a, _), (b, _)| bottom(a).total_cmp(&bottom(b)));
    let (lowest, link) = lowest.expect("there is one");
    let table = |gap: f64| {
        let [x, y, _]: [f64; 3] = lowest.centre.into();
        let center = [x, y, bottom(lowest) - gap - 0.05];
        json!({ "name": "table", "shape": { "box": { "size_m": [0.2, 0.2, 0.1] } }, "pose": { "position_m": center } })
    };
    let capsule = &panda()["obstacles"][3];
    let scenario = |gap: f64| {
        let alone = with(panda(), json!({ "obstacles": [table(gap), capsule] }));
        load("clearance", &with(alone, json!({ "self_collision": "off" }))).expect("it is good")
    };
    let clear = scenario(0.02);
    let found = clear.scene.clearance(&placements).expect("lengths agree");
    assert!((found - 0.02).abs() < 1e-12, "{found}");
    clear.check_feasible().expect("it is clear of the table");
    let error = scenario(-0.01).check_feasible().expect_err("it is in the table").to_string();
    let words = format!("q_start: link '{link}' is 1.000e-2 m inside 'table'");
    assert!(error.contains(&words), "{error}; {words}");
    let rows = AnyConstraint::of_scene(&clear.scene);
    // The ball of the base is none.
    assert_eq!(rows.iter().map(Constraint::dim).sum::<usize>(), 58 * 2);
}

/// With a joint locked, and with the joints between the base and it, the shapes stay where they were.
#[test]
fn a_robot_with_locked_joints_keeps_its_shapes() {
    let clearance = |scenario: &Scenario| {
        let mut placements = vec![Placement::identity(); scenario.model.dof()];
        forward_kinematics(&scenario.model, &scenario.file.q_start, &mut placements).expect("lengths agree");
        let found = scenario.scene.clearance(&placements);
        found.expect("lengths agree")
    };
    let near = json!({ "shape": { "sphere": { "radius_m": 0.05 } }, "pose": { "position_m": [0.3, 0.1, 0.3] } });
    let near = with(panda(), json!({ "obstacles": [near], "self_collision": "off" }));
    let whole = clearance(&load("locked", &near).expect("it is good"));
    for locked in [&[3][..], &[0, 1], &[1, 4, 6]] {
        let left = |q: &[f64]| {
            let kept = q.iter().enumerate().filter(|(i, _)| !locked.contains(i));
            json!(kept.map(|(_, q)| *q).collect::<Vec<_>>())
        };
        let joints: serde_json::Map<_, _> =
            locked.iter().map(|i| (format!("panda_joint{}", i + 1), json!(READY[*i]))).collect();
        let (q, zeros) = (left(&READY), left(&[0.0; 7]));
        let keys = json!({ "locked_joints": joints, "q_start": q, "q_goal": q, "v_start": zeros, "v_goal": zeros });
        let reduced = load("locked", &with(near.clone(), keys)).expect("it is good");
        let found = clearance(&reduced);
        assert!((found - whole).abs() < 1e-12, "{locked:?}: {found}, {whole}");
    }
}

/// Asserts that each scenario is refused with all words (between semicolons).
fn assert_refused<const N: usize>(cases: [(Value, &str); N]) {
    for (scenario, words) in cases {
        let error = load("bad", &scenario).expect_err(words);
        assert!(words.split(';').all(|w| error.contains(w)), "{error}; {words}");
    }
}

#[test]
fn bad_obstacles_are_refused_by_key() {
    let one = |i: usize, pointer: &str, value: Value| {
        let mut obstacle = panda()["obstacles"][i].clone();
        *obstacle.pointer_mut(pointer).expect("there is such a key") = value;
        with(panda(), json!({ "obstacles": [obstacle] }))
    };
    let coloured = json!({ "position_m": [0, 0, 0], "colour": "red" });
    assert_refused([
        (one(0, "/shape/box/size_m", json!([1, 1, 0])), "obstacles[0]: size_m has 0"),
        (one(0, "/shape/box/size_m", json!([1, 1])), "obstacles[0].shape.box.size_m: ;length 2"),
        (one(0, "/pose/position_m", json!([1e9, 0, 0])), "obstacles[0]: position_m"),
        (one(1, "/pose/orientation_xyzw", json!([0, 0, 0, 2])), "obstacles[0]: ;has length 2"),
        (one(0, "/pose", coloured), "obstacles[0].pose.colour: "),
        (one(2, "/shape/cylinder/radius_m", json!(-1)), "obstacles[0]: radius_m has -1"),
        (one(2, "/shape/cylinder/length_m", json!(0)), "obstacles[0]: length_m has 0"),
        (one(3, "/shape/capsule/length_m", json!(0)), "obstacles[0]: length_m has 0"),
        (one(3, "/shape/capsule/radius_m", json!(0)), "obstacles[0]: radius_m has 0"),
    ]);
}

#[test]
fn bad_shapes_of_the_robot_are_refused_by_key() {
    let own = |pairs: Value| with(panda(), json!({ "self_collision": pairs }));
    let shape = |shape: Value| with(panda(), json!({ "robot_shape": shape }));
    let shapeless = json!({ "robot": "pendulum_1", "robot_shape": { "collision": {} } });
    assert_refused([
        (
            own(json!({ "ignored_pairs": [["panda_link0", "panda_leg"]] })),
            "self_collision.ignored_pairs[0]: ;'panda_leg'",
        ),
        (
            own(json!({ "ignored_pairs": [["a", "b"], ["c"]] })),
            "self_collision: ;ignored_pairs[1] is [\"c\"] and must be",
        ),
        (own(json!({ "ignored_pairs_file": "nowhere.json" })), "self_collision: ;nowhere.json"),
        (own(json!({ "pairs": [] })), "self_collision: ;the key ignored_pairs or"),
        (own(json!({})), "self_collision: ;the key ignored_pairs or"),
        (own(json!("on")), "self_collision: ;\"off\" or an object"),
        (shape(json!("collision")), "robot_shape.collision: ;{\"collision\": {...}} is needed"),
        (shape(json!("joint_frames")), "self_collision: ;'collision' only"),
        (shape(json!({ "collision": { "excess_m": 0 } })), "robot_shape: ;positive excess"),
        (with(panda(), shapeless), "robot_shape: ;no;collision element"),
    ]);
}

/// Those that are in the repository can be begun and ended, and name the robot that is built in.
#[test]
fn problems_of_motion_bench_maker_are_scenarios() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("robots/panda/scenarios");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("it is there") {
        let path = entry.expect("readable").path();
        let scenario = Scenario::load(path.to_str().expect("it is text")).expect("it is good");
        assert_eq!(scenario.file.robot, "panda");
        assert!(scenario.scene.obstacles().len() > 2, "{}", path.display());
        scenario.check_feasible().unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        count += 1;
    }
    assert_eq!(count, 35);
}

/// A sphere 500 m away is in no way of a pendulum: its position is meant in mm.
#[test]
fn an_obstacle_far_away_gets_a_remark() {
    let note = |x: f64| {
        let scenario = json!({
            "robot": "pendulum_2", "horizon_s": 2.0,
            "q_start": [0, 0], "v_start": [0, 0], "q_goal": [1.0, 0.5], "v_goal": [0, 0],
            "obstacles": [{ "shape": { "sphere": { "radius_m": 1.0 } }, "pose": { "position_m": [x, 0.0, 0.0] } }]
        });
        let scenario = load("far", &scenario).expect("it is good");
        let notes = solved_once(&scenario).summary.notes;
        notes.into_iter().find(|note| note.contains("millimetres"))
    };
    assert_eq!(note(50.0), None);
    let told = note(501.0).expect("it is far");
    assert!(told.starts_with("'obstacles[0]' is 500 m from the base"), "{told}");
}

/// A problem of Kinova that says nothing of shapes.
fn kinova() -> Value {
    json!({
        "robot": "kinova_gen3", "horizon_s": 2.0,
        "q_start": [0, 0.5, 0, 1.0, 0, 0.5, 0], "v_start": [0, 0, 0, 0, 0, 0, 0],
        "q_goal": [0.2, 0.5, 0, 1.0, 0, 0.5, 0], "v_goal": [0, 0, 0, 0, 0, 0, 0],
        "obstacles": [{ "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [2.0, 0.0, 0.5] } }]
    })
}

/// By default the shapes of a robot keep clear of obstacles and of each other, with a note; keys say otherwise.
#[test]
fn shapes_keep_clear_by_default() {
    let kinova = kinova();
    let pendulum = json!({
        "robot": "pendulum_1", "horizon_s": 2.0, "q_start": [0], "v_start": [0], "q_goal": [0.2], "v_goal": [0],
        "obstacles": kinova["obstacles"]
    });
    let both = "robot_shape: the collision shapes of the robot keep clear of obstacles, and of each other";
    let shapes = json!({ "collision": { "excess_m": 0.02 } });
    for (scenario, keys, links, told) in [
        (&kinova, json!({}), true, Some(both)),
        (&kinova, json!({ "obstacles": [] }), true, Some(both)),
        (&kinova, json!({ "robot_shape": shapes }), true, Some("self_collision: links keep clear")),
        (&kinova, json!({ "robot_shape": shapes, "self_collision": "off" }), false, None),
        (&kinova, json!({ "robot_shape": "joint_frames" }), false, None),
        (
            &kinova,
            json!({ "self_collision": "off" }),
            false,
            Some("robot_shape: the collision shapes of the robot keep clear of obstacles;"),
        ),
        (&pendulum, json!({}), false, Some("robot_shape: the robot has no collision shapes")),
        (&pendulum, json!({ "obstacles": [] }), false, None),
    ] {
        let scenario = load("noted", &with(scenario.clone(), keys.clone())).expect("it is good");
        let has_shapes = !scenario.scene.robot().links.is_empty();
        let is_collision = matches!(scenario.robot_shape(), RobotShape::Collision { .. });
        assert_eq!(has_shapes, is_collision, "{keys}");
        assert_eq!(scenario.keeps_links_clear(), links, "{keys}");
        assert_eq!(scenario.scene.tree_pairs().is_empty(), !links, "{keys}");
        let notes = solved_once(&scenario).summary.notes;
        let about = |note: &&String| note.starts_with("robot_shape") || note.starts_with("self_collision: links keep");
        let note = notes.iter().find(about);
        match told {
            Some(told) => assert!(note.is_some_and(|note| note.starts_with(told)), "{keys}: {note:?}"),
            None => assert_eq!(note, None, "{keys}"),
        }
    }
}

#[test]
fn shapes_are_written_as_they_were_read() {
    let written = |scenario: &Value| {
        let file = load("noted", scenario).expect("it is good").file;
        serde_json::to_value(&file).expect("it is written")
    };
    let silent = written(&kinova());
    assert!(silent.get("robot_shape").is_none() && silent.get("self_collision").is_none());
    let off = written(&with(kinova(), json!({ "self_collision": "off" })));
    assert_eq!(off["self_collision"], "off");
}

/// A shape that nobody asked for and that cannot be read is refused with the key that does without.
#[test]
fn a_shape_by_default_that_cannot_be_read_is_refused_with_the_way_out() {
    let urdf = r#"<robot name="one"><link name="base"/><link name="arm">
        <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
        <collision><geometry><mesh filename="nowhere.stl"/></geometry></collision></link>
        <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint>
        </robot>"#;
    std::fs::write(folder().join("nowhere.urdf"), urdf).expect("it is writable");
    let scenario = json!({
        "robot": "nowhere.urdf", "horizon_s": 1.0, "q_start": [0], "v_start": [0], "q_goal": [0.1], "v_goal": [0]
    });
    let error = load("nowhere", &scenario).expect_err("there is no mesh");
    assert!(error.contains("nowhere.stl") && error.contains("\"robot_shape\": \"joint_frames\""), "{error}");
    let shape = json!({ "robot_shape": { "collision": {} } });
    let asked = load("nowhere", &with(scenario.clone(), shape)).expect_err("there is no mesh");
    assert!(!asked.contains("joint_frames"), "{asked}");
    let without = with(scenario, json!({ "robot_shape": "joint_frames" }));
    load("nowhere", &without).expect("it needs no mesh");
}

/// A robot that is turned and moved with its obstacles, and under gravity as it points there, has the same problem.
#[test]
fn a_robot_can_be_mounted_anywhere() {
    let among = |at: [f64; 3], keys: Value| {
        let ball = json!([{ "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": at } }]);
        let keys = with(keys, json!({ "obstacles": ball }));
        load("mounted", &with(panda(), keys)).expect("it is good")
    };
    // From the ceiling, half a turn about the x axis, with gravity upwards in the world.
    let turned = json!({ "mount": { "position_m": [0.5, 0.25, 2.0], "orientation_xyzw": [1, 0, 0, 0] } });
    let upwards = with(turned.clone(), json!({ "gravity": [0, 0, 9.81] }));
    let (free, free_turned, hit, hit_turned) = ([0.3, 0.3, 1.0], [0.8, -0.05, 1.0], [0.3, 0.0, 0.6], [0.8, 0.25, 1.4]);
    let cost = |scenario: &Scenario| solved_once(scenario).summary.control_effort;
    let upright = cost(&among(free, json!({})));
    let mounted = cost(&among(free_turned, upwards.clone()));
    assert!((mounted / upright - 1.0).abs() < 1e-3, "{mounted} {upright}");
    let hanging = cost(&among(free_turned, turned));
    assert!((hanging / upright - 1.0).abs() > 1e-2, "{hanging} {upright}");
    let moon = cost(&among(free, json!({ "gravity": [0, 0, -1.62] })));
    assert!(moon < 0.1 * upright, "{moon} {upright}");
    assert!(among(hit, json!({})).check_feasible().is_err());
    assert!(among(hit_turned, upwards.clone()).check_feasible().is_err());
    assert!(among(hit, upwards).check_feasible().is_ok());
}
