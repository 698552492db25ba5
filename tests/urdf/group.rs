//! Groups of joints and their states in an SRDF.

use crate::shapes::robot;
use aghf::urdf::{Srdf, parse_urdf};

/// For the robot of the shapes: `turn` carries `arm`, to which `tool` is fixed, on which `grip` carries `finger`.
const GROUPS: &str = r#"
  <virtual_joint name="floor" type="fixed" parent_frame="world" child_link="base"/>
  <group name="arm"><chain base_link="base" tip_link="tool"/><joint name="floor"/><passive_joint name="x"/></group>
  <group name="hand"><link name="finger"/><link name="tool"/></group>
  <group name="up"><chain base_link="finger" tip_link="tool"/></group>
  <group name="both"><group name="hand"/><group name="arm"/></group>
  <group name="named"><joint name="turn"/><joint name="flange"/></group>
  <group name="still"><joint name="flange"/></group>
  <group name="loop"><group name="round"/></group>
  <group name="round"><group name="loop"/></group>
  <group name="lost"><group name="nobody"/></group>
  <group name="joint"><joint name="wheel"/></group>
  <group name="link"><link name="wheel"/></group>
  <group name="chain"><chain base_link="base" tip_link="wheel"/></group>
  <group_state name="home" group="both"><joint name="turn" value="0.5"/><joint name="floor" value="0 0 0"/>
  </group_state>
  <group_state name="free"><joint name="grip" value=" -1 "/><joint name="root_joint" value="0 1"/></group_state>
  <group_state name="two" group="arm"><joint name="turn" value="1 2"/></group_state>
  <group_state name="wheels" group="arm"><joint name="wheel" value="1"/></group_state>"#;

fn parse(elements: &str) -> Result<Srdf, String> {
    let text = format!("<robot name=\"shapes\">{elements}</robot>");
    Srdf::parse(&text, "shapes.srdf", &robot()).map_err(|e| e.to_string())
}

#[test]
fn the_joints_of_a_group_are_those_of_its_members() {
    let (model, srdf) = (robot(), parse(GROUPS).expect("it is good"));
    for (group, expected) in [("arm", &[0][..]), ("hand", &[1]), ("up", &[1]), ("both", &[0, 1]), ("named", &[0])] {
        let joints = srdf.joints_of_group(group, &model, "shapes.srdf");
        assert_eq!(joints.expect(group), expected, "{group}");
    }
    for (group, words) in [
        ("still", "group 'still': it has no joint that moves"),
        ("loop", "group 'loop': it is a part of itself"),
        ("lost", "group 'nobody': there is no such group, but 'arm', 'hand'"),
        ("joint", "group 'joint': the robot has no joint 'wheel'"),
        ("link", "group 'link': the robot has no link 'wheel'; there are '"),
        ("chain", "group 'chain': the robot has no link 'wheel'"),
    ] {
        let error = srdf.joints_of_group(group, &model, "shapes.srdf");
        let error = error.expect_err(group).to_string();
        assert!(error.starts_with(&format!("shapes.srdf: {words}")), "{error}");
    }
    // Branches meet at the link where they part.
    let link = |name: &str| {
        format!(
            r#"<link name="{name}"><inertial><mass value="1"/>
            <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>"#
        )
    };
    let joint = |name: &str, parent: &str, child: &str| {
        format!(r#"<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/></joint>"#)
    };
    let text = ["base", "trunk", "left", "right"].map(link).concat()
        + &joint("a", "base", "trunk")
        + &joint("b", "trunk", "left")
        + &joint("c", "trunk", "right");
    let (model, _) = parse_urdf(&format!("<robot name=\"two\">{text}</robot>"), "two.urdf").expect("it is good");
    let group = "<group name=\"across\"><chain base_link=\"left\" tip_link=\"right\"/></group>";
    let srdf = Srdf::parse(&format!("<robot name=\"two\">{group}</robot>"), "two.srdf", &model);
    let joints = srdf.expect("it is good").joints_of_group("across", &model, "two.srdf");
    assert_eq!(joints.expect("it is good"), [1, 2]);
}

#[test]
fn states_have_positions_of_joints_that_move() {
    let (model, srdf) = (robot(), parse(GROUPS).expect("it is good"));
    let of = |name: &str| {
        let state = srdf.states.iter().find(|state| state.name == name);
        srdf.positions(state.expect(name), &model, "shapes.srdf")
    };
    assert_eq!(of("home").expect("it is good"), [(0, 0.5)]);
    assert_eq!(of("free").expect("it is good"), [(1, -1.0)]);
    for (name, words) in [
        ("two", "group_state 'two' of 'arm': joint 'turn' has 2 numbers, one is needed"),
        (
            "wheels",
            "group_state 'wheels' of 'arm': the robot has no joint 'wheel' that moves; there are 'turn', 'grip'",
        ),
    ] {
        let error = of(name).expect_err(name).to_string();
        assert_eq!(error, format!("shapes.srdf: {words}"));
    }
}

#[test]
fn elements_without_names_or_numbers_are_refused_by_line() {
    for (elements, words) in [
        ("<group/>", "group at line 1: its group has no name"),
        ("\n<group name=\"a\"><joint/></group>", "group at line 2: its joint has no name"),
        ("<group name=\"a\"><chain base_link=\"b\"/></group>", "group at line 1: its chain has no tip_link"),
        ("<group_state group=\"a\"/>", "group_state at line 1: its group_state has no name"),
        (
            "<group_state name=\"s\"><joint name=\"turn\" value=\"up\"/></group_state>",
            "group_state at line 1: value of its joint is 'up', not numbers",
        ),
    ] {
        let error = parse(elements).expect_err(elements);
        assert_eq!(error, format!("shapes.srdf: {words}"));
    }
}
