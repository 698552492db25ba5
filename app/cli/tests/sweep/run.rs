//! Sweep files, rankings and tables of results.

use crate::files::{FULL, GRID, folder, load};
use aghf_cli::output::csv_of;
use aghf_cli::sweep::{
    Ranked, Row, RowOutcome, Sweep, best, builtin_sweeps, ranking, ranking_table, write_ranking, write_rows,
};
use aghf_scenario::{DirectOptions, Method};
use serde_json::{Value, json};

/// A row with a value in every column but one.
fn full(grid: &Sweep, set: usize) -> Row {
    let mut row = Row::failed(grid, &grid.sets[set], "none, \"or\" one", 0.25);
    for (i, value) in row.results.values_mut().enumerate() {
        *value = [json!(1e-300), json!(-0.0), json!(3), json!(f64::MAX)][i % 4].clone();
    }
    row.results["open_loop_error_inf"] = json!(f64::INFINITY);
    row
}

/// The table for data frames says what the text does, with numbers as numbers; every column of a full row has a value,
/// and the names of columns are the same wherever they are.
#[test]
fn a_json_file_has_what_a_csv_has() {
    let flow = load(
        "json",
        &GRID
            .replace("degree =", "k_cons = [5]\nc_cons = [6]\ndegree =")
            .replace("pendulum_2_swingup", "kinova_obstacles_01")
            .replace(", \"pendulum_3_swingup\"", ""),
    );
    let direct = load("json", FULL);
    for (grid, columns) in [(flow, 19), (direct, 31)] {
        let grid = grid.expect("good");
        let full = full(&grid, 1);
        let rows = [Row::failed(&grid, &grid.sets[0], "no\ntime", 1.0), full];
        let reason = rows[0].reason.as_deref();
        assert_eq!(reason, Some("no time"), "a row is a line");
        let text = csv_of(&rows, true).expect("it is flat");
        let mut csv = csv::Reader::from_reader(text.as_slice());
        let names = csv.headers().expect("a header").clone();
        assert_eq!(names.len(), columns);

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
                    Value::Null => assert_eq!(text, "", "{name}"),
                    Value::Number(x) => {
                        assert_eq!(text.parse::<f64>().ok(), x.as_f64(), "{name}");
                    }
                    Value::String(x) => assert_eq!(text, x, "{name}"),
                    Value::Bool(x) => assert_eq!(text, x.to_string(), "{name}"),
                    other => panic!("{name}: {other:?}"),
                }
            }
        }
        let empty = |name: &&str| table[1][*name].is_null();
        let missing: Vec<_> = names.iter().filter(empty).collect();
        assert_eq!(missing, ["open_loop_error_inf"], "that is infinite");
        // A ranking has the columns of the parameters under the same names.
        let path = folder("json").join("ranking.csv");
        write_ranking(&ranking(&grid, &rows[..1]), &path).expect("the folder is writable");
        let mut ranked = csv::Reader::from_path(&path).expect("it is there");
        let ranked = ranked.headers().expect("a header").clone();
        let end = names.iter().position(|name| name == "outcome");
        let end = end.expect("a column");
        let parameters = names.iter().skip(2).take(end - 2);
        let parameters = parameters.filter(|name| *name != "seed");
        assert!(parameters.eq(ranked.iter().skip(1).take_while(|name| *name != "solves")));
    }
}

/// A ranking of two scenarios with four sets each: the second is the fastest of those that succeed in both, the third
/// has the least effort, the fourth is faster but fails once, and the first fails twice.
fn ranked(test: &str) -> Vec<Ranked> {
    let four = GRID.replace("degree = [5, 7]", "degree = [7]").replace("1e3,", "1e3, 1e4,");
    let grid = load(test, &four.replace("1, 10", "1")).expect("good");
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
        .map(|(set, (success, seconds, effort))| {
            let mut row = Row::failed(&grid, set, "", seconds);
            row.outcome = if success { RowOutcome::Success } else { RowOutcome::GoalMissed };
            row.results["control_effort"] = json!(effort);
            row.results["final_error_inf"] = json!(effort / 1e4);
            row.results["smallest_clearance_m"] = json!(0.2 - seconds / 10.0);
            row
        })
        .collect();
    ranking(&grid, &rows)
}

/// The penalty of a set, which tells the four apart.
fn k(r: &Ranked) -> f64 {
    r.parameters["k"].as_f64().expect("a number")
}

#[test]
fn the_ranking_is_by_success_then_time() {
    let ranked = ranked("ranking");
    let of = |scope: &str| {
        let of_scope = ranked.iter().filter(|r| r.scenario == scope);
        of_scope.cloned().collect::<Vec<_>>()
    };
    let ks = |of: &[Ranked]| of.iter().map(k).collect::<Vec<_>>();
    let all = of("all");
    assert_eq!(ks(&all), [1e4, 1e5, 1e7, 1e3]);
    assert_eq!(all.iter().map(|r| r.success_rate).collect::<Vec<_>>(), [1.0, 1.0, 0.5, 0.0]);
    assert_eq!((all[0].solve_seconds, all[0].result("control_effort")), (Some(1.5), Some(55.0)));
    assert_eq!((all[0].result("final_error_inf"), all[0].result("action")), (Some(60.0 / 1e4), None));
    assert_eq!((all[2].solve_seconds, all[3].solve_seconds), (Some(0.5), None));
    assert_eq!(
        [0, 3].map(|i: usize| all[i].result("smallest_clearance_m")),
        [Some(0.0), None],
        "the smallest of those that succeed"
    );
    assert_eq!(ks(&of("pendulum_2_swingup")), [1e7, 1e4, 1e5, 1e3]);
    let [fastest, least] = best(&all).expect("some succeed");
    assert_eq!((k(fastest), k(least)), (1e4, 1e5));
    assert_eq!(best(&all[3..]), None, "none succeeds");
}

#[test]
fn the_table_of_a_ranking_has_the_fastest_and_the_least_effort() {
    let table = ranking_table(&ranked("ranking_table"));
    let lines: Vec<Vec<_>> = table.lines().map(|l| l.split_whitespace().collect()).collect();
    assert_eq!(lines[1][..6], ["all", "time", "100", "%", "7", "1e4"]);
    assert_eq!(lines[2][..6], ["all", "effort", "100", "%", "7", "1e5"]);
    assert_eq!(lines[2].last(), Some(&"-0.2000"), "the clearance: {table}");
    assert_eq!(lines.len(), 7, "{table}");
}

#[test]
fn the_tables_of_the_paper_and_some_of_the_direct_method_are_built_in() {
    let tables = [
        ("table_09_pendulums", 5, 7 * 8 * 10),
        ("table_10_kinova", 5, 7 * 7 * 17),
        ("table_11_digit", 2, 6 * 8 * 17),
        ("table_12_kinova_obstacles", 5, 7 * 6 * 9 * 6 * 3),
        ("table_13_digit_obstacles", 2, 7 * 6 * 9 * 6 * 3),
        ("table_09_quick", 5, 12),
        ("table_10_quick", 5, 12),
        ("direct_quick", 5, 6),
        ("direct_limits_quick", 9, 6),
    ];
    assert!(builtin_sweeps().eq(tables.iter().map(|t| t.0)));
    for (name, scenarios, sets) in tables {
        let sweep = Sweep::load(name).expect("built in");
        assert_eq!(sweep.method() == Method::Flow, name.starts_with("table"));
        assert_eq!(sweep.problems.len(), scenarios, "{name}");
        assert_eq!(sweep.sets_a_scenario(), sets, "{name}");
        assert_eq!(sweep.sets.len(), scenarios * sets);
    }
}

/// The identity and the columns have the names of options and of keys of scenarios, in the order of the file.
#[test]
fn the_identity_and_the_columns_have_the_names_of_the_parameters() {
    let identity = |text: &str| load("identity", text).expect("good").identity();
    let of_flow = identity(GRID);
    let grid = of_flow["grid"].as_object().expect("an object");
    assert!(grid.keys().eq(["degree", "k", "s_max"]));
    let named = GRID.replace("600", "600\nname = \"other\"");
    assert_eq!(identity(&named), of_flow);
    assert_eq!(identity(FULL)["method"], "direct");
    let grid = load("identity", GRID).expect("good");
    let row = Row::failed(&grid, &grid.sets[0], "", 0.0);
    let text = String::from_utf8(csv_of([&row], true).expect("it is flat")).expect("text");
    let header = "set,scenario,degree,k,s_max,outcome,reason,final_error_inf,open_loop_error_inf,control_effort,\
         dynamics_defect,smallest_clearance_m,action,steps,omega_evaluations,jacobian_evaluations,solve_seconds";
    assert_eq!(text.lines().next(), Some(header));
}

/// A parameter that is also a key of the summary has one column.
#[test]
fn keys_of_scenarios_and_methods_of_all_kinds_are_swept() {
    let text = "method = \"duals\"\nscenarios = [\"pendulum_1_swingup\"]\ntime_limit_s = 60\nk = [1e4, 1e6]\n\
        feedback.kp = [10, 20]\n";
    let sweep = load("duals", text).expect("good");
    let gains = sweep.sets.iter().map(|set| sweep.scenario(set).expect("good").file.feedback.kp);
    assert!(gains.eq([10.0, 20.0, 10.0, 20.0]));
    let horizons = text.replace("feedback.kp = [10, 20]", "horizon_s = [2, 2.5]").replace("duals", "direct");
    let sweep = load("horizons", &horizons.replace("k = [1e4, 1e6]\n", "")).expect("good");
    let row = Row::failed(&sweep, &sweep.sets[1], "", 0.0);
    assert_eq!(row.parameters["horizon_s"], 2.5);
    assert!(!row.results.contains_key("horizon_s"));
}

/// A folder stands for the scenarios in it, by name, whatever else is there; alone it is a sweep by the direct method
/// as it is.
#[test]
fn a_folder_is_swept_and_stands_for_its_scenarios() {
    let folder = folder("of_a_folder").join("problems");
    std::fs::create_dir_all(&folder).expect("it is writable");
    for name in ["pendulum_3_swingup", "pendulum_2_swingup"] {
        let path = format!("{}/../../robots/{}/{name}.json", env!("CARGO_MANIFEST_DIR"), &name[..10]);
        std::fs::copy(path, folder.join(format!("own_{name}.json"))).expect("both are there");
    }
    std::fs::write(folder.join("notes.txt"), "no scenario").expect("it is writable");
    let names = |sweep: &Sweep| -> Vec<String> { sweep.problems.iter().map(|problem| problem.name.clone()).collect() };
    let sweep = Sweep::load(folder.to_str().expect("it is text")).expect("good");
    let expected = ["own_pendulum_2_swingup", "own_pendulum_3_swingup"];
    assert_eq!(names(&sweep), expected);
    assert_eq!((sweep.name.as_str(), sweep.method()), ("problems", Method::Direct));
    assert_eq!(sweep.sets.len(), 2);
    let usual = DirectOptions { threads: Some(1), ..Default::default() };
    assert_eq!(sweep.options(&sweep.sets[0]).expect("good"), usual.into());

    let grid = "method = \"direct\"\nscenarios = [\"problems\"]\ntime_limit_s = 9\n\
        planned_starts = [\"later\", \"first\"]";
    let sweep = load("of_a_folder", grid).expect("good");
    assert_eq!(names(&sweep), expected);
    let planned = |i: usize| sweep.parameters(&sweep.sets[i])["planned_starts"].clone();
    assert_eq!([0, 1, 2, 3].map(planned), ["later", "first", "later", "first"]);

    let empty = folder.join("empty");
    std::fs::create_dir_all(&empty).expect("it is writable");
    let error = Sweep::load(empty.to_str().expect("it is text")).expect_err("nothing is in it");
    let words = "scenarios[0]: the folder '.' has no scenario";
    assert!(error.to_string().contains(words), "{error}");
}
