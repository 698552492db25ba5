//! Problems that are refused among others, and interruptions.

use crate::files::folder;
use aghf_cli::sweep::{Motions, Results, Row, RowOutcome, Shard, Sweep, run};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Forty problems of pendulums, 5 % of which are refused: one file is cut off, and one goal is out of reach.
fn problems(test: &str) -> PathBuf {
    let folder = folder(test).join("problems");
    let _ = std::fs::remove_dir_all(folder.parent().expect("it has one"));
    std::fs::create_dir_all(&folder).expect("writable");
    for i in 0..40 {
        let mut scenario = json!({
            "robot": "pendulum_1", "horizon_s": 2.0, "q_start": [0.0], "v_start": [0.0],
            "q_goal": [0.02 * f64::from(i)], "v_goal": [0.0],
        });
        if i == 13 {
            scenario["goal"] = json!({ "frame": "link_1", "position_m": [9.0, 0.0, 0.0] });
            let keys = scenario.as_object_mut().expect("an object");
            keys.retain(|key, _| key != "q_goal" && key != "v_goal");
        }
        let mut text = scenario.to_string();
        text.truncate(if i == 7 { 30 } else { text.len() });
        std::fs::write(folder.join(format!("swing_{i:02}.json")), text).expect("writable");
    }
    folder
}

fn load(folder: &Path) -> Sweep {
    Sweep::load(folder.to_str().expect("text")).expect("what is refused is a row")
}

/// Runs a sweep to its end; returns its rows and the number of solves.
fn finished(sweep: &Sweep, out: &Path) -> (Vec<Row>, usize) {
    let results = Results::open(sweep, Shard::WHOLE, out).expect("free");
    let count = AtomicUsize::new(0);
    let done = |row| {
        count.fetch_add(1, Ordering::Relaxed);
        results.append(row)
    };
    run(sweep, &results.missing(), None, &done).expect("a refused problem does not end it");
    let (rows, _) = results.finish().expect("all are there");
    (rows, count.into_inner())
}

#[test]
fn a_refused_problem_is_a_row_and_an_interruption_repeats_nothing() {
    let problems = problems("refused_rows");
    let sweep = load(&problems);
    let out = problems.with_file_name("out");
    let (rows, count) = finished(&sweep, &out);
    assert_eq!((rows.len(), count), (40, 40));
    for row in &rows {
        let reason = row.reason.as_deref().unwrap_or_default();
        let (outcome, words) = match row.set {
            7 => (RowOutcome::Refused, "swing_07.json"),
            13 => (RowOutcome::Refused, "goal"),
            _ => (RowOutcome::Success, ""),
        };
        assert_eq!(row.outcome, outcome, "{row:?}");
        assert!(reason.contains(words) && reason.is_empty() == words.is_empty(), "{row:?}");
    }

    let path = out.join("results.csv");
    let text = std::fs::read(&path).expect("it is there");
    for k in 0..25 {
        // Bytes all over the file, at its end among them.
        let cut = text.len() - (k * k * 7919) % text.len();
        std::fs::write(&path, &text[..cut]).expect("writable");
        let lines = text[..cut].iter().filter(|byte| **byte == b'\n').count();
        let (again, count) = finished(&load(&problems), &out);
        assert_eq!(count, 41 - lines.max(1), "cut at {cut}: complete rows are not solved again");
        assert!(rows.iter().zip(&again).all(|(a, b)| a.agrees(b)) && again.len() == 40, "cut at {cut}");
    }
}

#[test]
fn motions_are_kept_on_request() {
    let problems = problems("motions");
    for name in std::fs::read_dir(&problems).expect("it is there").map(|entry| entry.expect("good").path()) {
        if !["swing_06.json", "swing_07.json"].iter().any(|kept| name.ends_with(kept)) {
            std::fs::remove_file(name).expect("it is ours");
        }
    }
    let mut sweep = load(&problems);
    let out = problems.with_file_name("out");
    sweep.motions = Some(Motions { folder: out.join("motions"), sampling: None, with_page: false });
    finished(&sweep, &out);
    let entries = std::fs::read_dir(out.join("motions")).expect("it is there");
    let names: Vec<_> = entries.map(|entry| entry.expect("good").file_name()).collect();
    assert_eq!(names, ["swing_06"], "a refused problem has no motion");
    let summary = std::fs::read_to_string(out.join("motions/swing_06/summary.json")).expect("it is there");
    let summary: Value = serde_json::from_str(&summary).expect("JSON");
    assert_eq!(summary["verdict"], "optimal");
    // Results without motions are those of another sweep.
    sweep.motions = None;
    let error = Results::open(&sweep, Shard::WHOLE, &out).expect_err("motions");
    assert!(error.to_string().contains("sweep.json: motions"), "{error}");
}

/// Lists that one scenario does not accept are its own fault, lists that none accepts those of the sweep.
#[test]
fn lists_are_refused_where_no_scenario_accepts_them() {
    let grid = "method = \"flow\"\nscenarios = [\"pendulum_1_swingup\", \"kinova_obstacles_01\"]\ntime_limit_s = 60\n\
        k_cons = [5]\n";
    let sweep = crate::files::load("accepted", grid).expect("one accepts them");
    let reason = sweep.problems[0].scenario.as_ref().expect_err("it has no constraints");
    assert!(reason.starts_with("k_cons[0]: 'pendulum_1_swingup' has no constraints"), "{reason}");
    assert!(sweep.problems[1].scenario.is_ok());
    let error = crate::files::load("accepted", &grid.replace(", \"kinova_obstacles_01\"", "")).expect_err("none does");
    assert!(error.to_string().contains("grid.toml: k_cons[0]: "), "{error}");
}
