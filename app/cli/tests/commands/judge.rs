//! `aghf judge`.

use crate::command::{aghf, assert_bad_input, empty_folder, files};
use serde_json::{Value, json};
use std::path::Path;

/// A pendulum that hangs at rest for a second, of a scenario with a sphere to keep clear of.
fn hanging(folder: &Path) {
    let scenario = json!({
        "robot": "pendulum_1", "horizon_s": 1.0, "q_start": [0.0], "v_start": [0.0], "q_goal": [0.0], "v_goal": [0.0],
        "obstacles": [{ "shape": { "sphere": { "radius_m": 0.5 } }, "pose": { "position_m": [5.0, 0.0, 0.0] } }]
    });
    std::fs::write(folder.join("hang.json"), scenario.to_string()).expect("writable");
}

/// The table of a solve is valid for its scenario and for no other; the verdict is written as JSON.
#[test]
fn what_is_solved_is_valid() {
    let folder = empty_folder("judge_solved");
    let solved = aghf(&folder, &["solve", "kinova_obstacles_02", "--out", "out"]);
    assert_eq!(solved.code, Some(0), "{}", solved.stderr);
    let table = "out/trajectory.csv";
    let arguments = ["judge", "kinova_obstacles_02", table, "--json", "verdict.json"];
    let run = aghf(&folder, &arguments);
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("\nvalid\n"), "{}", run.stdout);
    let text = std::fs::read_to_string(folder.join("verdict.json")).expect("it is written");
    let verdict: Value = serde_json::from_str(&text).expect("it is JSON");
    assert_eq!((&verdict["valid"], &verdict["verdict"]), (&json!(true), &json!("valid")));
    let rows = std::fs::read_to_string(folder.join(table)).expect("it is written");
    assert_eq!(verdict["samples"], rows.lines().count() - 1);
    let checks = verdict["checks"].as_array().expect("a list");
    let obstacles = checks.iter().find(|row| row["check"] == "obstacles").expect("checked");
    assert_eq!(obstacles["outcome"], "pass");
    assert!(obstacles["value"].as_f64() >= obstacles["proved_at_least"].as_f64());
    assert_bad_input(&folder, &arguments, "verdict.json; --force");
    let other = aghf(&folder, &["judge", "kinova_obstacles_01", table]);
    assert_eq!(other.code, Some(1), "{}", other.stdout);
    assert!(
        other.stdout.contains("\nnot valid: goal position: joint 'joint_7' has ") && other.stdout.contains("FAIL"),
        "{}",
        other.stdout
    );
    // The summary of a solve is a scenario too.
    let summary = aghf(&folder, &["judge", "out/summary.json", table]);
    assert_eq!(summary.code, Some(0), "{}", summary.stdout);
    for of_run in ["out", "out/summary.json"] {
        let judged = aghf(&folder, &["judge", "out/summary.json", of_run]);
        assert_eq!((judged.code, &judged.stdout), (Some(0), &summary.stdout));
    }
    assert_bad_input(&folder, &["judge", "out/summary.json", "."], "neither 'summary.json' nor");
}

#[test]
fn tolerances_are_options() {
    let folder = empty_folder("judge_tolerances");
    hanging(&folder);
    let joint = "joint_1";
    let table = format!("t,q_{joint}\n0,0.0\n0.5,0.0\n1.01,0.0\n");
    std::fs::write(folder.join("late.csv"), table).expect("writable");
    let late = aghf(&folder, &["judge", "hang.json", "late.csv"]);
    assert_eq!(late.code, Some(1), "{}{}", late.stdout, late.stderr);
    assert!(late.stdout.contains("the rates of q by five neighbouring samples"), "{}", late.stdout);
    let tolerated = aghf(&folder, &["judge", "hang.json", "late.csv", "--tolerance", "0.02"]);
    // Three samples do not determine rates.
    assert_eq!(tolerated.code, Some(4), "{}", tolerated.stdout);
    let words = "\nvalid in part; not checked: start velocity, goal velocity, continuity";
    assert!(tolerated.stdout.contains(words), "{}", tolerated.stdout);
    let arguments = ["judge", "hang.json", "late.csv", "--tolerance", "-1"];
    assert_bad_input(&folder, &arguments, "options: tolerance; not negative");
    let arguments = ["judge", "hang.json", "late.csv", "--overlap", "nan"];
    assert_bad_input(&folder, &arguments, "options: overlap; not negative");
}

/// Nothing is judged, and nothing written, of what cannot be read.
#[test]
fn bad_tables_are_refused() {
    let folder = empty_folder("judge_refused");
    hanging(&folder);
    std::fs::write(folder.join("bad.csv"), "t,q_joint_1\n0,0\n1,oops\n").expect("writable");
    let before = files(&folder);
    let arguments = ["judge", "hang.json", "bad.csv", "--json", "verdict.json"];
    assert_bad_input(&folder, &arguments, "bad.csv: line 3, column 'q_joint_1'; 'oops' is no finite number");
    assert_bad_input(&folder, &["judge", "hang.json", "none.csv"], "none.csv");
    assert_bad_input(&folder, &["judge", "none.json", "bad.csv"], "none.json");
    assert_eq!(files(&folder), before);
}
