//! A robot that stands on a foot.

use crate::written::{load, solved_once, with};
use aghf::motion::sample;
use aghf_scenario::judge::{Check, Tolerances, Trajectory, judge};
use aghf_scenario::{FlowOptions, Scenario, Solve};
use serde_json::{Value, json};

/// An arm that is not screwed to the ground but stands on a plate.
fn arm() -> Value {
    json!({
        "robot": "kinova_gen3", "horizon_s": 1.0, "continuity": "velocity",
        "q_start": [0.0, 0.1, 0.0, 0.2, 0.0, 0.1, 0.0], "v_start": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "q_goal": [0.0, -0.2, 0.0, -0.3, 0.0, -0.1, 0.0], "v_goal": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "robot_shape": "joint_frames",
        "enforced_limits": { "position": false, "velocity": false, "torque": false },
    })
}

fn plate(keys: Value) -> Value {
    let plate = json!({ "frame": "base_link", "half_length_m": 0.15, "half_width_m": 0.1, "friction": 0.4,
        "torsion": 0.05 });
    json!({ "stand": with(plate, keys) })
}

fn samples(scenario: &Scenario) -> (Trajectory, aghf_scenario::Feasibility) {
    let report = solved_once(scenario);
    let samples = sample(&scenario.model, &report.curve, 400).expect("its joints");
    (Trajectory::of_samples(samples), report.summary.feasibility)
}

/// A motion that would tip a plate over has a standing foot, and another one does not.
#[test]
fn an_arm_does_not_tip_its_plate_over() {
    let free = load("free", &arm()).expect("it is good");
    let standing = load("standing", &with(arm(), plate(json!({})))).expect("it is good");
    let [(loose, none), (kept, found)] = [&free, &standing].map(samples);
    assert_eq!(none.foot, None);
    let load = found.foot.expect("it stands");
    let judged = |motion| judge(&standing, motion, Tolerances::default()).expect("its joints");
    let row = |motion: &Trajectory| {
        let checks = judged(motion).checks;
        let row = checks.into_iter().find(|row| row.check == Check::Foot);
        row.expect("it stands")
    };
    assert!(judged(&kept).valid && !judged(&loose).valid);
    assert!(!row(&loose).outcome.is_good());
    // The plate is used up to its edge, and the judge sees the same with its own arithmetic.
    let within = |x: f64, most: f64| x.abs() < most + 1e-6;
    assert!(load.along_m.iter().all(|x| within(*x, 0.15)), "{load:?}");
    assert!(load.along_m.iter().any(|x| x.abs() > 0.149), "{load:?}");
    assert!(load.across_m.iter().all(|x| within(*x, 0.1)), "{load:?}");
    assert!(load.friction < 0.4 + 1e-6 && load.torsion < 0.05 + 1e-6);
    let worst = row(&kept).worst.expect("it was checked");
    assert!(worst.value.abs() < 0.4 + 1e-4, "{worst:?}");
}

#[test]
fn a_foot_needs_a_link_of_the_base_a_size_and_a_weight_above_it() {
    let refused = |keys: Value| {
        let scenario = with(arm(), plate(keys));
        load("refused", &scenario).expect_err("it is refused")
    };
    for (keys, words) in [
        (
            json!({ "frame": "sole" }),
            "stand.frame: the robot has no link 'sole'",
        ),
        (
            json!({ "frame": "end_effector_link" }),
            "stand.frame: link 'end_effector_link' moves",
        ),
        (
            json!({ "friction": 0.0 }),
            "stand.friction: it is 0, a positive number is needed",
        ),
        (json!({ "torsion": -1.0 }), "stand.torsion: it is -1"),
        (
            json!({ "sole": { "position_m": [0, 0, 0], "orientation_xyzw": [0, 0, 0, 2] } }),
            "stand.sole: the orientation",
        ),
    ] {
        let error = refused(keys);
        assert!(error.contains(words), "{error}");
    }
    // A motion that begins at rest without an acceleration needs the weight above the plate.
    let leaning =
        json!({ "continuity": "acceleration", "q_start": [0.0, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0] });
    let leaning = load("leaning", &with(with(arm(), leaning), plate(json!({}))));
    let error = leaning.expect("it is good").check_feasible();
    let error = error.expect_err("it falls").to_string();
    assert!(
        error.contains("q_start: the weight at rest is (") && error.contains("continuity"),
        "{error}"
    );
    let flow = load("flow", &with(arm(), plate(json!({})))).expect("it is good");
    let error = Solve::new(&flow).options(FlowOptions::default()).run();
    let error = error.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(
        error.contains("stand: the method 'flow' does not know it"),
        "{error}"
    );
}
