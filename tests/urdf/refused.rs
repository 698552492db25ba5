//! Bad URDFs and SRDFs: each is refused by an error that names the file and the element.

use crate::shapes::{ROBOT, robot};
use crate::srdf::SRDF;
use aghf::Result;
use aghf::error::Error;
use aghf::urdf::{Srdf, load_urdf, parse_urdf};
use std::collections::BTreeMap;
use std::path::Path;

/// A good robot to break: `base`, turned by `shoulder`, then `upper`, then pushed by `slide`, then `lower`.
const ARM: &str = r#"<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/>
      <mass value="2"/>
      <inertia ixx="0.31" ixy="0.01" ixz="0.02" iyy="0.32" iyz="0.03" izz="0.33"/>
    </inertial>
  </link>
  <link name="lower">
    <inertial>
      <mass value="1"/>
      <inertia ixx="0.11" ixy="0" ixz="0" iyy="0.12" iyz="0" izz="0.13"/>
    </inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <origin xyz="0.7 0.8 0.9" rpy="1.1 1.2 1.3"/>
    <parent link="base"/>
    <child link="upper"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="2.5" velocity="3.5" effort="4.5"/>
  </joint>
  <joint name="slide" type="prismatic">
    <origin xyz="0 0 0.5"/>
    <parent link="upper"/>
    <child link="lower"/>
    <axis xyz="1 0 0"/>
    <limit lower="-0.1" upper="0.2" velocity="0.3" effort="0.4"/>
  </joint>
</robot>"#;

/// By the good text that is changed: a part that it has once, what stands there instead, the element of the error, and
/// words of its condition, once per kind of message.
const CASES: &str = include_str!("refused.json");

/// The fault of a refusal that should name this place in these words, if it has one.
fn problem<T>(result: Result<T>, place: &str, words: &str) -> Option<String> {
    let error = result.err().map_or("accepted".to_owned(), |e| e.to_string());
    let good = error.starts_with(&format!("{place}: ")) && error.contains(words);
    (!good).then(|| format!("{error}; want {place}: {words}"))
}

fn assert_refused<T>(result: Result<T>, place: &str, words: &str) {
    assert_eq!(problem(result, place, words), None);
}

#[test]
fn each_is_refused_by_file_and_element() {
    let cases: BTreeMap<String, Vec<Vec<String>>> = serde_json::from_str(CASES).expect("lists");
    assert_eq!(cases.len(), 3);
    let (model, mut problems) = (robot(), Vec::new());
    for (name, cases) in cases {
        let read = |text: &str| match name.as_str() {
            "arm" | "shapes" => parse_urdf(text, &name).map(|_| ()),
            _ => Srdf::parse(text, &name, &model).map(|_| ()),
        };
        let good = match name.as_str() {
            "arm" => ARM,
            "shapes" => ROBOT,
            _ => SRDF,
        };
        // Either quotes are XML; these need no escape in the list.
        let good = good.replace('"', "'");
        read(&good).expect("it is good");
        for case in cases {
            let (change, place) = (&case[0], format!("{name}: {}", case[2]));
            assert_eq!(good.matches(change).count(), 1, "'{change}' in {name}");
            let words = case.get(3).map_or("", String::as_str);
            problems.extend(problem(read(&good.replace(change, &case[1])), &place, words));
        }
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

#[test]
fn what_is_no_robot_is_refused() {
    let fixed = ARM.replace("revolute", "fixed").replace("prismatic", "fixed");
    for (text, words) in [
        ("", "not a valid URDF"),
        (&ARM[..900], "not a valid URDF"),
        (&ARM.replace("robot", "sdf"), "sdf"),
        ("<robot name='arm'>\n<link name='base'>\n\n", "ends at line 2"),
        ("<robot name='arm'></robot>", "no links"),
        ("<robot name='arm'><link name='base'/></robot>", "no moving joint"),
        (&fixed, "no moving joint"),
    ] {
        assert_refused(parse_urdf(text, "arm.urdf"), "arm.urdf: robot", words);
    }
}

const NO_INERTIA: &str = r#"<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>"#;

/// A robot with one joint about or along (1, 2, 2), which moves a point mass at `xyz`.
fn point_mass(kind: &str, xyz: &str, mass: &str) -> String {
    let origin = format!(r#"<origin xyz="{xyz}"/><mass value="{mass}"/>"#);
    let load = format!("<inertial>{origin}{NO_INERTIA}</inertial>");
    format!(
        r#"<robot name="one"><link name="base"/><link name="load">{load}</link>
        <joint name="move" type="{kind}"><parent link="base"/><child link="load"/>
        <axis xyz="1 2 2"/></joint></robot>"#
    )
}

#[test]
fn joints_that_move_nothing() {
    let words = "mass matrix is singular";
    let refused = |text: &str| assert_refused(parse_urdf(text, "one.urdf"), "one.urdf: joint 'move'", words);
    refused(&point_mass("continuous", "1 0 0", "0"));
    refused(&point_mass("prismatic", "1 0 0", "0"));
    // On the axis; beside it is no problem, nor is sliding.
    refused(&point_mass("continuous", "-0.5 -1 -1", "3"));
    refused(&point_mass("revolute", "0.1 0.2 0.2", "3"));
    for good in [point_mass("continuous", "-0.5 -1 1", "3"), point_mass("prismatic", "-0.5 -1 -1", "3")] {
        parse_urdf(&good, "good").expect("there is something to move");
    }
    // A rotor turns, and does not push.
    let rotor = point_mass("prismatic", "0 0 0", "0").replace("ixx=\"0\"", "ixx=\"1\"");
    refused(&rotor);
}

/// Two axes in one place and direction: each has inertia about it, but only their sum can be told.
#[test]
fn coinciding_axes() {
    let between = r#"<link name="between"/><joint name="zz" type="continuous">
        <parent link="between"/><child link="load"/></joint>"#;
    let text = point_mass("continuous", "1 0 0", "1");
    let text = text.replace(r#"child link="load""#, r#"child link="between""#);
    let text = text.replace("</robot>", &format!("{between}</robot>"));
    let mut text = text.replace("1 2 2", "1 0 0");
    for moment in ["ixx", "iyy", "izz"] {
        text = text.replace(&format!("{moment}=\"0\""), &format!("{moment}=\"1\""));
    }
    let error = parse_urdf(&text, "one.urdf").expect_err("it is singular").to_string();
    let named = ["move", "zz"].map(|joint| error.starts_with(&format!("one.urdf: joint '{joint}': ")));
    assert!(named.contains(&true) && error.contains("singular"), "{error}");
}

#[test]
fn files_that_cannot_be_read() {
    let missing = "no_such_folder/arm.urdf";
    let error = load_urdf(Path::new(missing)).expect_err("it does not exist");
    assert!(matches!(error, Error::Io { .. }), "{error}");
    assert!(error.to_string().starts_with(missing), "{error}");
    assert!(error.to_string().contains("No such file"), "{error}");

    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("urdf_errors_bytes.urdf");
    std::fs::write(&path, [b'<', 0xff, 0xfe]).expect("the folder is writable");
    let error = load_urdf(&path).expect_err("it is no text").to_string();
    assert!(error.contains("urdf_errors_bytes.urdf: "), "{error}");
    assert!(error.contains("UTF-8"), "{error}");

    std::fs::write(&path, ARM.replace("0 1 0", "0 0 0")).expect("the folder is writable");
    let error = load_urdf(&path).expect_err("an axis is zero").to_string();
    let expected = format!("{}: joint 'shoulder': its axis is zero", path.display());
    assert_eq!(error, expected);
}
