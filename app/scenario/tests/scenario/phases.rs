//! The phases of a walk, as they are read.

use crate::written::{load, with};
use serde_json::{Value, json};

/// A step of Digit with its arms held, and the other foot beside it; found by `benches/walk.py`.
pub fn walk() -> Value {
    serde_json::from_str(include_str!("walk.json")).expect("it is JSON")
}

/// The first foot is the root and the foot that stands, the last landing the goal; read once more it is the same.
#[test]
fn the_first_phase_gives_the_root_and_the_last_one_the_goal() {
    let scenario = load("first", &walk()).expect("it is good");
    let file = &scenario.file;
    assert_eq!(file.root.as_deref(), Some("left_toe_roll"));
    assert_eq!(file.stand.as_ref(), Some(&file.phases[0].stand));
    assert_eq!(file.goal.len(), 1);
    assert_eq!(file.goal[0].relative_to.as_deref(), Some("right_sole"));
    let points: Vec<_> = scenario.waypoints.iter().map(|of| (of.share, of.lands)).collect();
    assert_eq!(points, [(Some(0.25), false), (Some(0.5), true), (Some(0.75), false)]);
    let written = serde_json::to_value(file).expect("it is JSON");
    let again = load("again", &written).expect("it is good");
    assert_eq!(again.file, *file);
}

/// The walk with other keys of a phase.
fn in_phase(k: usize, keys: Value) -> Value {
    let mut walk = walk();
    walk["phases"][k] = with(walk["phases"][k].clone(), keys);
    walk
}

fn assert_refused(walk: &Value, words: &str) {
    let refused = load("refused", walk).expect_err(words);
    assert!(refused.contains(words), "'{refused}' does not say '{words}'");
}

#[test]
fn keys_that_cannot_be_meant_of_a_walk_are_refused() {
    for (keys, words) in [
        (json!({ "waypoints": [{ "q": vec![0.0; 14] }] }), "waypoints: phases: a walk does not support it"),
        (json!({ "continuity": "acceleration" }), "continuity: phases: accelerations jump where the foot changes"),
        (
            json!({ "objective": { "effort": 1.0, "velocity": 1.0 } }),
            "objective: phases: a walk accepts named objectives only",
        ),
        (json!({ "mount": { "position_m": [0, 0, 1] } }), "mount: phases: a walk does not support it"),
        (json!({ "root": "right_sole" }), "root: phases: it is not the foot of the first phase"),
        (json!({ "v_goal": vec![0.1; 14] }), "v_goal: phases: where the last foot lands it ends at rest"),
    ] {
        assert_refused(&with(walk(), keys), words);
    }
}

#[test]
fn durations_that_cannot_be_meant_are_refused() {
    for (phase, keys, words) in [
        (1, json!({ "shortest_s": 0.5 }), "phases[1].longest_s: it is missing beside shortest_s"),
        (1, json!({ "shortest_s": 0.5, "longest_s": 0.4 }), "phases[1].longest_s: it is 0.4, below shortest_s, 0.5"),
        (0, json!({ "shortest_s": 0.0, "longest_s": 0.4 }), "phases[0].shortest_s: it is 0"),
        (0, json!({ "shortest_s": 0.1, "longest_s": 0.4 }), "horizon_s: it is 2, the phases last from 1.1 to 1.4 s"),
    ] {
        assert_refused(&in_phase(phase, keys), words);
    }
}

#[test]
fn feet_and_landings_that_cannot_be_meant_are_refused() {
    let tolerant = json!({ "frame": "right_sole", "position_m": [0.2, -0.25, 0.0], "tolerance_m": 0.01,
        "orientation_xyzw": [0.0, 0.0, 0.0, 1.0] });
    let land = |frame: &str, turn: [f64; 4]| {
        let at = [0.2, -0.25, 0.0];
        json!({ "frame": frame, "position_m": at, "orientation_xyzw": turn })
    };
    let turned = land("right_sole", [0.1, 0.0, 0.0, 0.99_f64.sqrt()]);
    let nearer = land("right_toe_roll", [0.0, 0.0, 0.0, 1.0]);
    let nose = json!({ "frame": "nose", "half_length_m": 0.1, "half_width_m": 0.1, "friction": 0.7 });
    for (phase, keys, words) in [
        (0, json!({ "land": null, "lift_m": null }), "phases[0].land: it is missing"),
        (1, json!({ "land": null }), "phases[1].lift_m: it needs land, which names the foot"),
        (0, json!({ "land": tolerant }), "phases[0].land: a position and an orientation without tolerances are needed"),
        (0, json!({ "land": turned }), "phases[0].land.orientation_xyzw: the z axis of the foot is not upwards"),
        (0, json!({ "land": nearer }), "phases[0].land.frame: it is not the foot of the next phase"),
        (0, json!({ "lift_m": -0.1 }), "phases[0].lift_m: a height from 0 to 10 m"),
        (1, json!({ "stand": nose }), "phases[1]:"),
    ] {
        assert_refused(&in_phase(phase, keys), words);
    }
}

#[test]
fn feet_with_other_bounds_are_refused_by_the_solve() {
    let edges = json!({ "frame": "right_sole", "half_length_m": 0.1, "half_width_m": 0.04, "friction": 0.7,
        "torsion": 0.05 });
    let scenario = load("edges", &in_phase(1, json!({ "stand": edges }))).expect("each is good");
    let refused = aghf_scenario::Solve::new(&scenario).run_walk().expect_err("their rows differ");
    let words = "phases: right_sole: its foot has more or fewer bounds than the first one";
    assert!(refused.to_string().contains(words), "{refused}");
}
