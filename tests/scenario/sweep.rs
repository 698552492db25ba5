//! Sweep files, rankings and tables of results.

use aghf::experiments::sweep::{
    Row, RowOutcome, Sweep, best, builtin_sweeps, ranking, ranking_of, ranking_table, write_rows,
};
use serde_json::Value;
use std::path::{Path, PathBuf};

const GRID: &str = r#"
scenarios = ["pendulum_2_swingup", "pendulum_3_swingup"]
timeout_s = 600
p = [5, 7]
k = [1e3, 1e5, 1e7]
s_max = [1, 10]
"#;

/// A folder for the files of one test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("sweep")
        .join(test);
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    folder
}

/// Writes a sweep file and loads it.
fn load(test: &str, text: &str) -> aghf::Result<Sweep> {
    let path = folder(test).join("grid.toml");
    std::fs::write(&path, text).expect("the folder is writable");
    Sweep::load(path.to_str().expect("it is text"))
}

/// The table for data frames says what the text does, with numbers as numbers.
#[test]
fn a_json_file_has_what_a_csv_has() {
    let grid = load("json", GRID).expect("good");
    let full = Row {
        outcome: RowOutcome::Success,
        final_error_inf: Some(1e-300),
        open_loop_error_inf: Some(f64::INFINITY),
        control_effort: Some(0.1),
        action: Some(-0.0),
        dynamics_defect: Some(f64::MAX),
        smallest_clearance_m: Some(-0.02),
        steps: Some(3),
        omega_evaluations: Some(4),
        jacobian_evaluations: Some(usize::MAX / 2),
        k_cons: Some(5.0),
        c_cons: Some(6.0),
        ..Row::failed(&grid, &grid.sets[23], "none, \"or\" one", 0.25)
    };
    let rows = [Row::failed(&grid, &grid.sets[0], "no\ntime", 1.0), full];
    assert_eq!(
        rows[0].reason.as_deref(),
        Some("no time"),
        "a row is a line"
    );
    let mut csv = csv::Writer::from_writer(Vec::new());
    rows.iter()
        .for_each(|row| csv.serialize(row).expect("it is flat"));
    let text = csv.into_inner().expect("it is in memory");
    let mut csv = csv::Reader::from_reader(text.as_slice());
    let names = csv.headers().expect("a header").clone();

    let path = folder("json").join("rows.json");
    write_rows(&rows, &path).expect("the folder is writable");
    let text = std::fs::read_to_string(&path).expect("it is there");
    let table: Vec<serde_json::Map<String, Value>> = serde_json::from_str(&text).expect("rows");
    assert_eq!(table.len(), 2);
    for (row, record) in table.iter().zip(csv.records()) {
        let record = record.expect("good");
        assert_eq!(row.len(), names.len());
        for (name, text) in names.iter().zip(&record) {
            match &row[name] {
                Value::Null => assert!(["", "inf"].contains(&text), "{name}: {text}"),
                Value::Number(x) => {
                    assert_eq!(text.parse::<f64>().ok(), x.as_f64(), "{name}");
                }
                Value::String(x) => assert_eq!(text, x, "{name}"),
                other => panic!("{name}: {other:?}"),
            }
        }
    }
}

/// Two scenarios with four sets each: the second is the fastest of those that succeed in both, the third has the least effort,
/// the fourth is faster but fails once, and the first fails twice.
#[test]
fn the_ranking_is_by_success_then_time() {
    let four = GRID
        .replace("p = [5, 7]", "p = [7]")
        .replace("1e3,", "1e3, 1e4,");
    let grid = load("ranking", &four.replace("1, 10", "1")).expect("good");
    let made = [
        (false, 0.1, 1.0),
        (true, 2.0, 50.0),
        (true, 4.0, 10.0),
        (true, 0.5, 5.0),
        (false, 0.1, 1.0),
        (true, 1.0, 60.0),
        (true, 3.0, 20.0),
        (false, 0.5, 5.0),
    ];
    let rows: Vec<Row> = (grid.sets.iter().zip(made))
        .map(|(set, (success, seconds, effort))| Row {
            outcome: if success {
                RowOutcome::Success
            } else {
                RowOutcome::GoalMissed
            },
            reason: None,
            control_effort: Some(effort),
            final_error_inf: Some(effort / 1e4),
            smallest_clearance_m: Some(0.2 - seconds / 10.0),
            ..Row::failed(&grid, set, "", seconds)
        })
        .collect();
    let ranked = ranking(&grid, &rows);
    let of = |scope: &str| {
        ranked
            .iter()
            .filter(|r| r.scenario == scope)
            .collect::<Vec<_>>()
    };
    let all = of("all");
    assert_eq!(
        all.iter().map(|r| r.k).collect::<Vec<_>>(),
        [1e4, 1e5, 1e7, 1e3]
    );
    assert_eq!(
        all.iter().map(|r| r.success_rate).collect::<Vec<_>>(),
        [1.0, 1.0, 0.5, 0.0]
    );
    assert_eq!(
        (all[0].solve_seconds, all[0].control_effort),
        (Some(1.5), Some(55.0))
    );
    assert_eq!(
        (all[0].final_error_inf, all[0].action),
        (Some(60.0 / 1e4), None)
    );
    assert_eq!(
        (all[2].solve_seconds, all[3].solve_seconds),
        (Some(0.5), None)
    );
    assert_eq!(
        (all[0].smallest_clearance_m, all[3].smallest_clearance_m),
        (Some(0.0), None),
        "the smallest of those that succeed"
    );
    let one = of("pendulum_2_swingup");
    assert_eq!(
        one.iter().map(|r| r.k).collect::<Vec<_>>(),
        [1e7, 1e4, 1e5, 1e3]
    );
    // The same for a part of the scenarios, and of a table of which no other part is there.
    let three: Vec<f64> = ranking_of(&grid, &rows[4..], "pendulum_3")
        .iter()
        .map(|r| r.k)
        .collect();
    assert_eq!(three, [1e4, 1e5, 1e3, 1e7]);
    let all: Vec<_> = all.into_iter().cloned().collect();
    let [fastest, least] = best(&all).expect("some succeed");
    assert_eq!((fastest.k, least.k), (1e4, 1e5));
    assert_eq!(best(&all[3..]), None, "none succeeds");
    let table = ranking_table(&ranked);
    let lines: Vec<Vec<_>> = table
        .lines()
        .map(|l| l.split_whitespace().collect())
        .collect();
    assert_eq!(lines[1][..6], ["all", "time", "100", "%", "7", "1e4"]);
    assert_eq!(lines[2][..6], ["all", "effort", "100", "%", "7", "1e5"]);
    assert_eq!(lines[2].last(), Some(&"-0.2000"), "the clearance: {table}");
    assert_eq!(lines.len(), 7, "{table}");
}

#[test]
fn bad_sweep_files_are_refused_by_name_and_key() {
    for (from, to, words) in [
        (
            "timeout_s",
            "timeout",
            "grid.toml: timeout: ; unknown field `timeout`",
        ),
        ("p = [5, 7]", "", "grid.toml: sweep: ; missing field `p`"),
        ("p = [5, 7]", "p = [5, 7", "grid.toml: line 5: "),
        ("p = [5, 7]", "p = [5, 7.5]", "grid.toml: p[1]: ; 7.5"),
        (
            "p = [5, 7]",
            "p = [5, 1]",
            "grid.toml: p[1]: it is 1, at least 2",
        ),
        ("p = [5, 7]", "p = []", "grid.toml: p: it is an empty list"),
        (
            "p = [5, 7]",
            "p = [5, 7, 5]",
            "grid.toml: p[2]: the value is there already",
        ),
        (
            "1, 10",
            "1, 1.0",
            "grid.toml: s_max[1]: the value is there already",
        ),
        ("1e3", "-1e3", "grid.toml: k[0]: it is -1000, a positive"),
        ("1e3", "nan", "grid.toml: k[0]: it is NaN, a positive"),
        ("1e3", "\"much\"", "grid.toml: k[0]: ; much"),
        ("600", "0", "grid.toml: timeout_s: it is 0, a positive"),
        ("600", "1e300", "grid.toml: timeout_s: it is 1"),
        ("600", "600\nname = \"../up\"", "grid.toml: name: '../up'"),
        (
            "600",
            "600\nmethod = \"magic\"",
            "grid.toml: method: ; unknown field `method`",
        ),
        (
            "600",
            "600\nguess = [\"line-state\", \"circle\"]",
            "grid.toml: guess[1]: ; circle",
        ),
        (
            "600",
            "600\nk_cons = [1e5]",
            "grid.toml: scenarios[0]: k_cons and c_cons: 'pendulum_2_swingup' has no constraints",
        ),
        ("600", "600\nc_cons = [0]", "grid.toml: c_cons[0]: it is 0"),
        (
            "\"pendulum_2_swingup\"",
            "\"pendulum_x*\"",
            "grid.toml: scenarios[0]: no built-in scenario matches",
        ),
        (
            "\"pendulum_2_swingup\"",
            "\"no.json\"",
            "grid.toml: scenarios[0]: ; no.json; neither",
        ),
        (
            "\"pendulum_2_swingup\"",
            "\"pendulum_3*\"",
            "grid.toml: scenarios[1]: 'pendulum_3_swingup' is there",
        ),
    ] {
        assert!(GRID.contains(from), "{from}");
        let error = load("bad", &GRID.replace(from, to)).expect_err(words);
        let error = error.to_string();
        let all = words.split("; ").all(|word| error.contains(word));
        assert!(all, "{error}; want {words}");
    }
    let error = Sweep::load("table_99")
        .expect_err("there is none")
        .to_string();
    assert!(
        error.starts_with("table_99: sweep: there is neither"),
        "{error}"
    );
}

#[test]
fn the_tables_of_the_paper_are_built_in() {
    let tables = [
        ("table_09_pendulums", 5, 7 * 8 * 10),
        ("table_10_kinova", 5, 7 * 7 * 17),
        ("table_11_digit", 2, 6 * 8 * 17),
        ("table_12_kinova_obstacles", 5, 7 * 6 * 9 * 6 * 3),
        ("table_13_digit_obstacles", 2, 7 * 6 * 9 * 6 * 3),
        ("table_09_quick", 5, 12),
        ("table_10_quick", 5, 12),
    ];
    assert!(builtin_sweeps().eq(tables.iter().map(|t| t.0)));
    for (name, scenarios, sets) in tables {
        let sweep = Sweep::load(name).expect("built in");
        assert_eq!(sweep.scenarios.len(), scenarios, "{name}");
        assert_eq!(sweep.sets_a_scenario(), sets, "{name}");
        assert_eq!(sweep.sets.len(), scenarios * sets);
    }
}
