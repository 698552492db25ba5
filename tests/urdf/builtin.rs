//! The robots that are built in.

use crate::common::robot;
use aghf::model::{Joint, Limits, Model};
use aghf::urdf::{LoadNote, load_robot};

fn joint_names(model: &Model) -> Vec<&str> {
    model.joints().iter().map(Joint::name).collect()
}

#[test]
fn kinova_has_seven_joints_in_a_row() {
    let (model, report) = load_robot("kinova_gen3").expect("built in");
    let names = ["joint_1", "joint_2", "joint_3", "joint_4", "joint_5", "joint_6", "joint_7"];
    assert_eq!(joint_names(&model), names);
    let parents: Vec<_> = model.joints().iter().map(Joint::parent).collect();
    assert_eq!(parents, [None, Some(0), Some(1), Some(2), Some(3), Some(4), Some(5)]);
    // 1.3773 + 1.1636 + 1.1636 + 0.9302 + 0.6781 + 0.6781 + 0.5; the base of 1.697 does not move.
    assert!((model.mass() - 6.4909).abs() < 1e-12, "{}", model.mass());
    let link = "end_effector_link".to_owned();
    let merged =
        LoadNote::Merged { link: link.clone(), joint: "end_effector".to_owned(), into: Some("joint_7".to_owned()) };
    // Each joint has damping of 7.4 to 10.5 N m s and friction of 0.1 to 0.6 N m in the file.
    let lost = |note: &&LoadNote| matches!(note, LoadNote::LeftOut { .. });
    assert_eq!(report.iter().filter(lost).count(), 14);
    let others: Vec<_> = report.iter().filter(|note| !lost(note)).collect();
    assert_eq!(others, [&LoadNote::Massless { link }, &merged]);
    let second = Limits { lower: -2.25, upper: 2.25, velocity: 1.3963, effort: 39.0 };
    assert_eq!(*model.joints()[1].limits(), second);
}

#[test]
fn digit_has_22_joints_in_the_order_of_its_scenarios() {
    let model = robot("digit_v3_pinned");
    // Up the left leg, down the left arm, then the right leg and the right arm; each with the joint that carries it.
    let expected = [
        ("left_toe_roll", None),
        ("left_toe_pitch", Some(0)),
        ("left_tarsus", Some(1)),
        ("left_knee", Some(2)),
        ("left_hip_pitch", Some(3)),
        ("left_hip_yaw", Some(4)),
        ("left_hip_roll", Some(5)),
        ("left_shoulder_roll", Some(6)),
        ("left_shoulder_pitch", Some(7)),
        ("left_shoulder_yaw", Some(8)),
        ("left_elbow", Some(9)),
        ("right_hip_roll", Some(6)),
        ("right_hip_yaw", Some(11)),
        ("right_hip_pitch", Some(12)),
        ("right_knee", Some(13)),
        ("right_tarsus", Some(14)),
        ("right_toe_pitch", Some(15)),
        ("right_toe_roll", Some(16)),
        ("right_shoulder_roll", Some(6)),
        ("right_shoulder_pitch", Some(18)),
        ("right_shoulder_yaw", Some(19)),
        ("right_elbow", Some(20)),
    ];
    let found: Vec<_> = model.joints().iter().map(|j| (j.name(), j.parent())).collect();
    assert_eq!(found, expected);
    // The torso of 15.028392, two legs and arms of 15.590741 each (0.915088 + 0.818753 + 6.244279 + 1.227077 + 0.895793
    // + 1.322865 + 0.043881 + 0.531283 + 0.535396 + 1.440357 + 1.065387 + 0.550582), less the pinned left toe.
    assert!((model.mass() - 45.678591).abs() < 1e-12, "{}", model.mass());
}
