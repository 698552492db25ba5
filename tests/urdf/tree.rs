//! The order of the joints.

use aghf::model::{Joint, Model};
use aghf::urdf::{builtin_robots, load_robot, parse_urdf};
use std::path::Path;

/// The text of a robot in `robots/`.
fn urdf(name: &str) -> String {
    let file = format!("robots/{name}/{name}.urdf");
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).expect("it exists")
}

/// The links and joints of such a text, each of which starts on a line of its own.
fn elements(text: &str) -> (String, Vec<String>) {
    let mut parts = vec![String::new()];
    for line in text.lines().filter(|line| *line != "</robot>") {
        if line.starts_with("  <link ") || line.starts_with("  <joint ") {
            parts.push(String::new());
        }
        let last = parts.last_mut().expect("there is one");
        *last += &format!("{line}\n");
    }
    (parts.remove(0), parts)
}

fn joint_names(model: &Model) -> Vec<&str> {
    model.joints().iter().map(Joint::name).collect()
}

#[test]
fn joints_are_numbered_depth_first_by_name_whatever_the_order_of_the_file() {
    for name in builtin_robots() {
        let (head, mut parts) = elements(&urdf(name));
        assert!(parts.len() >= 3, "{name}: {} elements", parts.len());
        let (expected, notes) = load_robot(name).expect("built in");
        for turn in 0..4 {
            match turn {
                0 => parts.reverse(),
                1 => parts.sort(),
                // A step that shares no factor with the number of elements visits all.
                _ => {
                    let (count, step) = (parts.len(), if parts.len() % 7 == 0 { 5 } else { 7 });
                    parts = (0..count).map(|i| parts[(i * step + turn) % count].clone()).collect();
                    parts.dedup();
                    assert_eq!(parts.len(), count, "{name}: {step} skips some");
                }
            }
            let text = format!("{head}{}</robot>", parts.concat());
            let (model, report) = parse_urdf(&text, name).expect("it is as good");
            assert_eq!(format!("{model:?}"), format!("{expected:?}"), "{name}");
            assert_eq!(report, notes, "{name}");
        }
    }
}

/// The children of one link, in the order of their joints' names and not of their own or of the file.
#[test]
fn siblings_are_in_alphabetical_order_of_joint_names() {
    let body = r#"<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"#;
    let links = ["base", "a", "b", "c", "d"].map(|l| format!(r#"<link name="{l}">{body}</link>"#));
    let joint = |name: &str, parent: &str, child: &str| {
        let ends = format!(r#"<parent link="{parent}"/><child link="{child}"/>"#);
        format!(r#"<joint name="{name}" type="continuous">{ends}</joint>"#)
    };
    let joints =
        [joint("j_9", "base", "a"), joint("j_10", "base", "b"), joint("J_11", "base", "c"), joint("a_0", "b", "d")];
    let text = format!(r#"<robot name="tree">{}{}</robot>"#, links.concat(), joints.concat());
    let (model, _) = parse_urdf(&text, "tree.urdf").expect("it is good");
    assert_eq!(joint_names(&model), ["J_11", "j_10", "a_0", "j_9"]);
    let parents: Vec<_> = model.joints().iter().map(Joint::parent).collect();
    assert_eq!(parents, [None, None, Some(1), None]);
    let links: Vec<_> = model.frames().iter().map(|f| f.name.as_str()).collect();
    assert_eq!(links, ["base", "c", "b", "d", "a"]);
}
