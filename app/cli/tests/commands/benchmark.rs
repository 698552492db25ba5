//! `aghf benchmark`.

use crate::command::{aghf, assert_bad_input, empty_folder};
use serde_json::json;
use std::path::Path;

/// Two problems of a family that are solved and one of another that cannot be: its goal is in a sphere.
fn problems(folder: &Path) {
    for name in ["table_pick_0001", "table_pick_0020"] {
        let from = format!("{}/robots/panda/scenarios/{name}.json", concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        std::fs::copy(from, folder.join(format!("{name}.json"))).expect("it is there");
    }
    let blocked = json!({
        "robot": "pendulum_1", "horizon_s": 1.0, "q_start": [0.0], "v_start": [0.0], "q_goal": [3.0], "v_goal": [0.0],
        "obstacles": [{ "shape": { "sphere": { "radius_m": 5.0 } }, "pose": { "position_m": [0.0, 0.0, 0.0] } }]
    });
    std::fs::write(folder.join("blocked_1.json"), blocked.to_string()).expect("writable");
}

/// The lines of the results without the times.
fn results(folder: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join("out/results.csv")).expect("written");
    let lines = text.lines().map(|line| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        fields.remove(3);
        fields
    });
    lines.collect()
}

/// Every problem has a line and every family one in the table; a run that was interrupted goes on, and another one
/// finds the same motions.
#[test]
fn problems_are_solved_and_judged() {
    let folder = empty_folder("benchmark");
    let inputs = folder.join("problems_here");
    std::fs::create_dir(&inputs).expect("it can be made");
    problems(&inputs);
    let arguments = ["benchmark", "problems_here", "--out", "out"];
    let run = aghf(&folder, &arguments);
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    assert!(run.stderr.contains("blocked_1: Impossible: "), "{}", run.stderr);
    let table = std::fs::read_to_string(folder.join("out/table.md")).expect("written");
    for line in ["| blocked | 1 | 0 | 1 |", "| table_pick | 2 | 2 | 0 |", "| all | 3 | 2 | 1 |"] {
        assert!(table.contains(line), "{table}");
    }
    let first = results(&folder);
    assert_eq!(first.len(), 4);
    assert!(first[2..].iter().all(|line| line[2] == "optimal"), "{first:?}");
    // With half of its last line only that is solved again.
    let path = folder.join("out/results.csv");
    let text = std::fs::read_to_string(&path).expect("written");
    let all: Vec<&str> = text.lines().collect();
    std::fs::write(&path, &text[..text.len() - all[3].len() / 2]).expect("writable");
    let again = aghf(&folder, &arguments);
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    assert!(!again.stderr.contains("blocked_1"), "{}", again.stderr);
    assert_eq!(results(&folder), first);
    let kept = std::fs::read_to_string(&path).expect("written");
    assert!(kept.starts_with(&all[..3].join("\n")));
}

#[test]
fn bad_folders_are_refused() {
    let folder = empty_folder("benchmark_bad");
    assert_bad_input(&folder, &["benchmark", "nowhere"], "pip download");
    std::fs::create_dir_all(folder.join("empty/cage_panda")).expect("it can be made");
    assert_bad_input(&folder, &["benchmark", "empty"], "neither scenarios nor");
    problems(&folder);
    std::fs::create_dir(folder.join("out")).expect("it can be made");
    std::fs::write(folder.join("out/results.csv"), "family,problem\na,b\n").expect("writable");
    assert_bad_input(&folder, &["benchmark", ".", "--out", "out"], "results.csv: line 1: it is not the header");
}

/// Files that are faulty are lines with the reason, which a resumed run does not repeat.
#[test]
fn a_refused_problem_is_a_line() {
    let folder = empty_folder("benchmark_refused");
    std::fs::create_dir_all(folder.join("scenes/cage_panda")).expect("it can be made");
    std::fs::write(folder.join("scenes/cage_panda/scene0001.yaml"), "").expect("writable");
    std::fs::create_dir(folder.join("files")).expect("it can be made");
    problems(&folder.join("files"));
    std::fs::write(folder.join("files/a_broken_1.json"), json!({ "robot": "pendulum_1" }).to_string())
        .expect("writable");
    for (problems, all, words) in [("scenes", 1, "scene0001.yaml"), ("files", 4, "a_broken_1.json")] {
        let arguments = ["benchmark", problems, "--out", problems];
        let run = aghf(&folder, &arguments);
        assert_eq!(run.code, Some(1), "{}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains(": Refused: ") && run.stderr.contains(words), "{}", run.stderr);
        let table = folder.join(problems).join("results.csv");
        let text = std::fs::read_to_string(&table).expect("written");
        assert_eq!(text.lines().count(), 1 + all, "{text}");
        let again = aghf(&folder, &arguments);
        assert_eq!((again.code, again.stderr.as_str()), (Some(1), ""));
        assert_eq!(std::fs::read_to_string(&table).expect("written"), text);
    }
}
