//! Nothing that was found is lost, and everything that was found can be found again.

use crate::command::{Run, aghf, assert_bad_input, empty_folder, files, parsed};
use crate::solve::MISSING;
use aghf_scenario::sha256;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const SWING: &str = "pendulum_1_swingup";

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn names<const N: usize>(names: [&str; N]) -> BTreeSet<String> {
    names.map(str::to_owned).into()
}

fn solved(folder: &Path, arguments: &[&str]) -> Run {
    let run = aghf(folder, &[&["solve"], arguments].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    run
}

#[test]
fn a_folder_that_takes_no_file_is_refused_before_the_search() {
    let folder = empty_folder("unwritable");
    std::fs::write(folder.join("file"), "a file").expect("writable");
    for out in ["file", "file/below"] {
        let run = aghf(&folder, &["solve", SWING, "-v", "--out", out]);
        assert_eq!(run.code, Some(2), "{out}");
        assert!(run.stderr.contains("file"), "{out}: {}", run.stderr);
        assert!(!run.stderr.contains("degree"), "{out}: it searched: {}", run.stderr);
    }
    assert_eq!(files(&folder), names(["file"]));
}

#[test]
fn a_failure_is_written_beside_an_earlier_success() {
    let folder = empty_folder("beside");
    solved(&folder, &["pendulum_5_swingup", "--starts", "2", "--out", "keep"]);
    let good = ["keep/report.html", "keep/summary.json", "keep/trajectory.csv"];
    let before = good.map(|f| text(&folder.join(f)));
    let failing = [MISSING, &["--out", "keep"]].concat();
    // Without leave not even that.
    assert_bad_input(&folder, &failing, "keep/trajectory.csv: output: it exists already; --force");
    let run = aghf(&folder, &[&failing[..], &["--force"]].concat());
    assert_eq!(run.code, Some(3), "{}", run.stderr);
    assert_eq!(good.map(|f| text(&folder.join(f))), before);
    let failed = ["keep/summary.failed.json", "keep/trajectory.failed.csv"];
    let page = "keep/report.failed.html";
    assert_eq!(files(&folder), names([failed[0], failed[1], page, good[0], good[1], good[2]]));
    assert!(text(&folder.join(failed[1])).starts_with("# failed: "));
    // The table of a failure says so whenever it is made.
    let run = aghf(&folder, &["sample", failed[0], "--samples", "2"]);
    let lines: Vec<&str> = run.stdout.lines().collect();
    assert!(lines.len() == 5 && lines[0].starts_with("# run_sha256:"), "{lines:?}");
    assert!(lines[1].starts_with("# failed: "), "{lines:?}");
}

#[test]
fn scenarios_of_the_same_stem_have_folders_of_their_own() {
    let folder = empty_folder("stem");
    let swing = parsed(&aghf(&folder, &["scenarios", SWING]));
    for (place, goal) in [("a", 1.0), ("b", 1.25)] {
        let mut scenario = swing.clone();
        scenario["q_goal"] = json!([goal]);
        std::fs::create_dir(folder.join(place)).expect("writable");
        let file = folder.join(place).join("move.json");
        std::fs::write(file, scenario.to_string()).expect("writable");
        solved(&folder, &[&format!("{place}/move.json")]);
    }
    for (place, goal) in [("out/move", 1.0), ("out/move-2", 1.25)] {
        let summary: Value = serde_json::from_str(&text(&folder.join(place).join("summary.json"))).expect("JSON");
        assert_eq!(summary["provenance"]["scenario"]["q_goal"], json!([goal]), "{place}");
    }
    // Told to, it replaces what is in the first one.
    solved(&folder, &["b/move.json", "--force"]);
    let [first, second] = ["out/move", "out/move-2"].map(|f| text(&folder.join(f).join("trajectory.csv")));
    assert!(first == second);
    assert!(!folder.join("out/move-3").exists());
}

#[test]
fn no_file_is_overwritten_unless_told() {
    let folder = empty_folder("overwrite");
    let robots = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("robots/pendulum_2/pendulum_2.urdf");
    std::fs::copy(robots, folder.join("mine.urdf")).expect("writable");
    let before = text(&folder.join("mine.urdf"));
    let write = ["robots", "mine.urdf", "--urdf", "mine.urdf"];
    assert_bad_input(&folder, &write, "mine.urdf: output: it exists already");
    assert_eq!(text(&folder.join("mine.urdf")), before);
    let run = aghf(&folder, &[&write[..], &["--force"]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_ne!(text(&folder.join("mine.urdf")), before);

    solved(&folder, &[SWING, "--out", "here"]);
    for again in [
        &["solve", SWING, "--out", "here"][..],
        &["sample", "here/summary.json", "--out", "mine.urdf"],
        &["sample", "here/summary.json", "--out", "here/trajectory.csv"],
    ] {
        assert_bad_input(&folder, again, "it exists already");
    }
}

/// A scenario whose name is that of no folder needs a folder by an option.
#[test]
fn a_name_that_is_no_folder_is_refused_in_words() {
    let folder = empty_folder("dots");
    let swing = parsed(&aghf(&folder, &["scenarios", SWING]));
    for name in ["..json", "...json"] {
        std::fs::write(folder.join(name), swing.to_string()).expect("writable");
        let path = format!("./{name}");
        for command in [&["solve", &*path][..], &["solve", &*path, "--force"]] {
            let words = "output: its name is not that of a folder; --out chooses one";
            assert_bad_input(&folder, command, words);
        }
        solved(&folder, &[&*path, "--out", "here", "--force"]);
    }
}

#[test]
fn bad_input_leaves_no_folder() {
    let folder = empty_folder("no_folder");
    assert_bad_input(&folder, &["solve", SWING, "--degree", "1"], "degree: it is 1");
    assert_bad_input(&folder, &["solve", SWING, "--samples", "1"], "samples: it is 1");
    assert_bad_input(&folder, &["solve", SWING, "--rate", "1e9"], "rate: 1000000000 Hz over 2 s");
    assert_bad_input(&folder, &["solve", SWING, "--rate", "-1"], "rate: it is -1");
    assert!(!folder.join("out").join(SWING).exists());
}

#[test]
fn a_solve_is_repeated_from_its_summary() {
    let folder = empty_folder("repeat");
    let robot = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("robots/pendulum_2/pendulum_2.urdf");
    std::fs::create_dir(folder.join("tasks")).expect("writable");
    std::fs::copy(robot, folder.join("tasks/mine.urdf")).expect("writable");
    let mut scenario = parsed(&aghf(&folder, &["scenarios", "pendulum_2_swingup"]));
    scenario["robot"] = json!("mine.urdf");
    std::fs::write(folder.join("tasks/lift.json"), scenario.to_string()).expect("writable");
    let options = ["--degree", "9", "--segments", "2", "--starts", "3", "--seed", "5"];
    solved(&folder, &[&["tasks/lift.json", "--out", "first"], &options[..]].concat());
    solved(&folder, &["first/summary.json", "--out", "second"]);
    let [first, second] = ["first", "second"].map(|f| text(&folder.join(f).join("trajectory.csv")));
    assert!(first == second, "to the last digit");
    let summary: Value = serde_json::from_str(&text(&folder.join("second/summary.json"))).expect("JSON");
    assert_eq!(summary["scenario"], "lift");
    let provenance = &summary["provenance"];
    assert_eq!(provenance["version"], env!("CARGO_PKG_VERSION"));
    for (key, value) in [("degree", 9), ("segments", 2), ("starts", 3), ("seed", 5)] {
        assert_eq!(provenance["options"][key], value, "{key}");
    }
    assert_eq!(provenance["options"]["tolerance"], 1e-6, "what was not given is told as well");
    // What is given goes before what was, and another seed bends the starts otherwise.
    let run = solved(&folder, &["first/summary.json", "--seed", "6", "--json"]);
    let other: Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(other["provenance"]["options"]["seed"], 6);
    assert_eq!(other["start_costs"].as_array().map(Vec::len), Some(3));
    assert_ne!(other["start_costs"], summary["start_costs"]);
    // Another method has none of these options.
    let run = aghf(&folder, &["solve", "first/summary.json", "--method", "flow", "--json"]);
    assert!(matches!(run.code, Some(0 | 3)), "{}", run.stderr);
    // A robot that has changed since is no repetition.
    let urdf = text(&folder.join("tasks/mine.urdf"));
    std::fs::write(folder.join("tasks/mine.urdf"), urdf + "\n").expect("writable");
    let again = ["solve", "first/summary.json"];
    assert_bad_input(&folder, &again, "first/summary.json; mine.urdf: its text is not what it was");
}

#[test]
fn a_run_is_named_by_its_folder() {
    let folder = empty_folder("run");
    solved(&folder, &[SWING, "--out", "m"]);
    let [by_folder, by_file] = ["m", "m/summary.json"].map(|of| aghf(&folder, &["sample", of]));
    assert!(by_folder.stdout.contains("\nt,"), "{}", by_folder.stdout);
    assert_eq!(by_folder.stdout, by_file.stdout);
    solved(&folder, &[SWING, "--out", "again", "--start", "m"]);
}

/// A folder with a motion of two segments in `m`, and a table at 10.3 rows a second.
fn with_segments(test: &str) -> PathBuf {
    let folder = empty_folder(test);
    let options = "--out m --segments 2 --degree 9 --rate 10.3";
    let options: Vec<_> = options.split_whitespace().collect();
    solved(&folder, &[&[SWING], &options[..]].concat());
    folder
}

#[test]
fn a_summary_gives_tables_at_any_rate() {
    let folder = with_segments("sample");
    let table = |arguments: &[&str]| {
        let arguments = [&["sample", "m/summary.json"], arguments].concat();
        let run = aghf(&folder, &arguments);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let (comment, table) = run.stdout.split_once('\n').expect("there are lines");
        let hash = sha256(text(&folder.join("m/summary.json")).as_bytes());
        assert_eq!(comment, format!("# run_sha256:{hash}"));
        table.to_owned()
    };
    // The table of the solve and that of its summary differ by the rounding of its coefficients.
    let numbers = |table: &str| -> Vec<f64> {
        let cells = table.lines().skip(1).flat_map(|row| row.split(','));
        cells.map(|x| x.parse().expect("a number")).collect()
    };
    let (again, first) = (table(&["--rate", "10.3"]), text(&folder.join("m/trajectory.csv")));
    let both = numbers(&again).into_iter().zip(numbers(&first));
    assert!(again.lines().count() == first.lines().count());
    assert!(both.into_iter().all(|(a, b)| (a - b).abs() < 1e-9 * b.abs().max(1.0)));
    let times = |table: &str| -> Vec<f64> {
        let rows = table.lines().skip(1);
        rows.map(|row| row.split(',').next().unwrap_or("").parse().expect("a number")).collect()
    };
    // Products with the rate that are whole numbers but for rounding have no row twice.
    for rate in ["27.5", "100", "0.55", "4.35", "1e3"] {
        let times = times(&table(&["--rate", rate]));
        assert!(times.windows(2).all(|w| w[1] - w[0] > 1e-9), "{rate}: {times:?}");
    }
    assert_eq!(times(&table(&["--rate", "2"])), [0.0, 0.5, 1.0, 1.5, 2.0]);
    // Twenty of them, and the end.
    let slow = times(&table(&["--rate", "10.3"]));
    assert_eq!((slow.len(), slow[1], slow[20], slow[21]), (22, 1.0 / 10.3, 20.0 / 10.3, 2.0));
    assert_eq!(times(&table(&["--samples", "3"])), [0.0, 1.0, 2.0]);
    assert_eq!(times(&table(&[])).len(), 201);
    let out = ["sample", "m/summary.json", "--out", "wide.csv"];
    assert_eq!(aghf(&folder, &out).code, Some(0));
    assert!(text(&folder.join("wide.csv")).ends_with(&table(&[])));
}

#[test]
fn a_summary_that_does_not_fit_is_refused() {
    let folder = with_segments("sample_refused");
    for (change, words) in [
        (json!({"curve": {"degree": 8}}), "curve.coefficients[0]: 2 rows of 9 numbers are needed"),
        (json!({"curve": {"horizon_s": -1.0}}), "curve; it is -"),
        (json!({"curve": {"coefficients": [[[0.0]]]}}), "curve.coefficients: 1 segments are given, 2 are needed"),
        (json!({"provenance": {"robot_sha256": "0"}}), "pendulum_1: its text is not what it was"),
        (json!({"provenance": {"options": {"degree": "nine"}}}), "provenance.options; degree: invalid type"),
        (json!({"provenance": {"scenario": {"q_start": []}}}), "q_start"),
    ] {
        let summary = text(&folder.join("m/summary.json"));
        let mut changed: Value = serde_json::from_str(&summary).expect("JSON");
        merge(&mut changed, &change);
        std::fs::write(folder.join("bad.json"), changed.to_string()).expect("writable");
        assert_bad_input(&folder, &["sample", "bad.json"], &format!("bad.json; {words}"));
    }
    let scenario = aghf(&folder, &["scenarios", SWING]).stdout;
    std::fs::write(folder.join("scenario.json"), scenario).expect("writable");
    assert_bad_input(&folder, &["sample", "scenario.json"], "scenario.json: provenance: it is missing");
}

/// Replaces keys of objects within objects.
fn merge(value: &mut Value, by: &Value) {
    match by {
        Value::Object(keys) => keys.iter().for_each(|(key, by)| merge(&mut value[key], by)),
        other => *value = other.clone(),
    }
}

#[test]
fn places_that_cannot_be_written_exit_with_2_and_leave_nothing_half_done() {
    let folder = empty_folder("unwritable");
    std::fs::write(folder.join("file"), "mine").expect("writable");
    for out in ["file", "file/below"] {
        assert_bad_input(&folder, &["solve", "pendulum_1_swingup", "--out", out], &format!("aghf: {out}"));
    }
    assert_eq!(files(&folder), ["file".to_owned()].into());
    assert_eq!(std::fs::read_to_string(folder.join("file")).expect("it is there"), "mine");
    for taken in ["trajectory.csv", "summary.json", "report.html"] {
        let out = format!("taken_{taken}");
        std::fs::create_dir_all(folder.join(&out).join(taken)).expect("writable");
        assert_bad_input(&folder, &["solve", "pendulum_1_swingup", "--out", &out], &format!("aghf: {out}/{taken}: "));
    }
    let left = files(&folder);
    assert!(!left.iter().any(|f| f.contains("partial")), "{left:?}");
}
