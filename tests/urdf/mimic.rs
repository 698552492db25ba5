//! Joints that follow others.

use aghf::urdf::{Mimic, UrdfOptions, build_model, followers, read_robot};

/// A chain of joints, each with these attributes of its `mimic` element.
fn found(mimics: &[(&str, &str)]) -> Result<Vec<(usize, usize, f64, f64)>, String> {
    let mut text = "<link name=\"base\"/>".to_owned();
    let mut parent = "base".to_owned();
    for (joint, mimic) in mimics {
        let mimic = match *mimic {
            "" => String::new(),
            attributes => format!("<mimic {attributes}/>"),
        };
        let child = format!("link_{joint}");
        text += &format!(
            r#"<link name="{child}"><inertial><mass value="1"/>
            <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
            <joint name="{joint}" type="continuous"><parent link="{parent}"/><child link="{child}"/>{mimic}</joint>"#
        );
        parent = child;
    }
    let robot = read_robot(&format!("<robot name=\"hand\">{text}</robot>"), "hand.urdf").map_err(|e| e.to_string())?;
    let options = UrdfOptions { mimic: Mimic::Independent, ..UrdfOptions::default() };
    let (model, _) = build_model(&robot, "hand.urdf", options).map_err(|e| e.to_string())?;
    let found = followers(&robot, &model, "hand.urdf").map_err(|e| e.to_string())?;
    let fields = found.iter().map(|f| (f.joint, f.master, f.multiplier, f.offset));
    Ok(fields.collect())
}

#[test]
fn followers_of_followers_follow_their_master() {
    // b = 2 a + 0.5, c = -3 b + 1 = -6 a - 0.5.
    let mimics = [
        ("a", ""),
        ("b", "joint=\"a\" multiplier=\"2\" offset=\"0.5\""),
        ("c", "joint=\"b\" multiplier=\"-3\" offset=\"1\""),
        ("d", "joint=\"a\""),
    ];
    let expected = [(1, 0, 2.0, 0.5), (2, 0, -6.0, -0.5), (3, 0, 1.0, 0.0)];
    assert_eq!(found(&mimics).expect("it is good"), expected);
}

#[test]
fn joints_that_follow_nothing_are_refused() {
    for (mimics, words) in [
        (&[("a", "joint=\"b\""), ("b", "joint=\"a\"")][..], "joint 'a': it follows joints that follow each other"),
        (&[("a", ""), ("b", "joint=\"x\"")], "joint 'b': it mimics 'x', no joint that moves"),
        (
            &[("a", ""), ("b", "joint=\"a\" offset=\"inf\"")],
            "joint 'b': it mimics 'a' with the factor 1 and the offset inf",
        ),
        (
            &[("a", ""), ("b", "joint=\"a\" multiplier=\"two\"")],
            "joint 'b': multiplier of its mimic is 'two', not a number",
        ),
    ] {
        let error = found(mimics).expect_err(words);
        assert_eq!(error, format!("hand.urdf: {words}"));
    }
}
