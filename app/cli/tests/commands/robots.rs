//! `aghf robots` lists the robots that are built in and shows those in files.

use crate::command::{aghf, assert_bad_input, empty_folder, files, parsed};
use aghf::urdf::builtin_robots;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn urdf_path(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(format!("robots/{name}/{name}.urdf"))
}

#[test]
fn robots_lists_all_that_are_built_in() {
    let folder = empty_folder("robots");
    let run = aghf(&folder, &["robots"]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let all = parsed(&aghf(&folder, &["robots", "--json"]));
    let listed: Vec<_> = all.as_array().expect("a list").iter().map(|r| r["robot"].clone()).collect();
    assert_eq!(listed, builtin_robots().collect::<Vec<_>>());
    for name in builtin_robots() {
        assert!(run.stdout.lines().any(|l| l.starts_with(&format!("{name}: "))), "{name}");
    }
}

#[test]
fn a_robot_has_joints_limits_and_masses_in_json() {
    let folder = empty_folder("robot_json");
    let all = parsed(&aghf(&folder, &["robots", "kinova_gen3", "--json"]));
    assert_eq!(all.as_array().map(Vec::len), Some(1));
    let joints = all[0]["joints"].as_array().expect("a list");
    assert_eq!(joints.len(), 7);
    let masses = [1.3773, 1.1636, 1.1636, 0.9302, 0.6781, 0.6781, 0.5];
    for (i, joint) in joints.iter().enumerate() {
        assert_eq!(joint["name"], format!("joint_{}", i + 1));
        assert_eq!((&joint["kind"], &joint["mass_kg"]), (&json!("revolute"), &json!(masses[i])));
    }
    let limits = ["lower", "upper", "velocity", "effort", "parent"].map(|key| joints[3][key].clone());
    assert_eq!(limits, [json!(-2.58), json!(2.58), json!(1.3963), json!(39.0), json!("joint_3")]);
    assert_eq!(joints[0]["parent"], Value::Null);
    assert!((all[0]["mass_kg"].as_f64().expect("a number") - 6.4909).abs() < 1e-12);
    let notes = all[0]["notes"].to_string();
    assert!(notes.contains("end_effector_link") && notes.contains("joint_7"), "{notes}");

    let pendulum = parsed(&aghf(&folder, &["robots", "pendulum_1", "--json"]));
    let joint = &pendulum[0]["joints"][0];
    assert_eq!((&joint["kind"], &joint["lower"], &joint["effort"]), (&json!("continuous"), &Value::Null, &Value::Null));
}

#[test]
fn a_robot_is_shown_with_joints_limits_and_masses() {
    let folder = empty_folder("robot");
    let run = aghf(&folder, &["robots", "kinova_gen3"]);
    let row = run.stdout.lines().find(|l| l.contains("joint_4")).expect("a row a joint");
    assert!(["revolute", "joint_3", "-2.58", "1.3963", "39.0"].iter().all(|w| row.contains(w)), "{row}");
    assert!(run.stdout.contains("kinova_gen3: 7 joints, 6.4909 kg"), "{}", run.stdout);

    // Digits show what is said, however large or small it is.
    let text = std::fs::read_to_string(urdf_path("pendulum_1")).expect("it exists");
    for (mass, shown) in [("1e300", "1.000e300 kg"), ("1e-5", "1.000e-5 kg")] {
        let heavy = text.replace(r#"<mass value="1"/>"#, &format!(r#"<mass value="{mass}"/>"#));
        std::fs::write(folder.join("heavy.urdf"), heavy).expect("writable");
        let run = aghf(&folder, &["robots", "heavy.urdf"]);
        assert!(run.stdout.contains(shown) && run.stdout.len() < 1000, "{}", run.stdout);
    }
}

#[test]
fn robots_reads_files_and_refuses_bad_ones() {
    let folder = empty_folder("robot_files");
    let path = urdf_path("pendulum_2");
    let file = path.to_str().expect("it is text");
    let (read, built_in) = (
        parsed(&aghf(&folder, &["robots", file, "--json"])),
        parsed(&aghf(&folder, &["robots", "pendulum_2", "--json"])),
    );
    assert_eq!(read[0]["joints"], built_in[0]["joints"]);
    assert_bad_input(&folder, &["robots", "hexapod"], "aghf: hexapod: robot: ; neither a file nor a built-in robot");
    let text = std::fs::read_to_string(&path).expect("it exists");
    let broken = text.replace(r#"<mass value="1"/>"#, r#"<mass value="-1"/>"#);
    std::fs::write(folder.join("broken.urdf"), broken).expect("writable");
    assert_bad_input(&folder, &["robots", "broken.urdf"], "aghf: broken.urdf: link 'link_1': ; negative");
}

/// A gripper whose second finger mimics the first.
const GRIPPER: &str = r#"<robot name="gripper"><link name="palm"/>
  <link name="left"><inertial><mass value="0.1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="right"><inertial><mass value="0.2"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="a" type="prismatic"><parent link="palm"/><child link="left"/>
    <limit lower="0" upper="0.1" velocity="1" effort="2"/></joint>
  <joint name="b" type="prismatic"><parent link="palm"/><child link="right"/><mimic joint="a"/>
    <limit lower="0" upper="0.1" velocity="1" effort="2"/></joint></robot>"#;

#[test]
fn mimic_joints_move_by_themselves_where_that_is_asked_for() {
    let folder = empty_folder("mimic");
    std::fs::write(folder.join("gripper.urdf"), GRIPPER).expect("writable");
    let state = r#"{"q": [0, 0], "v": [0, 0], "a": [1, 2]}"#;
    std::fs::write(folder.join("state.json"), state).expect("writable");
    for command in [
        &["robots", "gripper.urdf"][..],
        &["check", "gripper.urdf", "--samples", "1"],
        &["eval", "gripper.urdf", "state.json"],
    ] {
        let words = "aghf: gripper.urdf: joint 'b': ; mimics joint 'a'; --mimic independent";
        assert_bad_input(&folder, command, words);
        let run = aghf(&folder, &[command, &["--mimic", "independent"]].concat());
        // The list has it among its notes.
        let note = match command[0] {
            "robots" => "",
            _ => "note: gripper.urdf: joint 'b': mimics 'a', independent here\n",
        };
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), note), "{command:?}");
    }
    let all = parsed(&aghf(&folder, &["robots", "gripper.urdf", "--mimic", "independent", "--json"]));
    let notes = all[0]["notes"].to_string();
    assert!(notes.contains("joint 'b': mimics 'a', independent here"), "{notes}");
}

#[test]
fn robots_are_written_as_urdf() {
    let folder = empty_folder("written");
    let written = aghf(&folder, &["robots", "kinova_gen3", "--urdf", "arm.urdf"]);
    assert_eq!((written.code, written.stderr.as_str()), (Some(0), ""));
    assert_eq!(files(&folder), ["arm.urdf".to_owned()].into(), "complete and alone");
    let [read, built_in] =
        ["arm.urdf", "kinova_gen3"].map(|robot| parsed(&aghf(&folder, &["robots", robot, "--json"])));
    assert_eq!(read[0]["joints"], built_in[0]["joints"]);

    let nowhere = ["robots", "kinova_gen3", "--urdf", "no/such/arm.urdf"];
    assert_bad_input(&folder, &nowhere, "no/such/arm.urdf: ; No such file");
    let run = aghf(&folder, &["robots", "--urdf", "arm.urdf"]);
    assert_eq!(run.code, Some(2), "of which robot? {}", run.stdout);
}
