//! Sweeps of the relaxation: what their sets are, how they are ranked, and what is refused.

use crate::files::{FULL, folder, load};
use aghf::relax::PlannedStarts;
use aghf_cli::sweep::{
    ParameterSet, Parameters, Ranked, RelaxPoint, Results, Row, RowOutcome, Shard, Sweep, Work,
    best, merge, ranking, ranking_table, run, shard_files,
};
use aghf_scenario::{Enforced, Method, PerJoint, SolveOptions, solve};
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

fn point(parameters: &Parameters) -> RelaxPoint {
    *parameters.relax().expect("of the relaxation")
}

#[test]
fn a_grid_has_every_combination_with_seeds_slowest() {
    let sweep = load("combinations", FULL).expect("good");
    assert_eq!((sweep.method(), sweep.sets.len()), (Method::Relax, 256));
    let points: Vec<RelaxPoint> = sweep.sets.iter().map(|s| point(&s.parameters)).collect();
    let first = RelaxPoint {
        degree: Some(9),
        segments: Some(1),
        starts: Some(1),
        tolerance: Some(1e-6),
        seed: Some(7),
        planned_starts: Some(PlannedStarts::Later),
        cost_torque: Some(0.0),
        cost_velocity: Some(0.5),
        cost_acceleration: Some(0.1),
        limit_position: Some(1.0),
        limit_velocity: Some(1.0),
        limit_torque: Some(0.0),
    };
    let last = RelaxPoint {
        degree: Some(16),
        segments: Some(2),
        starts: Some(3),
        seed: Some(8),
        cost_torque: Some(1.0),
        cost_acceleration: Some(2.0),
        limit_velocity: Some(0.5),
        limit_torque: Some(1.0),
        ..first
    };
    assert_eq!((points[0], points[255]), (first, last));
    let second = RelaxPoint {
        limit_torque: Some(1.0),
        ..first
    };
    assert_eq!(points[1], second, "the last list runs fastest");
    assert!(points[..128].iter().all(|p| p.seed == Some(7)));
    for (i, p) in points.iter().enumerate() {
        assert!(!points[..i].contains(p), "set {i} is there twice");
    }

    // What a set asks for is what is solved.
    let set = &sweep.sets[255];
    let options = sweep.options(&set.parameters);
    assert_eq!(options.method, Method::Relax);
    assert_eq!((options.degree, options.segments), (Some(16), Some(2)));
    assert_eq!(
        (options.num_starts, options.tolerance),
        (Some(3), Some(1e-6))
    );
    assert_eq!(options.seed, Some(8));
    assert_eq!(options.threads, Some(1), "sets share the cores");
    let scenario = sweep.scenario(set);
    let cost = scenario.file.running_cost.as_ref().expect("a cost");
    let weights = [&cost.torque, &cost.velocity, &cost.acceleration];
    assert_eq!(weights, [1.0, 0.5, 2.0].map(PerJoint::Same).each_ref());
    let limits = &scenario.file.enforced_limits;
    let share = |share| Enforced::Share {
        share,
        joints: None,
    };
    assert_eq!(
        [&limits.position, &limits.velocity, &limits.torque],
        [&share(1.0), &share(0.5), &share(1.0)]
    );
    let torque = &sweep.scenario(&sweep.sets[0]).file.enforced_limits.torque;
    assert_eq!(torque, &Enforced::No);
}

/// Without lists there is one set for each scenario, which is solved as it is.
#[test]
fn what_has_no_list_is_as_the_scenario_and_the_method_have_it() {
    let text =
        "method = \"relax\"\nscenarios = [\"pendulum_2_swingup\", \"limits_0*\"]\ntimeout_s = 600";
    let sweep = load("defaults", text).expect("good");
    assert_eq!((sweep.scenarios.len(), sweep.sets.len()), (10, 10));
    for set in &sweep.sets {
        assert_eq!(point(&set.parameters), RelaxPoint::default());
        let file = &sweep.scenarios[set.scenario].file;
        assert_eq!(&sweep.scenario(set).file, file);
    }
    let [row] = &solved(&sweep, &sweep.sets[..1])[..] else {
        panic!("one set");
    };
    let scenario = &sweep.scenarios[0];
    let alone = solve(scenario, &SolveOptions::default(), &mut |_| {}).expect("good");
    assert!(row.outcome == RowOutcome::Success && alone.summary.success);
    assert_eq!(row.control_effort, Some(alone.summary.control_effort));
    assert_eq!(row.minimised, row.control_effort, "the cost is the effort");
    let (Work::Relax(work), starts) = (row.work, 16) else {
        panic!("{row:?}");
    };
    assert_eq!(
        (work.starts_tried, work.horizon_s),
        (Some(starts), Some(2.0))
    );
    assert!(work.iterations > Some(0) && work.minima > Some(0));
}

/// Running cost and limits are what differs, so the motions do.
#[test]
fn costs_and_limits_of_a_set_are_those_of_its_motion() {
    let text = r#"
method = "relax"
scenarios = ["limits_01"]
timeout_s = 600
degree = [9]
running_cost.acceleration = [0.1, 10]
enforced_limits.velocity = [true, 0.9, 0.01]
enforced_limits.position = [false]
"#;
    let sweep = load("costs", text).expect("good");
    let rows = solved(&sweep, &sweep.sets);
    assert_eq!(rows.len(), 6);
    let efforts: Vec<_> = rows.iter().map(|r| r.control_effort).collect();
    for (i, row) in rows.iter().enumerate() {
        if i % 3 == 2 {
            // At a hundredth of the velocity the goal is out of reach, which is no error of the sweep.
            assert_eq!((row.outcome, row.minimised), (RowOutcome::Failed, None));
            let reason = row.reason.as_deref().expect("a reason");
            assert!(reason.contains("horizon_s"), "{reason}");
            continue;
        }
        assert_eq!(row.outcome, RowOutcome::Success, "{row:?}");
        assert!(row.minimised > row.control_effort, "{row:?}");
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
            "method = \"relax\"\nscenarios = [\"kinova_free_01\"]\ntimeout_s = {timeout}\ndegree = [{}]\nstarts = [{starts}]",
            if starts == 1 { 6 } else { 64 }
        )
    };
    let sweep = load("late", &text(20_000, 0.3)).expect("good");
    let [row] = &solved(&sweep, &sweep.sets)[..] else {
        panic!("one set");
    };
    assert_eq!((row.outcome, row.minimised), (RowOutcome::TimeLimit, None));
    assert!(
        row.solve_seconds < 100.0,
        "it would take far longer: {row:?}"
    );
    let sweep = load("late", &text(1, 3600.0)).expect("good");
    let [row] = &solved(&sweep, &sweep.sets)[..] else {
        panic!("one set");
    };
    let Work::Relax(work) = row.work else {
        panic!("{row:?}");
    };
    assert_eq!(
        (row.outcome, work.starts_tried),
        (RowOutcome::Success, Some(1))
    );
}

/// Three seeds of two sets in two scenarios: seeds are repetitions, of which the median counts.
#[test]
fn the_ranking_takes_seeds_together_and_goes_by_the_median() {
    let text = r#"
method = "relax"
scenarios = ["pendulum_1_swingup", "pendulum_2_swingup"]
timeout_s = 600
degree = [9, 16]
seed = [1, 2, 3]
"#;
    let sweep = load("relax_ranking", text).expect("good");
    let row = |set: usize| {
        let (scenario, seed, degree) = (set / 6, set / 2 % 3, set % 2);
        // The second degree is slower but for one long solve of the first, and fails once in the second scenario.
        let seconds = match (degree, seed) {
            (0, 2) => 100.0,
            (0, _) => 1.0,
            _ => 2.0,
        };
        let failed = Row::failed(&sweep, &sweep.sets[set], "made", seconds);
        if (scenario, degree, seed) == (1, 1, 1) {
            return failed;
        }
        Row {
            outcome: RowOutcome::Success,
            control_effort: Some(if degree == 0 { 4.0 } else { 3.0 }),
            minimised: Some(5.0),
            ..failed
        }
    };
    let rows: Vec<Row> = (0..12).map(row).collect();
    let ranked = ranking(&sweep, &rows);
    assert_eq!(ranked.len(), 6, "two sets in all and in each scenario");
    let of = |scope: &str| -> Vec<Ranked> {
        let own = ranked.iter().filter(|r| r.scenario == scope);
        own.cloned().collect()
    };
    let all = of("all");
    let degrees: Vec<_> = all.iter().map(|r| point(&r.parameters).degree).collect();
    assert_eq!(degrees, [Some(9), Some(16)], "by success");
    assert_eq!((all[0].solves, all[0].success_rate), (6, 1.0));
    assert_eq!(all[1].success_rate, 5.0 / 6.0);
    assert_eq!(point(&all[0].parameters).seed, None);
    let first = of("pendulum_1_swingup");
    assert_eq!(
        (first[0].median_seconds, first[0].solve_seconds),
        (Some(1.0), Some(34.0))
    );
    assert_eq!(point(&first[0].parameters).degree, Some(9), "by the median");
    let [fastest, least] = best(&first).expect("some succeed");
    assert_eq!(
        (fastest.control_effort, least.control_effort),
        (Some(4.0), Some(3.0))
    );

    let table = ranking_table(&ranked);
    let lines: Vec<Vec<_>> = (table.lines())
        .map(|line| line.split_whitespace().collect())
        .collect();
    assert_eq!(
        lines[0][..5],
        ["scenario", "best", "by", "success", "degree"]
    );
    assert_eq!(lines[1][..5], ["all", "time", "100", "%", "9"]);
    assert!(!table.contains("segments"), "there is no list of them");
}

/// The same rows come from shards, and from any number of threads.
#[test]
fn shards_come_to_the_same_rows_and_another_option_is_another_sweep() {
    let text = r#"
method = "relax"
scenarios = ["pendulum_1_swingup", "pendulum_2_swingup"]
timeout_s = 600
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
        run(&sweep, &results.missing(), Some(1), &|row| {
            results.append(row)
        })
        .expect("good");
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
        (
            "starts = [1, 2]",
            "starts = [1, 2]\ntolerance = [1e-8]",
            "grid.tolerance",
        ),
        ("600", "601", "grid.timeout_s"),
        (
            "starts = [1, 2]",
            "starts = [1, 2]\nrunning_cost.velocity = [0.1]",
            "grid.running_cost.velocity",
        ),
        (
            "starts = [1, 2]",
            "starts = [1, 2]\nenforced_limits.torque = [true]",
            "grid.enforced_limits.torque",
        ),
        (
            "method = \"relax\"",
            "method = \"flow\"\nk = [1e3]\ns_max = [1]\np = [6]",
            "grid",
        ),
    ] {
        let mut other = text.replace(from, to);
        if other.contains("flow") {
            other = other.replace("degree = [6, 9]\nstarts = [1, 2]\n", "");
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
method = "relax"
scenarios = ["limits_01"]
robot = "arm.urdf"
timeout_s = 600
"#;
    let sweep = load("robot", text).expect("good");
    assert_eq!(sweep.scenarios[0].name, "limits_01");
    assert_eq!(sweep.scenarios[0].file.robot, "arm.urdf");
    let moved = here.join("elsewhere");
    std::fs::create_dir_all(&moved).expect("writable");
    for name in ["grid.toml", "arm.urdf"] {
        std::fs::copy(here.join(name), moved.join(name)).expect("writable");
    }
    let again = Sweep::load(moved.join("grid.toml").to_str().expect("text")).expect("good");
    assert_eq!(sweep.identity().ok(), again.identity().ok());
    let text = std::fs::read_to_string(here.join("arm.urdf")).expect("it is there");
    let heavier = text.replacen("<link", "<!-- another --><link", 1);
    std::fs::write(moved.join("arm.urdf"), heavier).expect("writable");
    let again = Sweep::load(moved.join("grid.toml").to_str().expect("text")).expect("good");
    assert_ne!(sweep.identity().ok(), again.identity().ok());
}
