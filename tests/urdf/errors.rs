//! Invalid URDFs: each is refused by an error that names the file, the element and the fault.

use aghf::error::Error;
use aghf::urdf::{load_urdf, parse_urdf};
use std::path::Path;

/// A valid robot for modification: `base`, rotated by `shoulder`, then `upper`, then moved by `slide`, then `lower`.
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

/// [`ARM`] with the only occurrence of `what` replaced.
fn arm_with(what: &str, replacement: &str) -> String {
    assert_eq!(ARM.matches(what).count(), 1, "'{what}' in the good robot");
    ARM.replace(what, replacement)
}

/// The discrepancy if `text` is not refused as `element` with all `words` (separated by semicolons) in the condition.
fn not_refused(text: &str, element: &str, words: &str) -> Option<String> {
    let wanted = format!("want {element}: {words}");
    let error = match parse_urdf(text, "folder/arm.urdf") {
        Ok((_, report)) => return Some(format!("accepted with {report:?}; {wanted}")),
        Err(error) => error,
    };
    let text = error.to_string();
    let Error::Input {
        file,
        element: found,
        condition,
    } = error
    else {
        return Some(format!("another kind of error: {text}; {wanted}"));
    };
    let good = file == "folder/arm.urdf"
        && found == element
        && words.split("; ").all(|word| condition.contains(word))
        && text == format!("folder/arm.urdf: {element}: {condition}");
    (!good).then(|| format!("{text}; {wanted}"))
}

/// Asserts that `text` is refused as `element`, with all `words` in the condition.
fn assert_text_refused(text: &str, element: &str, words: &str) {
    if let Some(problem) = not_refused(text, element, words) {
        panic!("{problem}");
    }
}

/// Asserts that changes to [`ARM`] are refused. A change is `what => replacement | element | words`.
fn assert_refused<T: AsRef<str>>(changes: impl IntoIterator<Item = T>) {
    let mut problems = Vec::new();
    for change in changes {
        let parts: Vec<&str> = change.as_ref().split(" | ").collect();
        let [edit, element, words] = parts[..] else {
            panic!("'{}' has three parts", change.as_ref());
        };
        let (what, replacement) = edit.split_once(" => ").expect("it says what to replace");
        let problem = not_refused(&arm_with(what, replacement), element, words);
        problems.extend(problem.map(|p| format!("{what} -> {replacement}: {p}")));
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

#[test]
fn the_robot_to_break_is_good() {
    let (model, report) = parse_urdf(ARM, "arm.urdf").expect("it is good");
    assert_eq!((model.name(), model.dof()), ("arm", 2));
    assert_eq!(report.len(), 1, "only the base is massless: {report:?}");
}

#[test]
fn text_that_is_no_xml() {
    for text in ["", "no XML at all", "<robot name=\"arm\">", &ARM[..900]] {
        assert_text_refused(text, "robot", "not a valid URDF");
    }
    let early = "<robot name='arm'>\n<link name='base'>\n\n";
    assert_text_refused(early, "robot", "never closed; ends at line 2");
    let nameless = ARM.replace("<joint name=\"slide\"", "<joint");
    assert_text_refused(&nameless, "robot", "the joint at line 24 has no name");
}

#[test]
fn a_wrong_root_element() {
    let text = ARM.replace("robot", "sdf");
    assert_text_refused(&text, "robot", "not a valid URDF; sdf");
}

#[test]
fn empty_robots_and_robots_without_moving_joints() {
    assert_text_refused(r#"<robot name="arm"></robot>"#, "robot", "no links");
    let one_link = r#"<robot name="arm"><link name="base"/></robot>"#;
    assert_text_refused(one_link, "robot", "no moving joint");
    let fixed = ARM.replace("revolute", "fixed");
    let fixed = fixed.replace("prismatic", "fixed");
    assert_text_refused(&fixed, "robot", "no moving joint");
}

#[test]
fn negative_masses() {
    assert_refused([
        r#"mass value="2" => mass value="-2.5" | link 'upper' | mass; negative; -2.5"#,
    ]);
}

#[test]
fn numbers_that_are_not_finite() {
    for bad in ["NaN", "inf", "-inf", "1e999"] {
        let changes = [
            r#"mass value="2" => mass value="BAD" | link 'upper' | mass; finite"#,
            r#"ixx="0.31" => ixx="BAD" | link 'upper' | inertia; finite"#,
            r#"ixy="0.01" => ixy="BAD" | link 'upper' | inertia; finite"#,
            r#"iyz="0.03" => iyz="BAD" | link 'upper' | inertia; finite"#,
            r#"izz="0.33" => izz="BAD" | link 'upper' | inertia; finite"#,
            "0.1 0.2 0.3 => 0.1 BAD 0.3 | link 'upper' | origin; finite",
            "0.4 0.5 0.6 => BAD 0.5 0.6 | link 'upper' | origin; finite",
            "0.7 0.8 0.9 => BAD 0.8 0.9 | joint 'shoulder' | origin; finite",
            "1.1 1.2 1.3 => 1.1 1.2 BAD | joint 'shoulder' | origin; finite",
            "0 1 0 => 0 1 BAD | joint 'shoulder' | axis; finite",
        ];
        assert_refused(changes.map(|change| change.replace("BAD", bad)));
    }
}

#[test]
fn limits_that_are_not_numbers_or_in_the_wrong_order() {
    assert_refused([
        r#"lower="-1.5" => lower="NaN" | joint 'shoulder' | limit; not a number"#,
        r#"upper="2.5" => upper="NaN" | joint 'shoulder' | limit; not a number"#,
        r#"velocity="3.5" => velocity="NaN" | joint 'shoulder' | limit; not a number"#,
        r#"effort="4.5" => effort="NaN" | joint 'shoulder' | limit; not a number"#,
        r#"lower="-1.5" => lower="2.75" | joint 'shoulder' | lower limit 2.75; above; upper limit 2.5"#,
        r#"lower="-1.5" => lower="inf" | joint 'shoulder' | limit"#,
        r#"upper="2.5" => upper="-inf" | joint 'shoulder' | limit"#,
    ]);
}

/// No position is above `+inf` or below `-inf`, and no speed or force is below a negative one.
#[test]
fn limits_that_nothing_can_keep() {
    assert_refused([
        r#"lower="-1.5" upper="2.5" => lower="inf" upper="inf" | joint 'shoulder' | limit"#,
        r#"lower="-1.5" upper="2.5" => lower="-inf" upper="-inf" | joint 'shoulder' | limit"#,
        r#"velocity="3.5" => velocity="-3.5" | joint 'shoulder' | velocity; negative"#,
        r#"effort="4.5" => effort="-4.5" | joint 'shoulder' | effort; negative"#,
    ]);
}

#[test]
fn zero_axes() {
    assert_refused(["0 1 0 => 0 0 -0 | joint 'shoulder' | axis is zero"]);
}

/// The message must lead to the place of the fault, which is the element.
#[test]
fn malformed_numbers() {
    assert_refused([
        r#"mass value="2" => mass value="heavy" | link 'upper' | mass"#,
        r#"ixx="0.31" => ixx="" | link 'upper' | ixx"#,
        "0.1 0.2 0.3 => 0.1 0.2 | link 'upper' | 0.1 0.2",
        "0.7 0.8 0.9 => 0.7 0.8 0.9 1.0 | joint 'shoulder' | 0.7 0.8 0.9 1.0",
        r#"lower="-1.5" => lower="low" | joint 'shoulder' | lower"#,
        r#"rpy="1.1 1.2 1.3" => quat_xyzw="0 0 0 1" | joint 'shoulder' | quat_xyzw; not supported"#,
    ]);
}

/// A word among three numbers must not be skipped.
#[test]
fn words_among_the_numbers_of_a_vector() {
    assert_refused([
        "0.7 0.8 0.9 => 0.7 zero 0.8 0.9 | joint 'shoulder' | zero",
        "0.1 0.2 0.3 => 0,1 0 0 0 | link 'upper' | 0,1",
        "0 1 0 => 0 1 0 rad | joint 'shoulder' | rad",
    ]);
}

#[test]
fn missing_attributes_and_unknown_joint_types() {
    assert_refused([
        r#"<mass value="2"/> =>  | link 'upper' | mass"#,
        r#"<parent link="base"/> =>  | joint 'shoulder' | parent"#,
        r#"velocity="3.5" =>  | joint 'shoulder' | velocity"#,
        "revolute => hinge | joint 'shoulder' | hinge",
    ]);
}

#[test]
fn repeated_names() {
    assert_refused([
        r#"<link name="base"/> => <link name="base"/><link name="base"/> | link 'base' | occurs twice"#,
        r#"joint name="slide" => joint name="shoulder" | joint 'shoulder' | occurs twice"#,
    ]);
}

#[test]
fn unknown_links() {
    assert_refused([
        r#"parent link="base" => parent link="bse" | joint 'shoulder' | no link 'bse'"#,
        r#"child link="lower" => child link="lwer" | joint 'slide' | no link 'lwer'"#,
    ]);
}

#[test]
fn several_roots() {
    assert_refused([
        r#"<link name="base"/> => <link name="base"/><link name="island"/> | robot | several root links; base; island"#,
    ]);
}

/// A joint for addition to a robot.
fn joint(name: &str, parent: &str, child: &str) -> String {
    let ends = format!(r#"<parent link="{parent}"/><child link="{child}"/>"#);
    format!(r#"<joint name="{name}" type="continuous">{ends}</joint>"#)
}

#[test]
fn loops() {
    let add = |joints: &str, refusal: &str| format!("</robot> => {joints}</robot> | {refusal}");
    let cycle = joint("xy", "x", "y") + &joint("yx", "y", "x");
    let beside = format!(r#"<link name="x"/><link name="y"/>{cycle}"#);
    assert_refused([
        add(
            &joint("back", "lower", "base"),
            "robot | no root link; loop",
        ),
        add(&joint("self", "base", "base"), "robot | no root link; loop"),
        add(
            &joint("second", "base", "lower"),
            "joint 'second' | 'lower'; second joint; loop",
        ),
        add(&beside, "link 'x' | cannot be reached from the root; loop"),
    ]);
}

#[test]
fn joints_that_are_not_supported() {
    let mimic = r#"<mimic joint="shoulder" multiplier="2"/><axis xyz="1 0 0"/>"#;
    let mimic = format!(r#"<axis xyz="1 0 0"/> => {mimic} | joint 'slide' | mimic; not supported"#);
    assert_refused([
        "revolute => floating | joint 'shoulder' | floating; not supported; base is fixed",
        "revolute => planar | joint 'shoulder' | planar; not supported; one axis",
        "revolute => spherical | joint 'shoulder' | spherical; not supported; one axis",
        &mimic,
    ]);
}

/// Finite numbers with non-finite results.
#[test]
fn numbers_that_overflow() {
    let far = arm_with("0.1 0.2 0.3", "1e200 0.2 0.3");
    assert_text_refused(&far, "link 'upper'", "finite");
}

const NO_INERTIA: &str = r#"<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>"#;

/// A robot with one joint about or along (1, 2, 2) and a point mass at `xyz`.
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
    let words = "inertia about it; mass matrix is singular";
    let refused = |text: &str| assert_text_refused(text, "joint 'move'", words);
    refused(&point_mass("continuous", "1 0 0", "0"));
    refused(&point_mass("prismatic", "1 0 0", "0"));
    // On the axis; off the axis, and for sliding, the same mass is accepted.
    refused(&point_mass("continuous", "-0.5 -1 -1", "3"));
    refused(&point_mass("revolute", "0.1 0.2 0.2", "3"));
    for good in [
        point_mass("continuous", "-0.5 -1 1", "3"),
        point_mass("prismatic", "-0.5 -1 -1", "3"),
    ] {
        parse_urdf(&good, "good").expect("there is something to move");
    }
    // Rotational inertia does not resist translation.
    let rotor = point_mass("prismatic", "0 0 0", "0").replace("ixx=\"0\"", "ixx=\"1\"");
    refused(&rotor);
}

/// A massless leaf is refused below valid joints as well, also with a fixed link on it.
#[test]
fn massless_leaves() {
    let fixed = joint("tip", "leaf", "tip").replace("continuous", "fixed");
    let leaf = r#"<link name="leaf"/><link name="tip"/>"#;
    let twist = joint("twist", "lower", "leaf");
    assert_refused([format!(
        "</robot> => {leaf}{twist}{fixed}</robot> | joint 'twist' | mass matrix is singular"
    )]);
}

/// Two joints with the same axis: each moves inertia, but only their sum is determined.
#[test]
fn coinciding_axes() {
    let between = format!(
        r#"<link name="between"/>{}"#,
        joint("zz", "between", "load")
    );
    let text = point_mass("continuous", "1 0 0", "1");
    let text = text.replace(r#"child link="load""#, r#"child link="between""#);
    let text = text.replace("</robot>", &format!("{between}</robot>"));
    let mut text = text.replace("1 2 2", "1 0 0");
    for moment in ["ixx", "iyy", "izz"] {
        text = text.replace(&format!("{moment}=\"0\""), &format!("{moment}=\"1\""));
    }
    let [first, second] =
        ["joint 'move'", "joint 'zz'"].map(|joint| not_refused(&text, joint, "singular"));
    assert!(first.is_none() || second.is_none(), "{first:?}");
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

    std::fs::write(&path, arm_with("0 1 0", "0 0 0")).expect("the folder is writable");
    let error = load_urdf(&path).expect_err("an axis is zero").to_string();
    let expected = format!("{}: joint 'shoulder': its axis is zero", path.display());
    assert_eq!(error, expected);
}
