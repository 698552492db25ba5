//! `aghf doctor` says what the file of a robot can be used for.

use crate::command::{Run, aghf, assert_bad_input, empty_folder, parsed};
use aghf::urdf::builtin_robots;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A robot with nearly everything that can be in the way. `arm` and `hand` are spheres that touch at zero and not at
/// a quarter turn of `bend`; `hand` is in `fist`, which always overlaps it.
const ROBOT: &str = r#"<robot name="ill">
  <link name="base"><collision><geometry><mesh filename="package://parts/base.dae"/></geometry></collision></link>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><origin xyz="0.3 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="mid"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="9"/></inertial>
  </link>
  <link name="hand"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><origin xyz="0.45 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="fist"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>
  <link name="camera"/>
  <joint name="float" type="FLOAT"><parent link="base"/><child link="arm"/></joint>
  <joint name="turn" type="revolute"><parent link="arm"/><child link="mid"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="0" effort="0"/><dynamics damping="0.5" friction="0.1"/></joint>
  <joint name="bend" type="revolute"><parent link="mid"/><child link="hand"/><axis xyz="0 0 1"/></joint>
  <joint name="follow" type="revolute"><parent link="hand"/><child link="fist"/><axis xyz="0 0 1"/>
    <origin xyz="0.1 0 0"/><limit lower="-2" upper="2" velocity="1" effort="1" acceleration="9"/>
    <mimic joint="turn" multiplier="-2" offset="0.5"/></joint>
  <joint name="pan" type="continuous"><parent link="fist"/><child link="camera"/></joint>
</robot>"#;

const SRDF: &str = r#"<robot name="ill"><disable_collisions link1="fist" link2="hand"/>
  <disable_collisions link1="tail" link2="hand"/>
  <group_state name="bent"><joint name="bend" value="1.5"/><joint name="wheel" value="1"/></group_state>
  <group_state name="straight" group="arm"><joint name="turn" value="0"/></group_state></robot>"#;

/// A triangle in COLLADA, in the sphere of `arm`.
const MESH: &str = r##"<COLLADA><library_geometries><geometry id="g"><mesh>
  <source id="s"><float_array>0.21 0 0 0.22 0 0 0.21 0.01 0</float_array>
    <technique_common><accessor source="#f" count="3" stride="3"/></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
  <triangles><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>
  </library_geometries><library_visual_scenes><visual_scene id="scene"><node><instance_geometry url="#g"/></node>
  </visual_scene></library_visual_scenes><scene><instance_visual_scene url="#scene"/></scene></COLLADA>"##;

/// A folder with the robot, its first joint of this kind.
fn folder(test: &str, first: &str) -> PathBuf {
    let folder = empty_folder(test);
    std::fs::create_dir(folder.join("there")).expect("it is writable");
    for (name, text) in
        [("ill.urdf", ROBOT.replace("FLOAT", first).as_str()), ("ill.srdf", SRDF), ("there/base.dae", MESH)]
    {
        std::fs::write(folder.join(name), text).expect("it is writable");
    }
    folder
}

fn doctor(folder: &Path, more: &[&str]) -> Run {
    aghf(folder, &[&["doctor", "ill.urdf"], more].concat())
}

/// The findings with such words in their condition, and the names in them.
pub fn found(diagnosis: &Value, words: &str) -> Vec<(String, Vec<String>)> {
    let text = |value: &Value| value.as_str().expect("it is text").to_owned();
    let findings = diagnosis["findings"].as_array().expect("a list").iter();
    let with_words = findings.filter(|finding| text(&finding["condition"]).contains(words));
    with_words
        .map(|finding| {
            let names = finding["names"].as_array().expect("a list");
            (text(&finding["severity"]), names.iter().map(text).collect())
        })
        .collect()
}

#[test]
fn built_in_robots_can_be_planned_for() {
    let folder = empty_folder("doctor_built_in");
    for robot in builtin_robots() {
        let diagnosis = parsed(&aghf(&folder, &["doctor", robot, "--json"]));
        assert_eq!(diagnosis["plannable"], "yes", "{robot}: {diagnosis}");
    }
}

#[test]
fn each_finding_names_its_elements() {
    let folder = folder("doctor_findings", "revolute");
    let run = doctor(&folder, &["--json", "--srdf", "ill.srdf", "--package", "parts=there"]);
    let diagnosis = parsed(&run);
    assert_eq!(diagnosis["plannable"], "with_keys");
    assert_eq!(diagnosis["joints"], json!({ "continuous": 1, "revolute": 4 }));
    let [needs, note] = ["needs_key", "note"];
    for (words, severity, names) in [
        ("it follows another joint", needs, &["follow = -2 turn + 0.5"][..]),
        ("nothing that it moves has inertia", note, &["pan"]),
        ("no limits of any kind", note, &["float", "bend", "pan"]),
        ("no limit of velocity", note, &["turn"]),
        ("no limit of effort", note, &["turn"]),
        ("no limit of acceleration", note, &["float", "turn", "bend", "pan"]),
        ("acceleration or jerk, not kept", note, &["follow"]),
        ("damping is not counted", note, &["turn"]),
        ("friction is not counted", note, &["turn"]),
        ("counts as massless", note, &["camera"]),
        ("exceeds the sum", note, &["mid"]),
        ("neighbours, or overlap in all samples, and the SRDF does not", note, &["arm and base (neighbours)"]),
        ("the state 'bent' of the SRDF has it", note, &["wheel"]),
        ("the SRDF has a pair of links with it", note, &["tail"]),
        ("the radius of gyration", note, &["arm (1.00 m)", "mid (3.00 m)", "hand (1.00 m)", "fist (1.00 m)"]),
        ("the centre of mass is", note, &["hand (0.35 m)"]),
        ("links overlap there", note, &["zero", "straight of arm"]),
    ] {
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        assert_eq!(found(&diagnosis, words), [(severity.to_owned(), names)], "{words}");
    }
    assert_eq!(found(&diagnosis, "").len(), 17, "{diagnosis}");
    let shapes = diagnosis["shapes"]["shapes"].as_array().expect("a list");
    assert!(shapes.iter().all(|shape| shape["unread"].is_null()), "{shapes:?}");
    assert_eq!(shapes[0]["mesh"], true);
    // The spheres have centres 0.15 apart and radii of 0.1; `arm` and `fist` are apart.
    let contacts = |state: usize| diagnosis["states"][state]["contacts"].as_array().cloned();
    assert_eq!(contacts(1), Some(Vec::new()), "bent");
    for state in [0, 2] {
        let contacts = contacts(state).expect("a list");
        assert_eq!(contacts.len(), 1, "{contacts:?}");
        assert_eq!(contacts[0]["links"], json!(["arm", "hand"]));
        let depth = contacts[0]["depth_m"].as_f64().expect("a number");
        assert!((depth - 0.05).abs() < 1e-12 && contacts[0]["excess_m"] == 0.0);
    }
}

#[test]
fn what_is_refused_is_a_finding_and_the_rest_is_examined() {
    let folder = folder("doctor_refused", "floating");
    let robot =
        ROBOT.replace("FLOAT", "floating").replace("name=\"pan\" type=\"continuous\"", "name=\"pan\" type=\"wheel\"");
    std::fs::write(folder.join("ill.urdf"), robot).expect("it is writable");
    let run = doctor(&folder, &[]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(3), ""));
    for words in [
        "ill.urdf: motions cannot be planned with this file",
        "In the way",
        "file 'ill.urdf': joint 'pan': there is no joint type 'wheel'\n    remedy: the element has to be changed",
        "Needs a key\n  joint 'float': it has several degrees of freedom",
        "remedy: \"srdf\": FILE and \"group\": NAME (--group NAME) of joints without it",
        "remedy: \"srdf\": FILE and \"group\": NAME",
        "not found; another format",
        "  1 not read, shape 'package://parts/base.dae': there is no such file; --package parts=FOLDER",
        "environment variable ROS_PACKAGE_PATH",
        "0, 1 not read",
        "zero: arm and hand by 50.0 mm (excess 0.0 mm)",
    ] {
        assert!(run.stdout.contains(words), "{words}:\n{}", run.stdout);
    }
    // What does not move against each other does not touch.
    let run = doctor(&folder, &["--package", "parts=there"]);
    let overlaps = "zero: arm and hand by 50.0 mm (excess 0.0 mm)\n";
    assert!(run.stdout.ends_with(overlaps), "{}", run.stdout);
}

/// Without its meshes a robot needs a key, and there is one line about those that are missing for one reason.
#[test]
fn meshes_that_are_not_found_are_named_together() {
    let folder = folder("doctor_meshes", "revolute");
    let mesh = |i| format!("<collision><geometry><mesh filename=\"package://FOLDER/{i}.stl\"/></geometry></collision>");
    let meshes: String = (0..6).map(mesh).collect();
    let robot = ROBOT.replace("FLOAT", "revolute");
    let robot = robot.replace("<mimic joint=\"turn\" multiplier=\"-2\" offset=\"0.5\"/>", "");
    let robot = robot.replace("<link name=\"mid\">", &format!("<link name=\"mid\">{meshes}"));
    for (package, reason) in [("none", "; --package none=FOLDER"), ("parts", "")] {
        let robot = robot.replace("FOLDER", package);
        std::fs::write(folder.join("ill.urdf"), robot).expect("it is writable");
        let run = doctor(&folder, &["--package", "parts=there"]);
        for words in [
            "ill.urdf: motions can be planned with the keys below",
            "Needs a key\n  link 'mid': a collision shape of it cannot be used",
            "\n  6 not read, shapes '",
            &format!("/3.stl', 2 more: there is no such file{reason}"),
        ] {
            assert!(run.stdout.contains(words), "{words}:\n{}", run.stdout);
        }
    }
}

/// Faults of a file that leave no robot, of an SRDF, and of what is no robot.
#[test]
fn faults_of_files_are_findings_or_bad_input() {
    let folder = folder("doctor_faults", "floating");
    let heavy = ROBOT.replace("FLOAT", "revolute").replace("mass value=\"1\"", "mass value=\"-1\"");
    std::fs::write(folder.join("ill.urdf"), heavy).expect("it is writable");
    let run = doctor(&folder, &["--json"]);
    assert_eq!(run.code, Some(3));
    let diagnosis: Value = serde_json::from_str(&run.stdout).expect("it is JSON");
    assert_eq!(diagnosis["plannable"], "no");
    assert_eq!(found(&diagnosis, "link 'arm': its mass is negative")[0].0, "refused");
    // Each fault is listed, and the rest is examined.
    assert_eq!(found(&diagnosis, "its mass is negative").len(), 4);
    assert_eq!(found(&diagnosis, "it follows another joint").len(), 1);
    assert_eq!(diagnosis["mass_kg"], 0.0);

    std::fs::write(folder.join("ill.srdf"), "<robot><disable_collisions/></robot>").expect("it is writable");
    std::fs::write(folder.join("ill.urdf"), ROBOT.replace("FLOAT", "revolute")).expect("it is writable");
    let run = doctor(&folder, &["--srdf", "ill.srdf"]);
    assert_eq!(run.code, Some(0));
    assert!(run.stdout.contains("file 'ill.srdf': disable_collisions at line 1: it has no link1"), "{}", run.stdout);

    assert_bad_input(&folder, &["doctor", "panda", "--excess", "0"], "options: excess: it is 0");
    let words = "base.dae: robot: ; the root element is 'COLLADA'";
    assert_bad_input(&folder, &["doctor", "there/base.dae"], words);
    assert_bad_input(&folder, &["doctor", "ill.urdf", "--srdf", "none.srdf"], "none.srdf: ; No such file");
    assert_bad_input(&folder, &["doctor", "ill.urdf", "--package", "parts=none"], "there is no folder 'none'");
    assert_bad_input(&folder, &["doctor", "ill.urdf", "--package", "parts"], "NAME=FOLDER is needed");
}
