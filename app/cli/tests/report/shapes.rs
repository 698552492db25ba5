//! The shapes of a robot, and names that are no names.

use crate::{folder, page_of, solved};
use aghf_scenario::Scenario;
use serde_json::{Value, json};
use std::path::Path;

/// A robot with a base and two links, with elements of their own.
fn robot(first: &str, second: &str, joint: &str) -> String {
    let link = |name: &str, more: &str| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0 0 0.5\"/><mass value=\"1\"/>\
             <inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{more}</link>"
        )
    };
    let joints = |name: &str, parent: &str, child: &str, z: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"0 0 {z}\"/><axis xyz=\"0 1 0\"/></joint>"
        )
    };
    format!(
        "<robot name=\"made_up\"><material name=\"red\"><color rgba=\"1 0 0 1\"/></material>\
        <link name=\"base\"/>{}{}{}{}</robot>",
        link("one", first),
        link("two", second),
        joints(joint, "base", "one", "0.2"),
        joints("j2", "one", "two", "1"),
    )
}

/// A scenario of this robot in a folder.
fn scenario(folder: &Path, urdf: &str, obstacle: &str) -> Scenario {
    std::fs::write(folder.join("robot.urdf"), urdf).expect("writable");
    let scenario = json!({
        "robot": "robot.urdf", "horizon_s": 1.0,
        "q_start": [0.0, 0.0], "v_start": [0.0, 0.0], "q_goal": [0.5, 0.3], "v_goal": [0.0, 0.0],
        "obstacles": [{ "name": obstacle, "shape": { "sphere": { "radius_m": 0.1 } },
        "pose": { "position_m": [3.0, 3.0, 3.0] } }],
    });
    let path = folder.join("move.json");
    std::fs::write(&path, scenario.to_string()).expect("writable");
    Scenario::load(&path.display().to_string()).expect("it is right")
}

fn kinds(data: &Value, body: Value) -> Vec<String> {
    let shapes = data["scene"]["shapes"].as_array().expect("a list");
    let own = shapes.iter().filter(|shape| shape["body"] == body);
    own.filter_map(|shape| shape["kind"].as_str()).map(str::to_owned).collect()
}

#[test]
fn a_link_shows_its_visuals_else_its_collision_shapes_else_capsules() {
    let folder = folder("shapes");
    let visual = "<visual><origin xyz=\"0 0 0.5\"/><geometry><box size=\"0.1 0.2 1\"/></geometry>\
        <material name=\"red\"/></visual>";
    let collision = "<collision><geometry><cylinder radius=\"0.1\" length=\"1\"/></geometry></collision>";
    let missing = "<visual><geometry><mesh filename=\"not_there.stl\"/></geometry></visual>";
    let broken = "<visual><geometry><blob/></geometry></visual>";
    let page = |first: &str, second: &str| {
        let scenario = scenario(&folder, &robot(first, second, "j1"), "ball");
        page_of(&scenario, &solved(&scenario, 1)).1
    };
    let data = page(&format!("{visual}{collision}"), &format!("{missing}{collision}"));
    assert_eq!(kinds(&data, json!(0)), ["box"]);
    assert_eq!(kinds(&data, json!(1)), ["cylinder"]);
    let red = data["scene"]["shapes"].as_array().and_then(|shapes| shapes.iter().find(|shape| shape["kind"] == "box"));
    let red = red.expect("the box is there");
    assert_eq!(red["color"], json!([1.0, 0.0, 0.0]));
    assert_eq!(red["size"], json!([0.05, 0.1, 0.5]));
    assert_eq!(red["pose"][2], 0.5);
    let notes = data["scene"]["notes"].to_string();
    assert!(notes.contains("not_there.stl"), "{notes}");
    // One note for all of them.
    let data = page(missing, missing);
    let notes = data["scene"]["notes"].to_string();
    assert_eq!(notes.matches("not_there.stl").count(), 1, "{notes}");
    assert!(notes.contains("of the links one, two;"), "{notes}");
    // A fault in what nothing but the picture needs is told there and stops nothing.
    let data = page(broken, "");
    assert!(data["scene"]["notes"].to_string().contains("blob"));
    assert_eq!(kinds(&data, json!(0)), ["sphere", "capsule"]);
    assert_eq!(kinds(&data, json!(1)), ["sphere", "capsule"]);
    assert_eq!(kinds(&data, Value::Null), ["capsule", "cylinder"]);
}

#[test]
fn a_mesh_is_shown_with_its_triangles() {
    let folder = folder("mesh");
    let corners = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    let faces = ["1 3 2", "1 2 4", "1 4 3", "2 3 4"];
    let text: String =
        corners.iter().map(|c| format!("v {c}\n")).chain(faces.iter().map(|f| format!("f {f}\n"))).collect();
    std::fs::write(folder.join("part.obj"), text).expect("writable");
    let mesh = "<visual><geometry><mesh filename=\"part.obj\" scale=\"2 2 2\"/></geometry></visual>";
    let scenario = scenario(&folder, &robot(mesh, mesh, "j1"), "ball");
    let (_, data) = page_of(&scenario, &solved(&scenario, 1));
    assert_eq!(kinds(&data, json!(1)), ["mesh"]);
    let meshes = data["scene"]["meshes"].as_array().expect("a list");
    assert_eq!(meshes.len(), 1, "one file is one mesh");
    assert_eq!(crate::bytes(&meshes[0]["triangles"]).len(), 4 * 3 * 4);
    assert_eq!(crate::bytes(&meshes[0]["corners"]).len(), 2 * 3 * 4);
    let step = meshes[0]["step"].as_f64().expect("a number");
    assert!((step * 65535.0 - 2.0).abs() < 1e-9, "{step}");
}

#[test]
fn no_name_ends_the_data() {
    let folder = folder("hostile");
    let evil = "</script><script>window.bad = 1</script><!-- <img src=x onerror=alert(1)> \"'&😀 {{TITLE}} {{DATA}}";
    let escaped = evil.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    let scenario = scenario(&folder, &robot("", "", &escaped), evil);
    let (text, data) = page_of(&scenario, &solved(&scenario, 1));
    assert_eq!(data["joints"][0]["name"], evil);
    assert!(data["scene"]["obstacles"][0]["name"].as_str().is_some_and(|name| name.contains(evil)));
    assert_eq!(text.matches("<script").count(), 2);
    assert_eq!(text.matches("</script").count(), 2);
    assert!(!text.contains("<img") && !text.contains("<!--"));
    assert_eq!(text.matches("<title>move</title>").count(), 1);
}
