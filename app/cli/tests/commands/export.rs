//! `aghf export`.

use crate::command::{aghf, assert_bad_input, empty_folder};
use aghf_scenario::{JointTrajectory, Stamp};
use byteorder::LittleEndian;
use cdr_encoding::from_bytes;
use mcap::MessageStream;
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Solves a problem among spheres; the motion is swift at its end.
fn solved(folder: &Path) {
    let run = aghf(folder, &["solve", "kinova_obstacles_02", "--out", "run", "--no-report"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

fn exported(folder: &Path, arguments: &[&str]) {
    let run = aghf(folder, &[&["export", "run", "--to"], arguments].concat());
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
}

/// The exported motion is that of the solve: the judge accepts it in both formats, with the numbers of the table up to
/// the rounding of the coefficients in the summary.
#[test]
fn a_trajectory_is_judged_like_the_table() {
    let folder = empty_folder("export_trajectory");
    solved(&folder);
    exported(&folder, &["trajectory"]);
    exported(&folder, &["trajectory", "--format", "json"]);
    let read = |name: &str| {
        let text = std::fs::read_to_string(folder.join("run").join(name)).expect("written");
        JointTrajectory::parse(&text, name).expect("it is one")
    };
    let message = read("trajectory.yaml");
    assert_eq!(message, read("trajectory.json"));
    let text = std::fs::read_to_string(folder.join("run/trajectory.csv")).expect("written");
    let rows = text.lines().skip(1).zip(&message.points);
    assert!(message.points.len() > 200);
    assert_eq!(text.lines().count(), 1 + message.points.len());
    for (row, point) in rows {
        let numbers: Vec<f64> = row.split(',').map(|x| x.parse().expect("a number")).collect();
        assert!((numbers[0] - point.time_from_start.seconds()).abs() <= 0.5e-9);
        let lists = [&point.positions, &point.velocities, &point.accelerations, &point.effort];
        let exported = lists.map(Vec::as_slice).concat();
        assert_eq!(exported.len(), numbers.len() - 1);
        for (own, written) in exported.iter().zip(&numbers[1..]) {
            assert!((own - written).abs() <= 1e-12 * written.abs().max(1.0), "{own} {written}");
        }
    }
    for name in ["run/trajectory.yaml", "run/trajectory.json"] {
        let run = aghf(&folder, &["judge", "kinova_obstacles_02", name]);
        assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    }
    let again = ["export", "run", "--to", "trajectory"];
    assert_bad_input(&folder, &again, "trajectory.yaml: output; --force");
    exported(&folder, &["trajectory", "--force", "--rate", "10"]);
    assert_eq!(read("trajectory.yaml").points.len(), 21);
    assert_bad_input(&folder, &["export", "nowhere", "--to", "mcap"], "nowhere");
}

/// The numbers of a motion may be tiny or huge, and are numbers in YAML 1.1 as well.
#[test]
fn numbers_of_yaml_have_a_point_and_a_signed_exponent() {
    let mut message = JointTrajectory::default();
    message.points.resize_with(1, Default::default);
    message.points[0].positions = vec![1e-7, -2.5e-9, 1e17, 0.0, 3.0];
    message.joint_names = vec!["a \"b\"".to_owned()];
    let mut text = Vec::new();
    aghf_cli::export::write_yaml(&message, &mut text).expect("it is memory");
    let text = String::from_utf8(text).expect("it is text");
    assert!(text.contains("[1.0e-7, -2.5e-9, 1.0e+17, 0.0, 3.0]"), "{text}");
    assert_eq!(JointTrajectory::parse(&text, "it").expect("it is one"), message);
}

/// A `sensor_msgs/JointState` as another program would read it.
#[derive(Deserialize)]
struct State {
    stamp: Stamp,
    _frame: String,
    name: Vec<String>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

#[test]
fn a_recording_has_the_robot_the_plan_and_the_states() {
    let folder = empty_folder("export_mcap");
    solved(&folder);
    exported(&folder, &["mcap"]);
    let bytes = std::fs::read(folder.join("run/motion.mcap")).expect("written");
    let mut counts = BTreeMap::new();
    let (mut states, mut plan) = (Vec::new(), None);
    for message in MessageStream::new(&bytes).expect("it is MCAP") {
        let message = message.expect("it is whole");
        let (topic, schema) = (message.channel.topic.clone(), message.channel.schema.clone());
        let schema = schema.expect("each has one");
        *counts.entry((topic.clone(), schema.name.clone())).or_insert(0) += 1;
        let (encapsulation, body) = message.data.split_at(4);
        assert_eq!(encapsulation, [0, 1, 0, 0]);
        match topic.as_str() {
            "/joint_states" => {
                let (state, _) = from_bytes::<State, LittleEndian>(body).expect("CDR");
                assert_eq!(state.stamp.nanoseconds(), message.log_time);
                states.push(state);
            }
            "/plan" => {
                let read = from_bytes::<JointTrajectory, LittleEndian>(body);
                plan = Some(read.expect("CDR").0);
            }
            _ => {}
        }
    }
    let counted: Vec<_> = counts.iter().map(|((t, s), n)| (t.as_str(), s.as_str(), *n)).collect();
    let wanted = [
        ("/joint_states", "sensor_msgs/msg/JointState", 201),
        ("/obstacles", "visualization_msgs/msg/MarkerArray", 1),
        ("/plan", "trajectory_msgs/msg/JointTrajectory", 1),
        ("/robot_description", "std_msgs/msg/String", 1),
        ("/tf", "tf2_msgs/msg/TFMessage", 201),
    ];
    assert_eq!(counted, wanted);
    let plan = plan.expect("there is one");
    for (state, point) in states.iter().zip(&plan.points) {
        assert_eq!(state.stamp, point.time_from_start);
        assert_eq!(state.name, plan.joint_names);
        let lists = [&state.position, &state.velocity, &state.effort];
        assert_eq!(lists, [&point.positions, &point.velocities, &point.effort]);
    }
    let summary = std::fs::read_to_string(folder.join("run/summary.json")).expect("written");
    let summary: Value = serde_json::from_str(&summary).expect("JSON");
    let goal = &summary["provenance"]["scenario"]["q_goal"];
    let last = states.last().expect("there are some");
    for (x, goal) in last.position.iter().zip(goal.as_array().expect("a list")) {
        assert!((x - goal.as_f64().expect("a number")).abs() < 1e-9);
    }
}

/// Obstacles of a mounted robot are in the world, and a transform has the place of its root there.
#[test]
fn a_recording_of_a_mounted_robot_has_the_world() {
    let folder = empty_folder("export_mounted");
    let world = |keys: Value| {
        let mut scenario = json!({
            "robot": "pendulum_2", "horizon_s": 1.0, "q_start": [0.1, 0.2], "v_start": [0, 0], "q_goal": [0.5, 0.1],
            "v_goal": [0, 0], "obstacles": [{ "shape": { "sphere": { "radius_m": 0.1 } },
                "pose": { "position_m": [9, 9, 9] } }],
        });
        scenario.as_object_mut().expect("an object").extend(keys.as_object().expect("an object").clone());
        std::fs::write(folder.join("own.json"), scenario.to_string()).expect("the folder is writable");
        let run = aghf(&folder, &["solve", "own.json", "--out", "run", "--no-report", "--force"]);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        exported(&folder, &["mcap", "--force"]);
        let bytes = std::fs::read(folder.join("run/motion.mcap")).expect("written");
        let mut topics = BTreeSet::new();
        for message in MessageStream::new(&bytes).expect("it is MCAP") {
            let message = message.expect("it is whole");
            if message.data.windows(6).any(|text| text == b"world\0") {
                topics.insert(message.channel.topic.clone());
            }
        }
        topics.into_iter().collect::<Vec<_>>()
    };
    assert_eq!(
        world(json!({ "mount": { "position_m": [0, 0, 2], "orientation_xyzw": [1, 0, 0, 0] } })),
        ["/joint_states", "/obstacles", "/tf"]
    );
    assert!(world(json!({})).is_empty());
}

/// Several motions, each from the state and the acceleration in which the one before ends, are one trajectory; others
/// are refused.
#[test]
fn motions_that_continue_each_other_are_one_trajectory() {
    let folder = empty_folder("export_several");
    let solve = |name: &str, keys: Value| {
        let mut scenario = json!({
            "robot": "pendulum_2", "horizon_s": 1.0, "q_start": [0.1, 0.2], "v_start": [0, 0], "q_goal": [0.5, 0.1],
            "v_goal": [0.6, -0.3],
        });
        scenario.as_object_mut().expect("an object").extend(keys.as_object().expect("an object").clone());
        std::fs::write(folder.join(format!("{name}.json")), scenario.to_string()).expect("the folder is writable");
        let run = aghf(&folder, &["solve", &format!("{name}.json"), "--out", name, "--no-report"]);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    };
    solve("first", json!({}));
    let table = std::fs::read_to_string(folder.join("first/trajectory.csv")).expect("written");
    let last = table.lines().last().expect("a row").split(',').map(|x| x.parse().expect("a number"));
    let last: Vec<f64> = last.collect();
    let from = json!({ "q_start": [0.5, 0.1], "v_start": [0.6, -0.3], "q_goal": [1.0, 0.0], "v_goal": [0, 0] });
    let with = |keys: Value| {
        let mut all = from.clone();
        all.as_object_mut().expect("an object").extend(keys.as_object().expect("an object").clone());
        all
    };
    solve("second", with(json!({ "a_start": last[5..7] })));
    solve("jumping", from.clone());
    let several = |runs: &[&str], to: &str| aghf(&folder, &[&["export"], runs, &["--to", to, "--force"]].concat());
    let run = several(&["first", "second"], "trajectory");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let text = std::fs::read_to_string(folder.join("first/trajectory.yaml")).expect("written");
    let message = JointTrajectory::parse(&text, "trajectory.yaml").expect("it is one");
    assert_eq!((message.header.frame_id.as_str(), message.points.len()), ("", 401));
    let times: Vec<_> = message.points.iter().map(|point| point.time_from_start.nanoseconds()).collect();
    assert!(
        times.windows(2).all(|pair| pair[0] < pair[1]) && times[200] == 1_000_000_000 && times[400] == 2_000_000_000
    );
    let last = &message.points[400].positions;
    assert!((last[0] - 1.0).abs() < 1e-12 && last[1].abs() < 1e-12, "{last:?}");
    for (runs, to, words) in [
        (["first", "jumping"], "trajectory", "jumping/summary.json: joint 'joint_1': its acceleration at the start is"),
        (
            ["second", "first"],
            "trajectory",
            "first/summary.json: joint 'joint_1': its position at the start is 0.1, and 1 at",
        ),
        (["first", "second"], "mcap", "first/summary.json: mcap: a recording has one motion, a trajectory several"),
    ] {
        let run = several(&runs, to);
        assert_eq!(run.code, Some(2), "{}", run.stdout);
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
}
