//! `aghf ik` finds configurations for a pose.

use crate::command::{aghf, assert_bad_input, empty_folder, parsed};
use aghf::dynamics::{forward_kinematics, frame_placement};
use aghf::spatial::Placement;
use aghf::urdf::builtin_robot;

#[test]
fn configurations_reach_the_pose_the_nearest_first() {
    let folder = empty_folder("ik");
    let near = "0.3,-0.2,0.1,-1.5,0.2,1.4,-0.3";
    let asked = ["ik", "panda", "--frame", "panda_hand", "--position", "0.4,-0.1,0.5", "--orientation", "-1,0,0,0"];
    let found = parsed(&aghf(&folder, &[&asked[..], &["--near", near, "--json"]].concat()));
    let found: Vec<Vec<f64>> = serde_json::from_value(found).expect("configurations");
    assert!(found.len() > 1);
    let model = builtin_robot("panda").expect("built in");
    let mut frames = model.frames().iter();
    let hand = frames.find(|frame| frame.name == "panda_hand").expect("a link");
    let near: Vec<f64> = near.split(',').map(|q| q.parse().expect("a number")).collect();
    let mut last = 0.0;
    for q in &found {
        let mut placements = vec![Placement::identity(); 7];
        forward_kinematics(&model, q, &mut placements).expect("its joints");
        let at = frame_placement(hand, &placements).expect("its frame");
        assert!((at.translation - nalgebra::Vector3::new(0.4, -0.1, 0.5)).norm() < 1e-8);
        assert!((at.rotation[(0, 0)] - 1.0).abs() + (at.rotation[(2, 2)] + 1.0).abs() < 1e-8);
        let apart: f64 = q.iter().zip(&near).map(|(a, b)| (a - b).powi(2)).sum();
        assert!(apart >= last);
        last = apart;
    }
    let table = aghf(&folder, &asked);
    assert_eq!(table.code, Some(0));
    assert!(table.stdout.contains("panda_joint7"), "{}", table.stdout);
}

#[test]
fn a_pose_out_of_reach_has_its_exit_code_and_reason() {
    let folder = empty_folder("ik_far");
    let run = aghf(&folder, &["ik", "panda", "--frame", "panda_hand", "--position", "1.4,0,0.5"]);
    assert_eq!(run.code, Some(3));
    assert!(run.stderr.contains("the links to frame 'panda_hand' add up to"), "{}", run.stderr);
    let asked = |frame, position| ["ik", "panda", "--frame", frame, "--position", position];
    for (position, words) in [("1,2", "3 numbers are needed, there are 2"), ("1,2,x", "invalid float")] {
        assert_bad_input(&folder, &asked("panda_hand", position), words);
    }
    let words = "aghf: options: goal.frame: the robot has no link 'hand' that moves; the nearest of ";
    assert_bad_input(&folder, &asked("hand", "0,0,0"), words);
}
