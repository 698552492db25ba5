//! A robot that stands on a foot.

use crate::written::{load, solved_once, with};
use aghf::motion::sample;
use aghf_scenario::judge::{Check, Tolerances, Trajectory, judge};
use aghf_scenario::{Feasibility, FlowOptions, Quantity, RestOptions, Solve, SolveOptions};
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

/// A motion that would tip its plate over violates the rows of the foot, and the judge sees it with its own arithmetic.
#[test]
fn a_motion_that_tips_a_plate_over_is_not_valid() {
    let free = load("free", &arm()).expect("it is good");
    let small = json!({ "half_length_m": 0.02, "half_width_m": 9.0, "friction": 9.0, "torsion": 9.0 });
    let standing = load("standing", &with(arm(), plate(small))).expect("it is good");
    let curve = solved_once(&free).curve;
    let [none, found] = [&free, &standing].map(|of| Feasibility::of(of, &curve).expect("its joints"));
    assert!(none.foot.is_none() && none.holds(1e-6));
    let load = found.foot.as_ref().expect("it stands");
    let farthest = load.along_m.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert!(farthest > 0.05, "{load:?}");
    let reason = found.reason(1e-6).expect("it tips over");
    assert!(reason.contains(" edge of foot 'base_link' by "), "{reason}");
    let motion = sample(&free.model, &curve, 400).expect("its joints");
    let judged = judge(&standing, &Trajectory::of_samples(motion), Tolerances::default());
    let checks = judged.expect("its joints").checks;
    let failed = checks.iter().filter(|row| !row.outcome.is_good());
    let failed: Vec<_> = failed.collect();
    assert_eq!(failed.iter().map(|row| row.check).collect::<Vec<_>>(), [Check::Bounds(Quantity::Foot)]);
    let worst = failed[0].worst.as_ref().expect("it was checked").value.abs();
    assert!((worst - farthest).abs() < 0.05 * farthest, "{worst} {farthest}");
}

#[test]
fn a_foot_needs_a_link_of_the_base_a_size_and_a_weight_above_it() {
    let refused = |keys: Value| {
        let scenario = with(arm(), plate(keys));
        load("refused", &scenario).expect_err("it is refused")
    };
    for (keys, words) in [
        (json!({ "frame": "sole" }), "stand.frame: the robot has no link 'sole'"),
        (json!({ "frame": "end_effector_link" }), "stand.frame: link 'end_effector_link' moves"),
        (json!({ "friction": 0.0 }), "stand.friction: it is 0 and must be a positive number"),
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
    let leaning = json!({ "continuity": "acceleration", "q_start": [0.0, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0] });
    let leaning = load("leaning", &with(with(arm(), leaning), plate(json!({}))));
    let error = leaning.expect("it is good").check_feasible();
    let error = error.expect_err("it falls").to_string();
    assert!(error.contains("q_start: the weight at rest is (") && error.contains("continuity"), "{error}");
    let flow = load("flow", &with(arm(), plate(json!({})))).expect("it is good");
    let error = Solve::new(&flow).options(SolveOptions::Rest(RestOptions::default())).run();
    let error = error.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(error.contains("stand: supported by the method 'direct' only, not by 'rest'"), "{error}");
}

/// The published flow keeps the centre of pressure nearer to a small plate than without one, by penalties.
#[test]
fn the_published_flow_has_penalties_for_a_foot() {
    let small = json!({ "half_length_m": 0.04, "half_width_m": 0.3, "friction": 9.0, "torsion": 9.0 });
    let standing = load("standing", &with(arm(), plate(small))).expect("it is good");
    let farthest = |k_cons: f64| {
        let options = FlowOptions {
            degree: Some(9),
            k: Some(1e4),
            s_max: Some(10.0),
            k_cons: Some(k_cons),
            c_cons: Some(100.0),
            ..FlowOptions::default()
        };
        let found = Solve::new(&standing).options(options).run().expect("it is good");
        let load = found.summary.feasibility.foot.expect("it stands");
        load.along_m.into_iter().map(f64::abs).fold(0.0, f64::max)
    };
    let [without, with] = [1e-6, 1e5].map(farthest);
    assert!(without > 0.2 && with < 0.85 * without, "{without} and {with}");
}
