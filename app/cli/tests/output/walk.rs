//! The files and the table of a walk.

use crate::command::{aghf, assert_bad_input, empty_folder, files};
use serde_json::Value;

const WALK: &str = include_str!("../../../scenario/tests/scenario/walk.json");

/// Each phase has the files of a solve, which the commands take; the table has a row per phase and a line per landing.
#[test]
fn a_walk_has_a_folder_per_phase() {
    let folder = empty_folder("walk");
    std::fs::write(folder.join("walk.json"), WALK).expect("it is writable");
    let run = aghf(&folder, &["solve", "walk.json", "--out", "out"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for words in ["walk_phase_1", "walk_phase_2", "optimal", "'right_sole' lands at 1.0000 s", "wrote out/phase_*"] {
        assert!(run.stdout.contains(words), "'{words}': {}", run.stdout);
    }
    let names = ["report.html", "summary.json", "trajectory.csv"];
    let phases = ["out/phase_1", "out/phase_2"];
    let all = phases.iter().flat_map(|phase| names.map(|name| format!("{phase}/{name}")));
    let all = all.chain(["walk.json".to_owned()]).collect();
    assert_eq!(files(&folder), all);
    for phase in phases {
        let [summary, table] =
            names[1..].iter().map(|name| format!("{phase}/{name}")).collect::<Vec<_>>().try_into().expect("two");
        let judged = aghf(&folder, &["judge", &summary, &table]);
        assert_eq!(judged.code, Some(0), "{}{}", judged.stdout, judged.stderr);
        // The checker finds the joints from the foot that stands.
        let certified = aghf(&folder, &["certify", &summary, phase, "--out", "certificate.json", "--force"]);
        assert_eq!(certified.code, Some(0), "{}{}", certified.stdout, certified.stderr);
    }
    // Nothing is overwritten, nor left of a longer walk.
    assert_bad_input(&folder, &["solve", "walk.json", "--out", "out"], "phase_1; exists already");
    std::fs::create_dir(folder.join("out/phase_3")).expect("it is writable");
    assert_bad_input(
        &folder,
        &["solve", "walk.json", "--out", "out", "--force"],
        "phase_3: output: it is of a longer walk",
    );
}

#[test]
fn a_walk_as_json_has_its_phases_and_landings() {
    let folder = empty_folder("walk_json");
    std::fs::write(folder.join("walk.json"), WALK).expect("it is writable");
    let run = aghf(&folder, &["solve", "walk.json", "--json", "--no-report"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let found: Value = serde_json::from_str(&run.stdout).expect("it is JSON");
    assert_eq!(found["phases"].as_array().map(Vec::len), Some(2));
    assert_eq!(found["landings"][0]["frame"], "right_sole");
    assert!(found["landings"][0]["speed"].as_f64().expect("a number") < 1e-6);
    assert_bad_input(
        &folder,
        &["judge", "walk.json", "out/walk/phase_1/trajectory.csv"],
        "phases: a walk has a scenario",
    );
}
