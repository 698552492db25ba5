//! Findings of `aghf doctor` about numbers in other units, inertias, and parts that the reader completed or left out.

use crate::command::{aghf, empty_folder, parsed};
use crate::doctor::found;
use serde_json::Value;

/// The findings about the text of a robot.
fn diagnosis(test: &str, text: &str) -> Value {
    let folder = empty_folder(test);
    std::fs::write(folder.join("arm.urdf"), text).expect("a file");
    parsed(&aghf(&folder, &["doctor", "arm.urdf", "--json"]))
}

/// An arm with this inertial element and this shape of its link.
fn arm(inertial: &str, shape: &str) -> String {
    format!(
        r#"<robot name="arm"><link name="base"/><link name="upper"><inertial>{inertial}</inertial>{shape}</link>
        <joint name="lift" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.3"/>
        <axis xyz="0 1 0"/><limit lower="-3" upper="3" velocity="2" effort="60"/></joint></robot>"#
    )
}

fn inertia(mass: f64, moment: f64) -> String {
    let moments = format!(r#"ixx="{moment}" iyy="{moment}" izz="{moment}" ixy="0" ixz="0" iyz="0""#);
    format!(r#"<mass value="{mass}"/><inertia {moments}/>"#)
}

/// A link of 1 kg and 0.4 m: its inertia in other units, and its centre of mass in millimetres.
#[test]
fn inertias_beyond_the_extent_of_a_link_are_asked_about() {
    let shape = r#"<collision><geometry><box size="0.1 0.1 0.4"/></geometry></collision>"#;
    let origin = |xyz: &str, rpy: &str| format!(r#"<origin xyz="{xyz}" rpy="{rpy}"/>"#);
    let (gyration, centre, angle) = ("radius of gyration", "centre of mass is", "beyond a turn");
    for (inertial, shape, words) in [
        (inertia(1.0, 0.02), shape, None),
        (inertia(1.0, 0.02), "", None),
        // The link is twice as long as its shape.
        (inertia(1.0, 0.1), shape, None),
        (inertia(1.0, 0.02) + &origin("0 0 0.4", "0 0 6.2832"), shape, None),
        (inertia(1.0, 2e4), shape, Some(gyration)),
        (inertia(1.0, 20.0), shape, Some(gyration)),
        (inertia(1.0, 20.0), "", Some(gyration)),
        (inertia(0.1, 1.0), shape, Some(gyration)),
        (inertia(1.0, 0.02) + &origin("0 0 100", "0 0 0"), shape, Some(centre)),
        (inertia(1.0, 0.02) + &origin("0 0 100", "0 0 0"), "", Some(centre)),
        (inertia(1.0, 0.02) + &origin("0 0 0.1", "0 0 90"), shape, Some(angle)),
    ] {
        let diagnosis = diagnosis("doctor_inertia", &arm(&inertial, shape));
        for each in [gyration, centre, angle] {
            let names = found(&diagnosis, each).into_iter().flat_map(|(_, names)| names);
            let names: Vec<_> = names.collect();
            if words == Some(each) {
                assert!(names[0].starts_with("upper"), "{inertial}: {diagnosis}")
            } else {
                assert!(names.is_empty(), "{inertial}: {each}: {diagnosis}")
            }
        }
    }
}

#[test]
fn what_was_completed_or_left_out_is_noted() {
    let plain = arm(&inertia(1.0, 0.02), "");
    let soft = r#"<safety_controller soft_lower_limit="-0.5" soft_upper_limit="0.5"/></joint>"#;
    let point = r#"<origin xyz="0 0 0.2"/><mass value="1"/>"#;
    let none = r#"<collision><geometry><sphere radius="0"/></geometry></collision>"#;
    for (text, words, element, remedy) in [
        (plain.replace("</joint>", soft), "soft limits -0.5 to 0.5", "lift", "{\"position\": 0.166}"),
        (plain.replace("\"60\"", "\"1.7e308\""), "effort limit of", "lift", "nothing"),
        (plain.replace("</joint>", "<axis xyz=\"1 0 0\"/></joint>"), "several axes", "lift", "a single axis"),
        (arm(point, ""), "point mass", "upper", "an inertia element"),
        (arm(&inertia(1.0, 0.02), none), "radius 0", "upper", "its size in the file"),
        (arm(&inertia(1.0, 0.02), "<drake:mu/>"), "not declared", "drake", "xmlns:drake="),
        (format!("\n<?xml version=\"1.0\"?>{plain}"), "before it", "<?xml", "nothing"),
    ] {
        let diagnosis = diagnosis("doctor_notes", &text);
        assert_eq!(diagnosis["plannable"], "yes", "{diagnosis}");
        let expected = ("note".to_owned(), vec![element.to_owned()]);
        assert_eq!(found(&diagnosis, words), [expected], "{words}: {diagnosis}");
        let findings = diagnosis["findings"].as_array().expect("a list").iter();
        let remedies = findings.filter_map(|f| f["remedy"].as_str());
        assert!(remedies.into_iter().any(|r| r.contains(remedy)), "{remedy}: {diagnosis}");
    }
}

/// Numbers in degrees, millimetres and grams are asked about.
#[test]
fn units_of_another_kind_are_noted() {
    let arm = |limit: &str, x: f64, kg: f64| {
        format!(
            r#"<robot name="arm"><link name="base"/>
            <link name="upper"><inertial><mass value="{kg}"/>
            <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
            <joint name="lift" type="revolute"><parent link="base"/><child link="upper"/>
            <origin xyz="{x} 0 0"/><axis xyz="0 0 1"/><limit {limit} effort="10"/></joint></robot>"#
        )
    };
    let radians = r#"lower="-3" upper="3" velocity="2""#;
    for (text, words, expected) in [
        (arm(radians, 0.4, 3.0), "are these", None),
        (arm(r#"lower="-118" upper="120" velocity="2""#, 0.4, 3.0), "limits of position", Some("lift")),
        (arm(r#"lower="-1e9" upper="1e9" velocity="1e9""#, 0.4, 3.0), "are these", None),
        (
            arm(r#"lower="0" upper="400" velocity="2""#, 0.4, 3.0).replace("revolute", "prismatic"),
            "limits of position beyond 10 m",
            Some("lift"),
        ),
        (arm(r#"lower="-3" upper="3" velocity="180""#, 0.4, 3.0), "limit of velocity above", Some("lift")),
        (
            arm(r#"lower="0" upper="0.4" velocity="250""#, 0.4, 3.0).replace("revolute", "prismatic"),
            "velocity above 100 m/s",
            Some("lift"),
        ),
        (arm(radians, 400.0, 3.0), "from its parent: are these millimetres", Some("lift")),
        (arm(radians, 0.4, 3000.0), "grams", Some("upper")),
    ] {
        let diagnosis = diagnosis("doctor_units", &text);
        let names: Vec<_> = found(&diagnosis, words).into_iter().flat_map(|(_, names)| names).collect();
        assert_eq!(names, expected.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>(), "{words}");
    }
}
