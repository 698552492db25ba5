//! Another link as the root.

use crate::common::assert_refused;
use aghf::dynamics::{Data, forward_kinematics, frame_placement, rnea};
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf::urdf::{UrdfOptions, build_model, builtin_robot_text, read_robot, reroot};
use urdf_rs::{Link, Robot};

fn digit() -> Robot {
    let text = builtin_robot_text("digit_v3_pinned").expect("it is built in");
    read_robot(text, "digit").expect("it is good")
}

fn model(robot: &Robot) -> Model {
    Model::try_from(robot).expect("it is good")
}

/// The positions of the joints of `of`, which depend on their names alone.
fn state(of: &Model, factor: f64) -> Vec<f64> {
    let letters = |name: &str| name.bytes().map(f64::from).sum::<f64>();
    let joints = of.joints().iter();
    joints.map(|joint| 0.5 * (factor * letters(joint.name())).sin()).collect()
}

/// The place of each link in the one called `reference`.
fn places(of: &Model, reference: &str) -> Vec<(String, Placement<f64>)> {
    let mut bodies = vec![Placement::identity(); of.dof()];
    forward_kinematics(of, &state(of, 1.0), &mut bodies).expect("its joints");
    let all = of.frames().iter().map(|frame| {
        let placement = frame_placement(frame, &bodies).expect("its body");
        (frame.name.clone(), placement)
    });
    let all: Vec<_> = all.collect();
    let (_, of_reference) = all.iter().find(|(name, _)| name == reference).expect("a link");
    let back = of_reference.rotation.transpose();
    let relative =
        |p: &Placement<f64>| Placement::new(back * p.rotation, back * (p.translation - of_reference.translation));
    all.iter().map(|(name, p)| (name.clone(), relative(p))).collect()
}

/// Torques by the names of the joints.
fn torques(of: &Model) -> Vec<(String, f64)> {
    let [q, v, a] = [1.0, 2.0, 3.0].map(|factor| state(of, factor));
    let mut tau = vec![0.0; of.dof()];
    rnea(of, &mut Data::new(of), &q, &v, &a, &mut tau).expect("its joints");
    let names = of.joints().iter().map(|joint| joint.name().to_owned());
    let mut all: Vec<_> = names.zip(tau).collect();
    all.sort_by(|(a, _), (b, _)| a.cmp(b));
    all
}

#[test]
fn links_are_where_they_were_and_the_way_back_is_the_same_robot() {
    let left = digit();
    let right = reroot(&left, "right_toe_roll", "digit").expect("a link");
    let [on_left, on_right] = [&left, &right].map(model);
    assert_eq!(on_right.dof(), 22);
    let foot = on_right.frames().iter().find(|frame| frame.name == "right_toe_roll");
    assert_eq!(foot.expect("a link").body, None);
    let is_new = |link: &&Link| left.links.iter().all(|known| known.name != link.name);
    let mut new = right.links.iter().filter(is_new).peekable();
    assert!(new.peek().is_some());
    assert!(new.all(|link| right.joints.iter().all(|joint| joint.name != link.name)));
    let mass = |of: &Model| of.mass() + of.base_inertia().mass;
    assert!((mass(&on_left) - mass(&on_right)).abs() < 1e-12);
    let there = places(&on_right, "torso");
    for (name, place) in places(&on_left, "torso") {
        let (_, same) = there.iter().find(|(other, _)| *other == name).expect("a link");
        assert_close!(&place.rotation, &same.rotation, 1e-12);
        assert_close!(&place.translation, &same.translation, 1e-12);
    }
    for joint in on_left.joints() {
        let mut joints = on_right.joints().iter();
        let same = joints.find(|other| other.name() == joint.name()).expect("a joint");
        assert_eq!(joint.limits(), same.limits());
    }
    let back = model(&reroot(&right, "left_toe_roll", "digit").expect("a link"));
    for ((name, torque), (other, same)) in torques(&on_left).into_iter().zip(torques(&back)) {
        assert_eq!(name, other);
        assert!((torque - same).abs() < 1e-10, "{name}: {torque} {same}");
    }
}

#[test]
fn the_root_is_an_option_of_reading() {
    let options = |root: &str| UrdfOptions { root: Some(root.to_owned()), ..UrdfOptions::default() };
    let (read, _) = build_model(&digit(), "digit", options("torso")).expect("a link");
    let torso = read.frames().iter().find(|frame| frame.name == "torso");
    assert_eq!(torso.expect("a link").body, None);
    let unknown = build_model(&digit(), "digit", options("tail"));
    assert_refused(unknown, "digit: root 'tail': the robot has no such link");
}
