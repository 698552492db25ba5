//! Files and folders of results.

use crate::command::empty_folder;
use aghf_cli::output::{OutputFolder, summary_table, write_json, write_tradeoff};
use aghf_scenario::{FlowOptions, Scenario, Solve, SolveOptions};
use serde_json::{Value, json};
use std::collections::BTreeSet;

#[test]
fn lists_are_on_one_line_and_objects_on_several() {
    let value = json!({
        "a": 1,
        "list": [[1.5, 2], [], [{"x": null, "y": {"z": "w"}}]],
        "object": {"b": {"c": true}, "empty": {}},
    });
    let mut text = Vec::new();
    write_json(&value, &mut text).expect("memory takes it");
    let text = String::from_utf8(text).expect("it is text");
    let expected = r#"{
  "a": 1,
  "list": [[1.5, 2], [], [{"x": null, "y": {"z": "w"}}]],
  "object": {
    "b": {
      "c": true
    },
    "empty": {}
  }
}"#;
    assert_eq!(text, expected);
    let read: Value = serde_json::from_str(&text).expect("it is JSON");
    assert_eq!(read, value);
}

/// Processes that begin at the same time, here threads, do not share a folder.
#[test]
fn fresh_folders_are_all_different() {
    let place = empty_folder("results").join("results");
    let _ = std::fs::remove_dir_all(&place);
    let fresh = || OutputFolder::fresh(&place.join("same")).expect("it can be made");
    let made: Vec<OutputFolder> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|_| scope.spawn(fresh)).collect();
        let joined = threads.into_iter().map(|t| t.join().expect("it ends"));
        joined.collect()
    });
    let names: BTreeSet<_> = made.iter().map(|f| f.path().to_owned()).collect();
    assert_eq!(names.len(), 8);
    let expected = |i| {
        if i == 1 { "same".to_owned() } else { format!("same-{i}") }
    };
    assert_eq!(names, (1..9).map(|i| place.join(expected(i))).collect());
    // Those in which nothing was written do not stay.
    std::fs::write(place.join("same-3/mine"), "").expect("it can be written");
    drop(made);
    let left = std::fs::read_dir(&place).expect("it is there");
    let left: Vec<_> = left.map(|e| e.expect("it can be read").file_name()).collect();
    assert_eq!(left, ["same-3"]);
}

/// A folder that was there before is no concern of who writes in it.
#[test]
fn an_old_folder_stays() {
    let place = empty_folder("old").join("old");
    let _ = std::fs::remove_dir_all(&place);
    std::fs::create_dir_all(&place).expect("writable");
    drop(OutputFolder::open(&place, &["a"], false).expect("it is empty"));
    assert!(place.is_dir());
    std::fs::write(place.join("a"), "").expect("writable");
    let error = OutputFolder::open(&place, &["b", "a"], false).expect_err("it has one");
    assert!(error.to_string().contains("a: output: it exists already"), "{error}");
    OutputFolder::open(&place, &["b", "a"], true).expect("it may be replaced");
}

/// The rows of notes and passive torques stand in the table of a summary where they apply.
#[test]
fn the_table_of_a_summary_has_its_notes_and_the_largest_passive_torque() {
    let table = |name: &str, change: &dyn Fn(&mut Scenario), options: SolveOptions| {
        let mut scenario = Scenario::load(name).expect("built in");
        change(&mut scenario);
        let report = Solve::new(&scenario).options(options).run();
        summary_table(&report.expect("valid").summary, true)
    };
    let by_flow = FlowOptions { k: Some(1e5), s_max: Some(1.0), ..FlowOptions::default() };
    let weights = serde_json::from_value(json!({ "acceleration": 1.0 })).expect("weights");
    let weighted = |scenario: &mut Scenario| scenario.file.objective = Clone::clone(&weights);
    let flow = table("pendulum_1_swingup", &weighted, by_flow.into());
    // Long values are wrapped.
    let flow = flow.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(flow.contains("objective: the published flow minimises the control effort alone"), "{flow}");
    let fast = serde_json::from_value(json!("least-time")).expect("a preset");
    let soon = |scenario: &mut Scenario| scenario.file.objective = Clone::clone(&fast);
    let soon = table("limits_01", &soon, SolveOptions::default());
    assert!(
        soon.contains(" s, the horizon; objective: least-time") && soon.contains("largest acceleration, not limited"),
        "{soon}"
    );
    let passive = table("cart_pole_swingup", &|_| (), SolveOptions::default());
    let row = passive.lines().find(|line| line.contains("largest torque of passive joints"));
    assert!(row.is_some_and(|row| row.contains(" of ")), "{passive}");
    let driven = table("pendulum_1_swingup", &|_| (), SolveOptions::default());
    assert!(!driven.contains("passive") && driven.contains("; objective: least-effort"), "{driven}");
}

/// The motions of a trade-off are there although its page cannot be written.
#[test]
fn motions_are_written_before_their_page() {
    let folder = empty_folder("page_last").join("curve");
    let scenario = Scenario::load("pendulum_1_swingup").expect("built in");
    let report = Solve::new(&scenario).run().expect("it is good");
    let found = [(scenario.clone(), report.clone()), (scenario, report)];
    let folder = OutputFolder::open(&folder, &[], false).expect("it can be made");
    std::fs::create_dir(folder.path().join("report.html")).expect("writable");
    let written = write_tradeoff(&found, "page", &folder);
    let error = written.expect_err("there is a folder").to_string();
    assert!(error.contains("report.html"), "{error}");
    for name in ["tradeoff.csv", "summary_01.json", "summary_02.json"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
}
