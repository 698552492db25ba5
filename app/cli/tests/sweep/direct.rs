//! Sweeps of the direct method: what their sets are, how they are ranked, and what is refused.

use crate::files::{FULL, folder, load};
use aghf::direct::PlannedStarts;
use aghf_cli::sweep::{
    ParameterSet, Ranked, Results, Row, RowOutcome, Shard, Sweep, best, merge, ranking, ranking_table, run, shard_files,
};
use aghf_scenario::{DirectOptions, Enforced, Method, Objective, ObjectiveWeights, PerJoint, Solve, Units};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Mutex;

/// The rows of sets of a sweep, in order.
fn solved(sweep: &Sweep, sets: &[ParameterSet]) -> Vec<Row> {
    let rows = Mutex::new(Vec::new());
    let done = |row| {
        rows.lock().expect("no panic").push(row);
        Ok(())
    };
    run(sweep, sets, None, &done).expect("good input");
    let mut rows = rows.into_inner().expect("no panic");
    rows.sort_by_key(|row: &Row| row.set);
    rows
}

#[test]
fn a_grid_has_every_combination_with_seeds_slowest() {
    let sweep = load("combinations", FULL).expect("good");
    assert_eq!((sweep.method(), sweep.sets.len()), (Method::Direct, 256));
    let points: Vec<_> = sweep.sets.iter().map(|s| sweep.parameters(s)).collect();
    let first = json!({
        "seed": 7, "degree": 9, "segments": 1, "starts": 1, "tolerance": 1e-6, "planned_starts": "later",
        "objective.units": "si", "objective.effort": 0, "objective.velocity": 0.5, "objective.acceleration": 0.1,
        "enforced_limits.position": true, "enforced_limits.velocity": true, "enforced_limits.torque": false
    });
    let with = |changes: Value| {
        let mut point = first.as_object().expect("one").clone();
        point.extend(changes.as_object().expect("one").clone());
        point
    };
    let last = with(json!({
        "seed": 8, "degree": 16, "segments": 2, "starts": 3, "objective.effort": 1, "objective.acceleration": 2,
        "enforced_limits.velocity": 0.5, "enforced_limits.torque": 1.0
    }));
    assert_eq!((&points[0], &points[255]), (&with(json!({})), &last));
    let second = with(json!({ "enforced_limits.torque": 1.0 }));
    assert_eq!(points[1], second, "the last list runs fastest");
    assert!(points[..128].iter().all(|p| p["seed"] == 7));
    for (i, p) in points.iter().enumerate() {
        assert!(!points[..i].contains(p), "set {i} is there twice");
    }

    // What a set asks for is what is solved.
    let set = &sweep.sets[255];
    let asked = DirectOptions {
        degree: Some(16),
        segments: Some(2),
        starts: Some(3),
        tolerance: Some(1e-6),
        seed: Some(8),
        planned_starts: Some(PlannedStarts::Later),
        // Sets share the cores.
        threads: Some(1),
        ..DirectOptions::default()
    };
    assert_eq!(sweep.options(set).expect("good"), asked.into());
    let scenario = sweep.scenario(set).expect("good");
    let [effort, velocity, acceleration] = [1.0, 0.5, 2.0].map(PerJoint::Same);
    let weights = ObjectiveWeights { units: Units::Si, effort, velocity, acceleration, ..ObjectiveWeights::default() };
    assert_eq!(scenario.file.objective, Objective::Weights(weights));
    let limits = &scenario.file.enforced_limits;
    let share = |share| Enforced::Share { share, joints: None };
    assert_eq!([&limits.position, &limits.velocity, &limits.torque], [&share(1.0), &share(0.5), &share(1.0)]);
    let torque = &sweep.scenario(&sweep.sets[0]).expect("good").file.enforced_limits.torque;
    assert_eq!(torque, &Enforced::No);
}

/// Without lists there is one set for each scenario, which is solved as it is.
#[test]
fn what_has_no_list_is_as_the_scenario_and_the_method_have_it() {
    let text = "method = \"direct\"\nscenarios = [\"pendulum_2_swingup\", \"limits_0*\"]\ntime_limit_s = 600";
    let sweep = load("defaults", text).expect("good");
    assert_eq!((sweep.problems.len(), sweep.sets.len()), (10, 10));
    for set in &sweep.sets {
        assert!(sweep.parameters(set).is_empty());
        let loaded = sweep.problems[set.problem].scenario.as_ref().expect("good");
        assert_eq!(sweep.scenario(set).expect("good").file, loaded.file);
    }
    let [row] = &solved(&sweep, &sweep.sets[..1])[..] else {
        panic!("one set");
    };
    let scenario = sweep.scenarios().next().expect("one");
    let alone = Solve::new(scenario).run().expect("good");
    assert!(row.outcome == RowOutcome::Success && alone.summary.success);
    let effort = row.result("control_effort").expect("a number");
    assert_eq!(effort, alone.summary.control_effort);
    // The quadratures agree to 1e-3.
    let cost = row.result("cost").expect("a number");
    assert!((cost - effort).abs() < 2e-3 * effort, "the cost is the effort");
    assert_eq!(row.result("starts_tried"), Some(32.0));
    assert_eq!(row.result("horizon_s"), Some(2.0));
    assert!(row.result("iterations") > Some(0.0) && row.result("minima") > Some(0.0));
}

/// Running cost and limits are what differs, so the motions do.
#[test]
fn costs_and_limits_of_a_set_are_those_of_its_motion() {
    let text = r#"
method = "direct"
scenarios = ["limits_01"]
time_limit_s = 600
degree = [9]
objective.acceleration = [0.1, 10]
enforced_limits.velocity = [true, 0.9, 0.01]
enforced_limits.position = [false]
"#;
    let sweep = load("costs", text).expect("good");
    let rows = solved(&sweep, &sweep.sets);
    assert_eq!(rows.len(), 6);
    let efforts: Vec<_> = rows.iter().map(|r| r.result("control_effort")).collect();
    for (i, row) in rows.iter().enumerate() {
        if i % 3 == 2 {
            // At a hundredth of the velocity the goal is out of reach, which is no error of the sweep.
            assert_eq!((row.outcome, row.result("cost")), (RowOutcome::Refused, None));
            let reason = row.reason.as_deref().expect("a reason");
            assert!(reason.contains("horizon_s"), "{reason}");
            continue;
        }
        assert_eq!(row.outcome, RowOutcome::Success, "{row:?}");
        assert!(row.result("cost") > row.result("control_effort"), "{row:?}");
    }
    assert!(efforts[0] < efforts[1], "less velocity takes more effort");
    assert!(efforts[0] < efforts[3], "so does less acceleration");
}

/// A search is stopped where it is, though it has many starts left, and tries no more than it was asked for while there
/// is time.
#[test]
fn a_set_is_stopped_at_its_time() {
    let text = |starts, timeout| {
        format!(
            "method = \"direct\"\nscenarios = [\"kinova_free_01\"]\ntime_limit_s = {timeout}\ndegree = [{}]\n\
            starts = [{starts}]",
            if starts == 1 { 6 } else { 64 }
        )
    };
    let sweep = load("late", &text(20_000, 0.3)).expect("good");
    let [row] = &solved(&sweep, &sweep.sets)[..] else {
        panic!("one set");
    };
    assert_eq!((row.outcome, row.result("cost")), (RowOutcome::TimeLimit, None));
    assert!(row.solve_seconds < 100.0, "it would take far longer: {row:?}");
    let sweep = load("late", &text(1, 3600.0)).expect("good");
    let [row] = &solved(&sweep, &sweep.sets)[..] else {
        panic!("one set");
    };
    let tried = row.result("starts_tried");
    assert_eq!((row.outcome, tried), (RowOutcome::Success, Some(1.0)));
}

/// Three seeds of two sets in two scenarios: seeds are repetitions, of which the median counts.
#[test]
fn the_ranking_takes_seeds_together_and_goes_by_the_median() {
    let text = r#"
method = "direct"
scenarios = ["pendulum_1_swingup", "pendulum_2_swingup"]
time_limit_s = 600
degree = [9, 16]
seed = [1, 2, 3]
"#;
    let sweep = load("direct_ranking", text).expect("good");
    let row = |set: usize| {
        let (scenario, seed, degree) = (set / 6, set / 2 % 3, set % 2);
        // The second degree is slower but for one long solve of the first, and fails once in the second scenario.
        let seconds = match (degree, seed) {
            (0, 2) => 100.0,
            (0, _) => 1.0,
            _ => 2.0,
        };
        let mut failed = Row::failed(&sweep, &sweep.sets[set], "made", seconds);
        if (scenario, degree, seed) == (1, 1, 1) {
            return failed;
        }
        let effort = if degree == 0 { 4.0 } else { 3.0 };
        failed.results["control_effort"] = json!(effort);
        failed.outcome = RowOutcome::Success;
        failed
    };
    let rows: Vec<Row> = (0..12).map(row).collect();
    let ranked = ranking(&sweep, &rows);
    assert_eq!(ranked.len(), 6, "two sets in all and in each scenario");
    let of = |scope: &str| -> Vec<Ranked> {
        let own = ranked.iter().filter(|r| r.scenario == scope);
        own.cloned().collect()
    };
    let all = of("all");
    let degrees: Vec<_> = all.iter().map(|r| &r.parameters["degree"]).collect();
    assert_eq!(degrees, [9, 16], "by success");
    assert_eq!((all[0].solves, all[0].success_rate), (6, 1.0));
    assert_eq!(all[1].success_rate, 5.0 / 6.0);
    assert!(!all[0].parameters.contains_key("seed"));
    let first = of("pendulum_1_swingup");
    assert_eq!((first[0].median_seconds, first[0].solve_seconds), (Some(1.0), Some(34.0)));
    assert_eq!(first[0].parameters["degree"], 9, "by the median");
    let [fastest, least] = best(&first).expect("some succeed");
    assert_eq!([fastest, least].map(|r| r.result("control_effort")), [Some(4.0), Some(3.0)]);

    let table = ranking_table(&ranked);
    let lines: Vec<Vec<_>> = (table.lines()).map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(lines[0][..5], ["scenario", "best", "by", "success", "degree"]);
    assert_eq!(lines[1][..5], ["all", "time", "100", "%", "9"]);
    assert!(!table.contains("segments"), "there is no list of them");
}

/// The same rows come from shards, and from any number of threads.
#[test]
fn shards_come_to_the_same_rows_and_another_option_is_another_sweep() {
    let text = r#"
method = "direct"
scenarios = ["pendulum_1_swingup", "pendulum_2_swingup"]
time_limit_s = 600
degree = [6, 9]
starts = [1, 2]
"#;
    let sweep = load("shards", text).expect("good");
    let whole = solved(&sweep, &sweep.sets);
    let out = folder("shards").join("out");
    if out.exists() {
        std::fs::remove_dir_all(&out).expect("it is ours");
    }
    for index in 1..=3 {
        let shard = Shard { index, count: 3 };
        let results = Results::open(&sweep, shard, &out).expect("free");
        run(&sweep, &results.missing(), Some(1), &|row| results.append(row)).expect("good");
        results.finish().expect("all are there");
    }
    let files = shard_files(&out).expect("it is there");
    let (joined, _) = merge(&sweep, &files, &out).expect("all");
    assert_eq!(joined.len(), whole.len());
    for (one, other) in joined.iter().zip(&whole) {
        assert!(one.agrees(other), "{one:?}\n{other:?}");
    }

    for (from, to, key) in [
        ("degree = [6, 9]", "degree = [6, 10]", "grid.degree.1"),
        ("starts = [1, 2]", "starts = [1]", "grid.starts"),
        ("starts = [1, 2]", "starts = [1, 2]\ntolerance = [1e-8]", "grid.tolerance"),
        ("600", "601", "time_limit_s"),
        ("starts = [1, 2]", "starts = [1, 2]\nobjective.velocity = [0.1]", "grid.objective.velocity"),
        ("starts = [1, 2]", "starts = [1, 2]\nenforced_limits.torque = [true]", "grid.enforced_limits.torque"),
        ("method = \"direct\"", "method = \"flow\"", "method"),
    ] {
        let mut other = text.replace(from, to);
        if other.contains("flow") {
            other = other.replace("starts = [1, 2]\n", "");
        }
        let other = load("shards", &other).expect(key);
        let error = Results::open(&other, Shard::WHOLE, &out).expect_err(key);
        let error = error.to_string();
        let words = format!("sweep.json: {key}");
        assert!(error.contains(&words), "{error}; want {words}");
    }
}

/// A generated scenario is for the robot of the sweep, whose text is what counts, not where it is.
#[test]
fn a_robot_of_generated_scenarios_is_found_beside_the_sweep() {
    let here = folder("robot");
    let robots = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("robots");
    let urdf = robots.join("kinova_gen3/kinova_gen3.urdf");
    std::fs::copy(urdf, here.join("arm.urdf")).expect("writable");
    let text = r#"
method = "direct"
scenarios = ["limits_01"]
robot = "arm.urdf"
time_limit_s = 600
"#;
    let sweep = load("robot", text).expect("good");
    assert_eq!(sweep.problems[0].name, "limits_01");
    assert_eq!(sweep.scenarios().next().expect("one").file.robot, "arm.urdf");
    let moved = here.join("elsewhere");
    std::fs::create_dir_all(&moved).expect("writable");
    for name in ["grid.toml", "arm.urdf"] {
        std::fs::copy(here.join(name), moved.join(name)).expect("writable");
    }
    let again = Sweep::load(moved.join("grid.toml").to_str().expect("text")).expect("good");
    assert_eq!(sweep.identity(), again.identity());
    let text = std::fs::read_to_string(here.join("arm.urdf")).expect("it is there");
    let heavier = text.replacen("<link", "<!-- another --><link", 1);
    std::fs::write(moved.join("arm.urdf"), heavier).expect("writable");
    let again = Sweep::load(moved.join("grid.toml").to_str().expect("text")).expect("good");
    assert_ne!(sweep.identity(), again.identity());
}
