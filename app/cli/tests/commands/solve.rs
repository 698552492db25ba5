//! The `aghf` binary solves a scenario from end to end: its files, its output, its exit codes.

use crate::command::{aghf, assert_bad_input, empty_folder, files};
use aghf::dynamics::{Data, rnea};
use aghf_scenario::Scenario;
use serde_json::{Value, json};
use std::path::Path;

fn json_file(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).expect("it is JSON")
}

/// The header and the rows of a CSV.
fn csv_file(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut reader = csv::Reader::from_path(path).expect("it is there");
    let header = reader.headers().expect("it has one").iter().map(str::to_owned).collect();
    let rows = reader.records().map(|row| {
        let row = row.expect("as long as the header");
        row.iter().map(|x| x.parse().expect("a number")).collect()
    });
    (header, rows.collect())
}

#[test]
fn without_arguments_it_plans_over_the_table() {
    let folder = empty_folder("default");
    let run = aghf(&folder, &[]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let expected =
        ["out/kinova_table_01/report.html", "out/kinova_table_01/summary.json", "out/kinova_table_01/trajectory.csv"];
    assert_eq!(files(&folder), expected.map(str::to_owned).into());
    let rows = [
        "kinova_table_01 (kinova_gen3)",
        "verdict",
        "optimal",
        "% above the",
        "nearest approach",
        "acceleration 100 %",
        "wrote trajectory.csv, summary.json, report.html in out/kinova_table_01",
    ];
    for words in rows {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    let is_narrow = run.stdout.lines().all(|line| line.chars().count() <= 100);
    assert!(is_narrow && run.stdout.lines().count() <= 12, "{}", run.stdout);
    assert!(!run.stdout.contains("gradient norm"), "those are numbers of the method: {}", run.stdout);
    let duration = assert_table_01(&folder.join(expected[2]));
    assert_summary_01(&folder.join(expected[1]), duration);
    assert_around_the_post(&folder, expected[2]);
}

/// Asserts that a CSV has a motion of `kinova_table_01`, and returns its duration in s.
fn assert_table_01(path: &Path) -> f64 {
    let Scenario { file: scenario, model, .. } = Scenario::load("kinova_table_01").expect("built in");
    let (header, rows) = csv_file(path);
    let joints = (1..=7).map(|i| format!("joint_{i}"));
    let columns = ["q", "v", "a", "u"].iter().flat_map(|x| joints.clone().map(move |j| format!("{x}_{j}")));
    assert_eq!(header, std::iter::once("t".to_owned()).chain(columns).collect::<Vec<_>>());
    assert_eq!((header.len(), rows.len()), (1 + 4 * 7, 401));
    assert!(rows.iter().flatten().all(|x| x.is_finite()));
    assert!(rows.windows(2).all(|w| w[0][0] < w[1][0]), "time ascends");
    let duration = rows[400][0];
    assert!(rows[0][0] == 0.0 && (1.5..2.0).contains(&duration), "{duration}");
    for (row, q, v) in
        [(&rows[0], &scenario.q_start, &scenario.v_start), (&rows[400], &scenario.q_goal, &scenario.v_goal)]
    {
        let state = q.iter().chain(v);
        assert!(row[1..15].iter().zip(state).all(|(a, b)| (a - b).abs() < 1e-12), "{row:?}");
    }

    // The control is the inverse dynamics of the other columns.
    for row in rows.iter().step_by(40) {
        let column = |i: usize| &row[1 + 7 * i..][..7];
        let mut tau = [0.0; 7];
        let data = &mut Data::new(&model);
        rnea(&model, data, column(0), column(1), column(2), &mut tau).expect("lengths agree");
        assert_eq!(column(3), tau, "at {}", row[0]);
    }
    duration
}

/// Asserts that a summary is that of a solve of `kinova_table_01` with this duration.
fn assert_summary_01(path: &Path, duration: f64) {
    let summary = json_file(path);
    for key in [
        "final_error_inf",
        "open_loop_error_inf",
        "control_effort",
        "dynamics_defect",
        "solve_seconds",
        "gradient_norm",
        "smallest_curvature",
        "quadrature_points",
        "iterations",
        "factorisations",
    ] {
        assert!(summary[key].as_f64().is_some_and(|x| x > 0.0), "{key}: {summary}");
    }
    for (key, value) in [("scenario", "kinova_table_01"), ("robot", "kinova_gen3"), ("method", "direct")] {
        assert_eq!(summary[key], value);
    }
    assert_eq!(summary["success"], true);
    assert!(summary["final_error_inf"].as_f64() < Some(0.05));
    assert_eq!(summary["horizon_s"].as_f64(), Some(duration));
}

/// Asserts that a motion goes around the post of `kinova_table_01`, which the motion without one does not.
fn assert_around_the_post(folder: &Path, trajectory: &str) {
    let run = aghf(folder, &["judge", "kinova_table_01", trajectory]);
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    let text = include_str!("../../../../robots/kinova_gen3/kinova_table_01.json");
    let mut without: serde_json::Value = serde_json::from_str(text).expect("it is built in");
    let obstacles = without["obstacles"].as_array_mut().expect("a list");
    obstacles.retain(|obstacle| obstacle["name"] != "post");
    std::fs::write(folder.join("without.json"), without.to_string()).expect("it can be written");
    let run = aghf(folder, &["solve", "without.json", "--out", "without"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let run = aghf(folder, &["judge", "kinova_table_01", "without/trajectory.csv"]);
    assert_eq!(run.code, Some(1), "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains(" and 'post'"), "{}", run.stdout);
}

#[test]
fn json_is_the_summary_and_nothing_else() {
    let folder = empty_folder("json");
    let run = aghf(&folder, &["solve", "pendulum_1_swingup", "--json"]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let written = std::fs::read_to_string(folder.join("out/pendulum_1_swingup/summary.json"));
    assert_eq!(run.stdout, written.expect("it is there"));
    serde_json::from_str::<Value>(&run.stdout).expect("it is JSON");
}

#[test]
fn options_override_the_scenario_and_show_in_the_summary() {
    let folder = empty_folder("options");
    let arguments = "solve pendulum_1_swingup --method flow --jacobian dual --degree 8 --k 3e4 --s-max 50 \
        --tolerance 1e-5 --guess line_state --out deep/in/here --json --no-report";
    let run = aghf(&folder, &arguments.split_whitespace().collect::<Vec<_>>());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let expected = ["deep/in/here/summary.json", "deep/in/here/trajectory.csv"];
    assert_eq!(files(&folder), expected.map(str::to_owned).into());
    let summary = json_file(&folder.join(expected[0]));
    for (key, value) in [
        ("degree", json!(8)),
        ("k", json!(3e4)),
        ("s_max", json!(50.0)),
        ("tolerance", json!(1e-5)),
        ("guess", json!("line_state")),
        ("method", json!("flow")),
        ("jacobian", json!("dual")),
    ] {
        assert_eq!(summary[key], value, "{key}");
    }
    for key in ["action", "steps", "omega_evaluations", "jacobian_evaluations"] {
        assert!(summary[key].as_f64().is_some_and(|x| x > 0.0), "{key}: {summary}");
    }
}

#[test]
fn options_of_the_direct_method_show_in_the_summary() {
    let folder = empty_folder("direct_options");
    let arguments = "solve pendulum_1_swingup --degree 10 --tolerance 1e-7 --starts 3 --json";
    let run = aghf(&folder, &arguments.split_whitespace().collect::<Vec<_>>());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let summary: Value = serde_json::from_str(&run.stdout).expect("it is JSON");
    assert_eq!((&summary["degree"], &summary["tolerance"]), (&json!(10), &json!(1e-7)));
    assert_eq!(summary["start_costs"].as_array().map(Vec::len), Some(3));
    assert!(summary["gradient_norm"].as_f64() <= Some(1e-7));
    // What only the flow has is not there.
    assert!(summary.get("k").is_none() && summary.get("omega_evaluations").is_none());
}

#[test]
fn segments_and_an_adaptive_degree_show_in_the_summary() {
    let folder = empty_folder("direct_pieces");
    let arguments = "solve pendulum_1_swingup --degree 7 --segments 2 --degree-tolerance 0.05 --verbose";
    let run = aghf(&folder, &arguments.split_whitespace().collect::<Vec<_>>());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for words in ["2 segments of degree 9", "effort by degree", "converged to 0.05"] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    let summary = json_file(&folder.join("out/pendulum_1_swingup/summary.json"));
    assert_eq!(
        (&summary["degree"], &summary["segments"], &summary["unknowns"]),
        (&json!(9), &json!(2), &json!(2 * 8 - 2))
    );
    assert_eq!(summary["adapted"]["degrees"], json!([7, 9]));
    assert_eq!(summary["adapted"]["converged"], json!(true));
    assert!(summary["replay_error_inf"].as_f64().is_some_and(|x| x > 0.0));
}

#[test]
fn a_scenario_file_is_solved_under_its_own_name() {
    let folder = empty_folder("file");
    std::fs::create_dir(folder.join("tasks")).expect("writable");
    let robots = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("robots/pendulum_1");
    std::fs::copy(robots.join("pendulum_1.urdf"), folder.join("tasks/mine.urdf")).expect("writable");
    let mut scenario = json_file(&robots.join("pendulum_1_swingup.json"));
    scenario["robot"] = json!("mine.urdf");
    std::fs::write(folder.join("tasks/lift.json"), scenario.to_string()).expect("writable");
    let run = aghf(&folder, &["solve", "tasks/lift.json", "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let summary = json_file(&folder.join("out/lift/summary.json"));
    assert_eq!((&summary["scenario"], &summary["robot"]), (&json!("lift"), &json!("mine.urdf")));
}

/// A flow that misses the goal.
pub const MISSING: &[&str] = &["solve", "pendulum_5_swingup", "--method", "flow", "--k", "1e5", "--s-max", "1"];

#[test]
fn a_solve_that_fails_writes_its_files_and_exits_with_3() {
    let folder = empty_folder("failed");
    let run = aghf(&folder, MISSING);
    assert_eq!(run.code, Some(3), "{}", run.stderr);
    let words: Vec<_> = run.stdout.lines().filter(|l| l.starts_with(" verdict")).collect();
    assert!(words.iter().any(|l| l.trim_end().ends_with("not valid")), "{}", run.stdout);
    let expected = ["summary.failed.json", "trajectory.failed.csv", "report.failed.html"];
    let expected = expected.map(|f| format!("out/pendulum_5_swingup/{f}"));
    assert_eq!(files(&folder), expected.clone().into());
    let summary = json_file(&folder.join(&expected[0]));
    assert_eq!((&summary["success"], &summary["verdict"]), (&json!(false), &json!("not_valid")));
    let text = std::fs::read_to_string(folder.join(&expected[1])).expect("it is there");
    let (first, table) = text.split_once('\n').expect("it has lines");
    let reason = summary["failure"].as_str().expect("there is a reason");
    assert_eq!(first, format!("# failed: {reason}"));
    assert_eq!(table.lines().count(), 202);
}

/// A horizon that is too short for the limits is refused before any search.
#[test]
fn a_horizon_that_is_too_short_is_bad_input() {
    let folder = empty_folder("too_short");
    let [start, goal] = [0.0, 3.0].map(|q| [q, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0]);
    let at_rest = [0.0; 7];
    let far = json!({
        "robot": "kinova_gen3", "horizon_s": 0.5,
        "q_start": start, "v_start": at_rest,
        "q_goal": goal, "v_goal": at_rest,
    });
    std::fs::write(folder.join("far.json"), far.to_string()).expect("writable");
    assert_bad_input(&folder, &["solve", "far.json"], "aghf: far: horizon_s: ; joint_1; it is 0.5 s");
}

/// Several problems: a motion and a row each, also for one that is refused, and no second solve of any.
#[test]
fn several_problems_have_a_row_and_a_motion_each() {
    let folder = empty_folder("several");
    std::fs::create_dir(folder.join("my problems")).expect("writable");
    let swing = json!({
        "robot": "pendulum_1", "horizon_s": 2.0, "q_start": [0.0], "v_start": [0.0], "q_goal": [0.5], "v_goal": [0.0],
    });
    std::fs::write(folder.join("my problems/swing.json"), swing.to_string()).expect("writable");
    let arguments = ["solve", "my problems", "--starts", "2", "--no-report"];
    let run = aghf(&folder, &arguments);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    assert!(run.stdout.contains("1 of 1 sets solved"), "{}", run.stdout);
    let summary = json_file(&folder.join("out/my problems/swing/summary.json"));
    assert_eq!(summary["provenance"]["options"]["starts"], 2);

    std::fs::write(folder.join("my problems/cut.json"), "{").expect("writable");
    let arguments = ["solve", "my problems", "pendulum_1_swingup", "--no-report", "--samples", "11"];
    let run = aghf(&folder, &arguments);
    assert_eq!(run.code, Some(3), "{}{}", run.stdout, run.stderr);
    assert!(run.stderr.starts_with("cut: refused: my problems/cut.json: "), "{}", run.stderr);
    assert!(run.stdout.contains("2 of 3 sets solved, 1 refused; "), "{}", run.stdout);
    let motion = |name: &str| ["summary.json", "trajectory.csv"].map(|file| format!("{name}/{file}"));
    let table = ["results.csv".to_owned(), "sweep.json".to_owned()];
    let expected = table.into_iter().chain(["pendulum_1_swingup", "swing"].into_iter().flat_map(motion));
    let out = folder.join("out/problems");
    assert_eq!(files(&out), expected.collect());
    assert_eq!(csv_file(&out.join("swing/trajectory.csv")).1.len(), 11);

    // Without the last byte only the last row is solved again.
    let text = std::fs::read_to_string(out.join("results.csv")).expect("it is there");
    std::fs::write(out.join("results.csv"), text.trim_end()).expect("writable");
    std::fs::remove_dir_all(out.join("swing")).expect("it is there");
    let run = aghf(&folder, &[&arguments[..], &["--json"]].concat());
    let rows: Value = serde_json::from_str(&run.stdout).expect("JSON alone");
    let outcomes: Vec<_> = rows.as_array().expect("rows").iter().map(|row| row["outcome"].as_str()).collect();
    assert_eq!((run.code, outcomes), (Some(3), ["refused", "success", "success"].map(Some).to_vec()));
    assert!(!out.join("swing").exists(), "its row was complete");

    assert_bad_input(&folder, &["solve", "my problems", "nowhere.json"], "nowhere.json");
    assert_bad_input(&folder, &["solve", "my problems", "--degree", "99"], "degree[0]: it is 99");
    assert_bad_input(&folder, &["solve", "my problems", "--start", "out"], "--start: it is for one scenario");
    assert_bad_input(&folder, &["solve", "my problems", "--time-limit-s", "-1"], "options: time_limit_s: it is -1");
}
