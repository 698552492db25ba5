//! Models of robots in the types of `urdf-rs`.

use aghf::model::{Limits, Model};
use aghf::urdf::{LoadNote, Mimic, UrdfOptions, build_model, builtin_robots, load_robot};
use aghf::urdf_rs::{self, Geometry, JointType, Robot, Vec3};
use std::path::Path;

/// A robot in `robots/` as `urdf-rs` reads it.
fn robot(name: &str) -> Robot {
    let file = format!("robots/{name}/{name}.urdf");
    urdf_rs::read_file(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).expect("it is good")
}

/// The readers of `urdf-rs` and of this library agree on the same text.
#[test]
fn robots_that_urdf_rs_reads_are_those_of_their_text() {
    for name in builtin_robots() {
        let (expected, notes) = load_robot(name).expect("built in");
        let robot = robot(name);
        let model = Model::try_from(&robot).expect(name);
        assert_eq!(format!("{model:?}"), format!("{expected:?}"), "{name}");
        let (_, same) = build_model(&robot, name, UrdfOptions::default()).expect(name);
        assert_eq!(same, notes, "{name}");
    }
}

#[test]
fn bad_robots_are_refused_by_name_and_element() {
    let refused = |change: fn(&mut Robot), words: &str| {
        let mut robot = robot("panda");
        robot.name = "changed".to_owned();
        change(&mut robot);
        let error = Model::try_from(&robot).expect_err(words).to_string();
        assert!(error.starts_with(&format!("changed: {words}")), "{error}");
    };
    refused(|r| r.links.clear(), "joint 'panda_joint1': there is no link");
    refused(|r| r.links[1].inertial.mass.value = -2.5, "link 'panda_link1': its mass is negative: -2.5");
    refused(
        |r| r.joints[0].axis.xyz = Vec3([0.0, f64::NAN, 0.0]),
        "joint 'panda_joint1': its axis is not a finite number",
    );
    refused(
        |r| {
            let collision = urdf_rs::Collision { geometry: Geometry::Sphere { radius: -1.0 }, ..Default::default() };
            r.links[2].collision = vec![collision];
        },
        "link 'panda_link2': collision 1: radius of its sphere has -1",
    );
    refused(|r| r.joints[1].joint_type = JointType::Planar, "joint 'panda_joint2': planar joints are not supported");
}

/// Version 1.2 of the format has infinite default limits.
#[test]
fn infinite_limits_are_none() {
    let mut robot = robot("panda");
    let limit = &mut robot.joints[0].limit;
    (limit.lower, limit.upper) = (f64::NEG_INFINITY, f64::INFINITY);
    (limit.velocity, limit.effort) = (f64::INFINITY, f64::INFINITY);
    let model = Model::try_from(&robot).expect("it is good");
    assert_eq!(*model.joints()[0].limits(), Limits::NONE);
}

#[test]
fn mimic_joints_are_as_the_options_say_and_of_no_matter_if_fixed() {
    let mut robot = robot("panda");
    let mimic = urdf_rs::Mimic { joint: "panda_joint2".to_owned(), ..urdf_rs::Mimic::default() };
    robot.joints[0].mimic = Some(mimic.clone());
    let error = Model::try_from(&robot).expect_err("it mimics").to_string();
    assert!(error.contains("joint 'panda_joint1': it mimics"), "{error}");
    let options = UrdfOptions { mimic: Mimic::Independent, ..UrdfOptions::default() };
    let (_, notes) = build_model(&robot, "panda", options).expect("as asked for");
    let note = LoadNote::Independent { joint: "panda_joint1".to_owned(), mimics: "panda_joint2".to_owned() };
    assert!(notes.contains(&note), "{notes:?}");

    robot.joints[0].joint_type = JointType::Fixed;
    let model = Model::try_from(&robot).expect("a fixed joint follows no other");
    assert_eq!(model.joints()[0].name(), "panda_joint2");
}
