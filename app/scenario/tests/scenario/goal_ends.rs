//! Ends in goals that are sets of poses, and motions to them.

use crate::written::{load, with};
use aghf::dynamics::{forward_kinematics, frame_placement};
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf_scenario::judge::{Tolerances, Trajectory, judge};
use aghf_scenario::{Details, DirectOptions, Scenario, Solve};
use nalgebra::{Rotation3, UnitQuaternion};
use serde_json::{Value, json};

pub const TOOL: &str = "end_effector_link";
const REACHED: [f64; 7] = [1.0, 0.5, 0.3, 1.2, 0.4, 0.7, -0.5];

fn pose(model: &Model, frame: &str, q: &[f64]) -> Placement<f64> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements).expect("its joints");
    let mut frames = model.frames().iter();
    let frame = frames.find(|known| known.name == frame).expect("a link");
    frame_placement(frame, &placements).expect("its frame")
}

/// The keys of the pose of a frame at a configuration of Kinova.
pub fn pose_at(q: &[f64]) -> Value {
    let model = aghf::urdf::builtin_robot("kinova_gen3").expect("built in");
    let at = pose(&model, TOOL, q);
    let turn = UnitQuaternion::from(Rotation3::from_matrix_unchecked(at.rotation));
    json!({ "frame": TOOL, "position_m": at.translation.as_slice(), "orientation_xyzw": turn.coords.as_slice() })
}

pub fn kinova(goal: Value) -> Value {
    json!({
        "robot": "kinova_gen3", "horizon_s": 2.0,
        "q_start": [0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0], "v_start": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "goal": goal,
    })
}

fn ends(scenario: &Scenario) -> Vec<Vec<f64>> {
    let goal = scenario.goal_with_ends().expect("it is reachable").expect("a set");
    goal.ends.into_iter().map(|end| end.q).collect()
}

fn refusal(scenario: &Value) -> String {
    let scenario = load("refused", scenario).expect("it is good");
    scenario.goal_with_ends().expect_err("it is refused").to_string()
}

/// The ends of a scenario that was changed are those of the changed one.
#[test]
fn ends_follow_the_keys() {
    let mut scenario = load("ends", &kinova(pose_at(&REACHED))).expect("it is good");
    let before = ends(&scenario);
    assert_eq!(ends(&scenario), before);
    scenario.file.q_start = REACHED.to_vec();
    let nearest = ends(&scenario).into_iter().map(|q| q.iter().zip(REACHED).map(|(a, b)| (a - b).abs()).sum::<f64>());
    assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-6, "the start is among them");
    scenario.file.q_start = vec![0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0];
    assert_eq!(ends(&scenario), before);
}

/// Every end has the pose, is within the limits and differs from the others.
#[test]
fn ends_have_the_pose() {
    let scenario = load("ends", &kinova(pose_at(&REACHED))).expect("it is good");
    let (ends, wanted) = (ends(&scenario), pose(&scenario.model, TOOL, &REACHED));
    assert!(ends.len() > 3, "{}", ends.len());
    for (i, q) in ends.iter().enumerate() {
        let at = pose(&scenario.model, TOOL, q);
        assert!((at.translation - wanted.translation).norm() < 1e-8);
        assert!((at.rotation - wanted.rotation).norm() < 1e-8);
        for (q, joint) in q.iter().zip(scenario.model.joints()) {
            assert!((joint.limits().lower..=joint.limits().upper).contains(q));
        }
        for other in &ends[..i] {
            let apart = q.iter().zip(other).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) >= 0.2);
        }
    }
}

/// A solve ends in the pose, at hardly more than the cost of a motion to the configuration from which the pose was
/// made, and the judge agrees.
#[test]
fn a_motion_ends_in_the_pose_at_least_cost() {
    let scenario = load("pose", &kinova(pose_at(&REACHED))).expect("it is good");
    let joints = json!({ "goal": [], "q_goal": REACHED, "v_goal": vec![0.0; 7] });
    let joints = load("joints", &with(kinova(json!([])), joints)).expect("it is good");
    let [by_pose, by_joints] = [&scenario, &joints].map(|of| Solve::new(of).run().expect("it is good"));
    let Details::Direct(details) = &by_pose.summary.details else {
        panic!("by the direct method");
    };
    let end = details.end.as_ref().expect("a set");
    assert!(by_pose.summary.success && by_joints.summary.success);
    assert_eq!(end.goal, 0);
    let (at, wanted) = (pose(&scenario.model, TOOL, &end.q), pose(&scenario.model, TOOL, &REACHED));
    assert!((at.translation - wanted.translation).norm() < 1e-6);
    assert!((at.rotation - wanted.rotation).norm() < 1e-6);
    let Details::Direct(of_joints) = &by_joints.summary.details else {
        panic!("by the direct method");
    };
    assert!(details.cost < 1.02 * of_joints.cost, "{} {}", details.cost, of_joints.cost);
    let samples = aghf::motion::sample(&scenario.model, &by_pose.curve, 200).expect("its joints");
    let trajectory = Trajectory::of_samples(samples);
    let judged = judge(&scenario, &trajectory, Tolerances::default()).expect("its joints");
    assert!(judged.valid, "{:?}", judged.checks);
}

/// Of two sets the motion ends in the one that the summary names.
#[test]
fn a_motion_ends_in_one_of_two_sets() {
    let near = pose_at(&[0.1, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0]);
    let scenario = load("two", &kinova(json!([pose_at(&REACHED), near]))).expect("it is good");
    let report = Solve::new(&scenario).run().expect("it is good");
    let Details::Direct(details) = &report.summary.details else {
        panic!("by the direct method");
    };
    let end = details.end.as_ref().expect("a set");
    let at = pose(&scenario.model, TOOL, &end.q).translation;
    let wanted = scenario.file.goal[end.goal].position_m.expect("a position");
    assert!((at - nalgebra::Vector3::from(wanted)).norm() < 1e-6);
    assert!(report.summary.success);
}

#[test]
fn goals_that_no_configuration_reaches_are_refused_with_the_reason() {
    let far = json!({ "frame": TOOL, "position_m": [2.0, 0.0, 0.3] });
    let words = "goal: its position is ";
    let refused = refusal(&kinova(far.clone()));
    assert!(refused.contains(words) && refused.contains("add up to"), "{refused}");
    assert!(!refused.contains("millimetres"), "{refused}");
    let unit = json!({ "frame": TOOL, "position_m": [400.0, 0.0, 300.0] });
    let refused = refusal(&kinova(unit));
    assert!(refused.ends_with("; lengths are in metres, are these millimetres?"), "{refused}");
    // Below a floor.
    let floor = json!({
        "obstacles": [{ "name": "floor", "shape": { "half_space": {} }, "pose": { "position_m": [0, 0, 0] } }],
        "robot_shape": { "swept_links": { "radius_m": 0.02 } } });
    let below = json!({ "frame": TOOL, "position_m": [0.4, 0.0, -0.2] });
    let refused = refusal(&with(kinova(below), floor));
    assert!(refused.contains("is refused, the first because"), "{refused}");
    assert!(refused.contains("'floor'"), "{refused}");
    // Within the sum of the links, but folded beyond the limits of the elbow.
    let inside = json!({ "frame": TOOL, "position_m": [0.0, 0.0, 0.28], "orientation_xyzw": [1.0, 0.0, 0.0, 0.0] });
    let refused = refusal(&kinova(inside));
    assert!(refused.contains("does not prove that there is none; the nearest one is off by"), "{refused}");
    // Of several goals one is enough.
    let two = load("two", &kinova(json!([far, pose_at(&REACHED)]))).expect("it is good");
    let goal = two.goal_with_ends().expect("one is reachable").expect("a set");
    assert!(goal.ends.iter().all(|end| end.alternative == 1));
}

#[test]
fn a_horizon_that_is_fixed_and_too_short_is_named() {
    let short = kinova(pose_at(&REACHED));
    let words = "; the horizon is fixed: a horizon_s of more than 0.1 s or free_horizon may help";
    for (keys, advised) in [
        (json!({ "horizon_s": 0.1 }), true),
        (json!({ "horizon_s": 0.1, "free_horizon": { "shortest_s": 0.05, "longest_s": 0.1 } }), false),
    ] {
        let scenario = load("short", &with(short.clone(), keys)).expect("it is good");
        let options = DirectOptions { starts: Some(1), ..DirectOptions::default() };
        let report = Solve::new(&scenario).options(options).run();
        let failure = report.expect("it is good").summary.failure;
        let failure = failure.expect("it is too short");
        assert_eq!(failure.ends_with(words), advised, "{failure}");
    }
}
