//! XML that other readers of URDFs accept: prefixes without a declaration, and a declaration that is not first.

use crate::elements::massless;
use aghf::urdf::LoadNote::{self, BeforeDeclaration, NoExtent, PointMass, SeveralAxes, UndeclaredPrefix};
use aghf::urdf::{Elements, Srdf, parse_urdf, read_visuals};
use std::collections::BTreeMap;

/// A robot with a visual, a collision shape and an inertia, into which further text is put.
fn robot(attribute: &str, in_link: &str, in_joint: &str) -> String {
    format!(
        r#"<robot name="arm"{attribute}>
<link name="base"/>
<link name="upper"><inertial><origin xyz="0 0 0.2"/><mass value="1"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial>
<visual><geometry><sphere radius="0.2"/></geometry></visual>{in_link}</link>
<joint name="lift" type="revolute"><parent link="base"/><child link="upper"/>{in_joint}<axis xyz="0 1 0"/>
<limit lower="-1" upper="1" velocity="2" effort="3"/></joint>
</robot>"#
    )
}

fn model(text: &str) -> (String, Vec<LoadNote>) {
    let (model, notes) = parse_urdf(text, "arm.urdf").unwrap_or_else(|e| panic!("{e}\n{text}"));
    (format!("{model:?}"), notes)
}

fn undeclared(prefix: &str) -> LoadNote {
    UndeclaredPrefix { prefix: prefix.to_owned() }
}

#[test]
fn what_has_a_prefix_is_left_out() {
    let (plain, _) = model(&robot("", "", ""));
    let in_link = r#"<drake:proximity_properties><drake:mu value="0.9"/></drake:proximity_properties>
        <drake:collision><geometry/></drake:collision><gz:visual/>"#;
    let in_joint = r#"<drake:axis xyz="1 0 0"/><drake:limit effort="none"/>"#;
    let text = robot(r#" drake:version="2""#, in_link, in_joint);
    let (same, notes) = model(&text);
    assert_eq!(same, plain);
    assert_eq!(notes, [undeclared("drake"), undeclared("gz"), massless("base")]);
    let words = "prefix 'drake': not declared; elements and attributes with it are left out";
    assert_eq!(notes[0].to_string(), words);
    // A declared prefix is no other one, and a default namespace has none.
    let declared = r#" xmlns:drake="http://drake.mit.edu" xmlns:gz="gz" xmlns="http://www.ros.org""#;
    let (same, notes) = model(&robot(declared, in_link, in_joint));
    assert_eq!((same, notes), (plain, vec![massless("base")]));

    let (visuals, faults) = read_visuals(&text, &BTreeMap::new());
    assert_eq!((visuals.len(), faults), (1, Vec::new()));
    let (model, _) = parse_urdf(&text, "arm.urdf").expect("it is read");
    let srdf = r#"<robot name="arm"><disable_collisions link1="base" link2="upper"/><x:disable_collisions/></robot>"#;
    let srdf = Srdf::parse(srdf, "arm.srdf", &model).expect("it is read");
    assert_eq!(srdf.disabled.len(), 1);
}

#[test]
fn faults_keep_their_lines() {
    let in_link = "<drake:a/>\n<drake:b/>";
    for (from, to, words) in [
        ("joint name=\"lift\"", "joint", "the joint at line 7 has no name"),
        ("<axis", "<axis\" ", "at 7:"),
        ("</robot>", "", "the text ends at line 8"),
    ] {
        let text = robot("", in_link, "").replacen(from, to, 1);
        let error = parse_urdf(&text, "arm.urdf").expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    }
    let macros = robot("", "<xacro:box size=\"1\"/>", "");
    let error = parse_urdf(&macros, "arm.urdf").expect_err("it is a macro");
    assert!(error.to_string().contains("'xacro:box' is not expanded"));
    let many: String = (0..100).map(|i| format!("<p{i}:a/>")).collect();
    let error = parse_urdf(&robot("", &many, ""), "arm.urdf").expect_err("too many");
    assert!(error.to_string().contains("unknown namespace prefix 'p64'"), "{error}");
}

#[test]
fn a_declaration_may_be_after_blank_lines_and_comments() {
    let (plain, _) = model(&robot("", "", ""));
    let declaration = "<?xml version=\"1.0\"?>\n";
    for before in ["\n\n", " ", "<!-- <?xml ?> of a tool -->\n"] {
        let text = format!("{before}{declaration}{}", robot("", "<drake:a/>", ""));
        let (same, notes) = model(&text);
        assert_eq!(same, plain);
        assert_eq!(notes, [BeforeDeclaration, undeclared("drake"), massless("base")], "{before}");
        assert!(!notes[0].bears_on_motion());
    }
    let (same, notes) = model(&format!("{declaration}{}", robot("", "", "")));
    assert_eq!((same, notes), (plain, vec![massless("base")]));
    let nameless = robot("", "", "").replace("joint name=\"lift\"", "joint");
    let error = parse_urdf(&format!("\n\n{declaration}{nameless}"), "arm.urdf");
    let error = error.expect_err("the joint has no name").to_string();
    assert!(error.contains("the joint at line 9 has no name"), "{error}");
    for text in [
        robot("", declaration, ""),
        format!("{declaration}{declaration}{}", robot("", "", "")),
        format!("robot\n{declaration}{}", robot("", "", "")),
    ] {
        let error = parse_urdf(&text, "arm.urdf").expect_err("it is no XML");
        assert!(error.to_string().contains("not a valid URDF"), "{error}");
    }
}

#[test]
fn what_is_doubled_or_missing_is_completed_with_a_note() {
    let (plain, _) = model(&robot("", "", ""));
    let second = robot("", "", "").replace("<limit", "<axis xyz=\"0 0 1\"/><limit");
    let axes = SeveralAxes { joint: "lift".to_owned() };
    assert_eq!(model(&second), (plain.clone(), vec![axes, massless("base")]));

    let inertia = r#"<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/>"#;
    let zeros = r#"<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>"#;
    let (point, _) = model(&robot("", "", "").replace(inertia, zeros));
    let mass = PointMass { link: "upper".to_owned() };
    let (same, notes) = model(&robot("", "", "").replace(inertia, ""));
    assert_eq!((same, notes), (point, vec![mass, massless("base")]));

    for shape in [
        r#"<sphere radius="0"/>"#,
        r#"<cylinder radius="0" length="1"/>"#,
        r#"<capsule radius="0.0" length="1"/>"#,
        r#"<box size="0 0 0"/>"#,
    ] {
        let collision = format!("<collision><geometry>{shape}</geometry></collision>");
        let left_out = NoExtent { link: "upper".to_owned(), shape: "collision 1".to_owned() };
        let words = "link 'upper': collision 1 has the radius 0, or no extent, and is left out";
        assert_eq!(left_out.to_string(), words);
        let expected = (plain.clone(), vec![massless("base"), left_out]);
        assert_eq!(model(&robot("", &collision, "")), expected, "{shape}");
    }
    let scale = r#"<collision><geometry><mesh filename="a.stl" scale="1 1 1 1"/></geometry></collision>"#;
    let error = parse_urdf(&robot("", scale, ""), "arm.urdf").expect_err("four numbers");
    let words = "link 'upper': collision 1: scale of its mesh is '1 1 1 1', not 3 numbers";
    assert_eq!(error.to_string(), format!("arm.urdf: {words}"));
}

/// Past a fault the rest is read.
#[test]
fn all_faults_of_elements_are_found() {
    let text = robot("", "<collision/>", "").replace("velocity=\"2\"", "");
    let read = Elements::read(&text, "arm.urdf").expect("it is XML");
    let faults: Vec<_> = read.faults.iter().map(ToString::to_string).collect();
    let expected = [
        "arm.urdf: link 'upper': collision 1: it has no geometry element",
        "arm.urdf: joint 'lift': its limit has no velocity",
    ];
    assert_eq!(faults, expected);
    assert_eq!((read.robot.links.len(), read.robot.joints.len()), (2, 1));
    let error = parse_urdf(&text, "arm.urdf").expect_err("it has faults");
    assert_eq!(error.to_string(), expected[0]);
}
