//! Damping, friction and rotor inertia of a robot that is read.

use crate::common::assert_refused;
use aghf::Result;
use aghf::model::{Drive, Model};
use aghf::urdf::{
    FRICTION_VELOCITY, LoadNote, Losses, PerJoint, UrdfOptions, builtin_robot, load_robot_with, parse_urdf_with,
};
use std::path::Path;

/// An arm of two joints, the second of which moves nothing that has inertia.
const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="tip"/>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
    <dynamics damping="0.5" friction="2"/></joint>
  <joint name="wrist" type="continuous"><parent link="upper"/><child link="tip"/>
    <axis xyz="0 1 0"/><dynamics damping="much"/></joint>
</robot>"#;

fn named(name: &str, number: f64) -> PerJoint {
    PerJoint::Named([(name.to_owned(), number)].into())
}

fn read(losses: Losses) -> Result<(Model, Vec<LoadNote>)> {
    let options = UrdfOptions { losses: Some(losses), ..UrdfOptions::default() };
    parse_urdf_with(ARM, "arm.urdf", options)
}

#[test]
fn what_is_given_is_in_place_of_what_is_written() {
    let losses = Losses { damping: named("wrist", 0.25), armature: named("wrist", 0.01), ..Losses::default() };
    let (model, notes) = read(losses).expect("the tip has rotor inertia");
    let shoulder = Drive { damping: 0.5, friction: 2.0, friction_velocity: FRICTION_VELOCITY, armature: 0.0 };
    let wrist = Drive { damping: 0.25, friction: 0.0, armature: 0.01, ..shoulder };
    assert_eq!(model.drives(), [shoulder, wrist]);
    let lost = |note: &LoadNote| matches!(note, LoadNote::LeftOut { .. });
    assert!(!notes.iter().any(lost), "{notes:?}");

    let same = Losses {
        damping: PerJoint::Same(1.0),
        friction: PerJoint::Same(3.0),
        friction_velocity: PerJoint::Same(0.1),
        armature: PerJoint::Same(0.02),
    };
    let (model, _) = read(same).expect("both have rotor inertia");
    let all = Drive { damping: 1.0, friction: 3.0, friction_velocity: 0.1, armature: 0.02 };
    assert_eq!(model.drives(), [all; 2]);
}

#[test]
fn losses_of_a_built_in_robot_are_those_of_its_file_and_count_only_if_asked_for() {
    let options = UrdfOptions { losses: Some(Losses::default()), ..UrdfOptions::default() };
    let (arm, notes) = load_robot_with("kinova_gen3", Path::new(""), options).expect("built in");
    assert!(notes.is_empty() || !notes.iter().any(|note| note.to_string().contains("counted")));
    assert_refused(arm.to_urdf(), "the drives of its joints cannot be said in a URDF");
    let dampings: Vec<_> = arm.drives().iter().map(|drive| drive.damping).collect();
    assert_eq!(dampings[..2], [10.5, 7.406484581723072]);
    assert!(arm.drives().iter().all(|drive| drive.friction > 0.1 && drive.armature == 0.0));
    assert!(builtin_robot("kinova_gen3").expect("built in").drives().is_empty());
}

#[test]
fn numbers_that_cannot_be_are_refused_by_name() {
    for (losses, words) in [
        (Losses::default(), "joint 'wrist': its damping is NaN, a number that is not negative is needed"),
        (Losses { damping: PerJoint::Same(-1.0), ..Losses::default() }, "joint 'shoulder': its damping is -1"),
        (
            Losses { damping: PerJoint::Same(0.0), friction_velocity: named("shoulder", 0.0), ..Losses::default() },
            "joint 'shoulder': its friction_velocity is 0, a positive number is needed",
        ),
        (
            Losses { armature: named("elbow", 1.0), ..Losses::default() },
            "losses.armature.elbow: the robot has no such joint that moves; there are 'shoulder'",
        ),
        (
            Losses { damping: PerJoint::Same(0.0), ..Losses::default() },
            "joint 'wrist': nothing that it moves has inertia about it",
        ),
    ] {
        assert_refused(read(losses), words);
    }
}
