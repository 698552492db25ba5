//! Scenarios whose robots carry a body.

use crate::written::{load, solved_once, with};
use aghf::dynamics::{Data, forward_kinematics, frame_placement, rnea};
use aghf::spatial::Placement;
use aghf_scenario::Scenario;
use nalgebra::Vector3;
use serde_json::{Value, json};

const Q: [f64; 7] = [0.3, 0.5, -0.2, 1.0, 0.4, 0.5, 0.1];

/// Kinova with its hand in sight of a floor, a payload of 2 kg in it.
fn carrying(payload: Value, keys: Value) -> Result<Scenario, String> {
    let mut all = json!({ "link": "end_effector_link", "mass_kg": 2.0 });
    all = with(all, payload);
    let scenario = json!({
        "robot": "kinova_gen3", "robot_shape": "joint_frames", "horizon_s": 2.0, "payload": all,
        "q_start": Q, "v_start": vec![0.0; 7], "q_goal": [0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0], "v_goal": vec![0.0; 7],
    });
    load("carrying", &with(scenario, keys))
}

/// The torques at rest.
fn at_rest(scenario: &Scenario) -> Vec<f64> {
    let (model, mut tau) = (&scenario.model, vec![0.0; 7]);
    rnea(model, &mut Data::new(model), &Q, &[0.0; 7], &[0.0; 7], &mut tau).expect("lengths agree");
    tau
}

/// The potential energy of the payload, whose derivatives are its torques at rest.
fn energy(scenario: &Scenario, q: &[f64]) -> f64 {
    let mut bodies = vec![Placement::identity(); 7];
    forward_kinematics(&scenario.model, q, &mut bodies).expect("lengths agree");
    let mut frames = scenario.model.frames().iter();
    let frame = frames.find(|f| f.name == "end_effector_link").expect("it has one");
    let hand = frame_placement(frame, &bodies).expect("it has a body");
    let centre = hand.rotation * Vector3::new(0.0, 0.05, 0.1) + hand.translation;
    2.0 * 9.81 * centre.z
}

#[test]
fn its_weight_is_that_of_a_mass_at_its_centre() {
    let centre = json!({ "center_m": [0.0, 0.05, 0.1] });
    let loaded = carrying(centre, json!({})).expect("it is good");
    let free = carrying(json!({}), json!({ "payload": null })).expect("it is good");
    let torques = at_rest(&loaded).into_iter().zip(at_rest(&free));
    for (i, (with, without)) in torques.enumerate() {
        let moved = |step: f64| {
            let mut q = Q;
            q[i] += step;
            energy(&free, &q)
        };
        let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
        assert!((with - without - slope).abs() < 1e-7, "{i}: {with} {without} {slope}");
    }
    assert!((loaded.model.mass() - free.model.mass() - 2.0).abs() < 1e-12);
    // Its inertia about its centre is felt by the last joint as it turns.
    let inertia = json!({ "inertia_kg_m2": [0.02, 0.0, 0.0, 0.02, 0.0, 0.03] });
    let heavy = carrying(inertia, json!({})).expect("it is good");
    let point = carrying(json!({}), json!({})).expect("it is good");
    let last = |scenario: &Scenario| scenario.model.inertias()[6].rotational;
    let more = last(&heavy) - last(&point);
    let mut moments: Vec<f64> = more.symmetric_eigenvalues().iter().copied().collect();
    moments.sort_by(f64::total_cmp);
    assert_close!(&moments, &[0.02, 0.02, 0.03], 1e-12);
}

/// Whatever the shape of the robot, the payload is in the way: a ball of 0.1 m comes that much nearer to a wall.
#[test]
fn its_shape_is_one_of_the_robot() {
    let wall = json!([{ "shape": { "half_space": {} }, "pose": { "position_m": [0, 0, -2] } }]);
    let ball = json!({ "shape": { "sphere": { "radius_m": 0.1 } }, "center_m": [0.0, 0.0, 0.3] });
    for shape in [json!("joint_frames"), json!({ "swept_links": { "radius_m": 0.01 } })] {
        let keys = json!({ "obstacles": wall, "robot_shape": shape });
        let loaded = carrying(ball.clone(), keys.clone()).expect("it is good");
        let free = carrying(json!({}), keys).expect("it is good");
        let balls = |scenario: &Scenario| scenario.scene.robot().balls.clone();
        assert_eq!(balls(&loaded).len(), balls(&free).len() + 1);
        let last = *balls(&loaded).last().expect("the payload");
        assert_eq!((last.body, last.radius), (Some(6), 0.1));
    }
    let box_ = json!({
        "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } },
        "shape_pose": { "position_m": [0.0, 0.0, 0.2], "orientation_xyzw": [0.0, 0.0, 0.6, 0.8] },
    });
    let locked = json!({ "robot_shape": { "swept_links": { "radius_m": 0.01 } }, "obstacles": wall });
    assert!(carrying(box_, locked).is_ok());
}

/// A motion with a payload is found, judged by the same torques, and keeps it clear.
#[test]
fn motions_carry_it() {
    let effort = |mass: f64| {
        let keys = json!({ "enforced_limits": { "velocity": false, "torque": false } });
        let scenario = carrying(json!({ "mass_kg": mass }), keys).expect("it is good");
        let report = solved_once(&scenario);
        assert_eq!(report.summary.provenance.scenario.payload, scenario.file.payload);
        report.summary.control_effort
    };
    assert!(effort(3.0) > 1.5 * effort(0.1));
}

#[test]
fn payloads_that_cannot_be_are_refused_by_key() {
    let pose = json!({ "position_m": [0.0, 0.0, 0.2] });
    for (payload, words) in [
        (json!({ "link": "hand" }), "payload.link: the robot has no link 'hand' that moves"),
        (json!({ "link": "base_link" }), "payload.link: the robot has no link 'base_link' that moves"),
        (json!({ "mass_kg": 0.0 }), "payload.mass_kg: it is 0 and must be a positive number"),
        (json!({ "center_m": [0.0, 0.0, 1e7] }), "payload.center_m: a number is not finite, or above"),
        (json!({ "inertia_kg_m2": [1.0, 0.0, 0.0, 1.0, 0.0, 5.0] }), "payload.inertia_kg_m2: its largest"),
        (json!({ "shape": { "half_space": {} } }), "payload.shape: a payload cannot be a half-space"),
        (json!({ "shape": { "sphere": { "radius_m": 0.0 } } }), "payload.shape: radius_m has 0"),
        (json!({ "shape_pose": pose }), "payload.shape_pose: there is no shape"),
    ] {
        let error = carrying(payload, json!({})).expect_err(words);
        assert!(error.contains(words), "'{error}' does not say '{words}'");
    }
}
