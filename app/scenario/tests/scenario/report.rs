//! Scenarios that are built in load, and a solve tells the truth about itself.

use aghf::direct::PlannedStarts;
use aghf::flow::FlowRecord;
use aghf::motion::Interrupt;
use aghf::urdf::builtin_robots;
use aghf_scenario::{
    Details, DirectOptions, FlowDetails, FlowOptions, Method, Record, Scenario, Solve, SolveOptions, SolveReport,
    Verdict, builtin_scenarios,
};
use serde_json::{Map, Value, json};
use std::path::Path;
use std::time::Duration;

#[test]
fn all_that_are_built_in_load_and_fit_their_robots() {
    assert_eq!(builtin_scenarios().count(), 31);
    for name in builtin_scenarios() {
        let scenario = Scenario::load(name).unwrap_or_else(|e| panic!("{e}"));
        let (file, n) = (&scenario.file, scenario.model.dof());
        assert_eq!(scenario.name, name);
        assert!(builtin_robots().any(|robot| robot == file.robot), "{name}: {}", file.robot);
        assert_eq!(scenario.model.name(), file.robot);
        for state in [&file.q_start, &file.v_start, &file.q_goal, &file.v_goal] {
            assert_eq!(state.len(), n, "{name}");
        }
        let problem = scenario.problem().unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(problem.start(), [&file.q_start[..], &file.v_start[..]].concat());
        assert_eq!(problem.goal(), [&file.q_goal[..], &file.v_goal[..]].concat());
        assert_eq!(problem.horizon(), file.horizon_s);
        assert!(file.flow.degree >= 2 && file.success_threshold == 0.05, "{name}");
    }
}

#[test]
fn scenarios_that_do_not_exist() {
    let error = Scenario::load("kinova_free_99").expect_err("there are five").to_string();
    assert!(error.starts_with("kinova_free_99: scenario: "), "{error}");
    assert!(error.contains("neither a file nor a built-in scenario"), "{error}");
    let here = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let error = Scenario::load(here.to_str().expect("it is text")).expect_err("a folder").to_string();
    assert!(error.starts_with(here.to_str().expect("it is text")), "{error}");
}

#[test]
fn the_goal_of_digit_stretch_is_outside_a_limit() {
    let digit = Scenario::load("digit_free_stretch").expect("built in");
    let notes = digit.outside_limits();
    assert!(
        notes.iter().any(|n| n.starts_with("q_goal: joint 'right_tarsus' at 1 is outside [-1.2497, 0.8779]")),
        "{notes:?}"
    );
    assert_eq!(Scenario::load("pendulum_5_swingup").expect("built in").outside_limits(), [""; 0]);
}

fn solved(name: &str, options: impl Into<SolveOptions>) -> SolveReport {
    let scenario = Scenario::load(name).expect("built in");
    Solve::new(&scenario).options(options).run().unwrap_or_else(|e| panic!("{e}"))
}

/// By the flow, with the parameters of the scenario.
fn by_flow() -> FlowOptions {
    FlowOptions::default()
}

fn flow_details(outcome: &SolveReport) -> (&FlowDetails, Vec<FlowRecord>) {
    let Details::Flow(details) = &outcome.summary.details else {
        panic!("it is a flow: {:?}", outcome.summary);
    };
    let records = outcome.history.iter().map(|record| match record {
        Record::Flow(record) => *record,
        Record::Rest(_) | Record::Direct(_) => panic!("it is the published flow"),
    });
    (details, records.collect())
}

#[test]
fn the_summary_of_a_direct_solve_is_consistent() {
    let scenario = Scenario::load("pendulum_2_swingup").expect("built in");
    let mut seen = Vec::new();
    let options = DirectOptions { degree: Some(9), starts: Some(1), ..Default::default() };
    let outcome = Solve::new(&scenario).options(options.clone()).observe(|r| seen.push(*r)).run().expect("it is good");
    let s = &outcome.summary;
    assert!(s.success && s.failure.is_none(), "{s:?}");
    assert_eq!((s.method, s.degree), (Method::Direct, 9));
    assert!(s.final_error_inf.expect("it ended") < s.success_threshold);
    // Velocity and configuration are one polynomial: nothing but rounding is between them.
    assert!(s.dynamics_defect < 1e-10, "{s:?}");
    let Details::Direct(d) = &s.details else {
        panic!("it is a direct solve: {s:?}");
    };
    assert!(d.gradient_norm <= d.tolerance && d.smallest_curvature > 0.0, "{d:?}");
    assert_eq!((seen.len(), d.start_costs.len()), (d.iterations, 1));
    assert_eq!(seen, outcome.history);
    // The quadrature agrees with Simpson's rule to what is asked of it.
    let Some(Record::Direct(last)) = seen.last() else {
        panic!("there are iterations");
    };
    assert!((last.cost - s.control_effort).abs() <= 2e-3 * s.control_effort);
}

#[test]
fn options_of_the_other_method_are_errors() {
    for (method, key, value) in [
        (Method::Direct, "k", json!(1.0)),
        (Method::Direct, "s_max", json!(1.0)),
        (Method::Direct, "guess", json!("line_state")),
        (Method::Direct, "jacobian", json!("dual")),
        (Method::Flow, "starts", json!(2)),
    ] {
        let options = json!({ "method": method, key: value });
        let read = serde_json::from_value::<SolveOptions>(options);
        let error = read.expect_err(key).to_string();
        assert!(error.starts_with(&format!("options: {key}: unknown field")), "{error}");
    }
}

#[test]
fn the_summary_of_a_swing_up_is_consistent() {
    let scenario = Scenario::load("pendulum_1_swingup").expect("built in");
    let mut seen = Vec::new();
    let options = by_flow();
    let outcome = Solve::new(&scenario).options(options.clone()).observe(|r| seen.push(*r)).run().expect("it is good");
    let s = &outcome.summary;
    let (d, history) = flow_details(&outcome);
    assert!(s.success && s.failure.is_none() && s.outside_limits.is_empty(), "{s:?}");
    assert_eq!((s.scenario.as_str(), s.robot.as_str()), ("pendulum_1_swingup", "pendulum_1"));
    assert_eq!((s.degree, d.k, d.s_max, d.tolerance), (9, 1e5, 100.0, 1e-4));
    assert!(s.final_error_inf.expect("it ended") < s.success_threshold, "{s:?}");
    assert!(s.open_loop_error_inf.expect("it ended") > 0.0, "{s:?}");
    assert!(s.control_effort > 0.0 && s.control_effort <= d.action, "{s:?}");
    assert!(s.dynamics_defect > 0.0 && s.dynamics_defect < 0.1, "{s:?}");
    assert!(d.steps > 0 && d.factorisations > 0 && s.solve_seconds > 0.0, "{s:?}");
    let interior = s.degree - 1;
    assert!(d.omega_evaluations >= d.steps * interior, "{s:?}");
    assert_eq!((d.omega_evaluations % interior, d.jacobian_evaluations % interior), (0, 0));

    assert_eq!(seen, outcome.history);
    assert_eq!((history[0].s, history.last().expect("it is long").s), (0.0, d.s_max));
    assert!(history.windows(2).all(|w| w[0].s < w[1].s));
    assert_eq!(Some(history[0].action_at_nodes), d.action_at_nodes_of_guess);
    let last = history.last().expect("it is long").action_at_nodes;
    assert!((last - d.action_at_nodes).abs() <= 1e-9 * last, "{last} {}", d.action_at_nodes);
    assert!(d.action_at_nodes < history[0].action_at_nodes, "the flow goes down");

    let x = outcome.curve.x();
    assert_eq!(x.shape(), (2, s.degree + 1));
    assert_eq!(x.column(0).as_slice(), [scenario.file.q_start[0], 0.0]);
    assert_eq!(x.column(s.degree).as_slice(), [scenario.file.q_goal[0], 0.0]);
}

#[test]
fn a_flow_that_is_cut_short_says_so() {
    let options = FlowOptions { k: Some(1e5), s_max: Some(1.0), ..by_flow() };
    let summary = solved("pendulum_5_swingup", options).summary;
    assert!(!summary.success, "{summary:?}");
    let reached = summary.final_error_inf.is_some_and(|e| e < summary.success_threshold);
    assert!(summary.failure.is_some() || !reached, "{summary:?}");
}

#[test]
fn bad_options_are_errors() {
    type Change = fn(&mut FlowOptions);
    let scenario = Scenario::load("pendulum_1_swingup").expect("built in");
    let cases: [(Change, &str); 8] = [
        (|o| o.degree = Some(0), "degree: it is 0"),
        (|o| o.degree = Some(1), "degree: it is 1 and must be at least 2"),
        (|o| o.k = Some(-1.0), "k: it is -1 and must be a positive number"),
        (|o| o.k = Some(f64::INFINITY), "k: it is inf"),
        (|o| o.s_max = Some(0.0), "s_max: it is 0"),
        (|o| o.s_max = Some(f64::NAN), "s_max: it is NaN"),
        (|o| o.tolerance = Some(f64::NAN), "tolerance: it is NaN"),
        (|o| o.tolerance = Some(-1e-4), "tolerance: it is -0.0001"),
    ];
    for (change, words) in cases {
        let mut options = by_flow();
        change(&mut options);
        let error = Solve::new(&scenario).options(options).run().expect_err(words).to_string();
        assert!(error.contains(words), "{error}; want {words}");
    }
}

/// No solve leaves anything behind for the next one.
#[test]
fn the_same_solve_gives_the_same_bits() {
    let shown = |outcome: &SolveReport| {
        let mut summary = serde_json::to_value(&outcome.summary).expect("numbers");
        summary["solve_seconds"] = Value::Null;
        let bits: Vec<u64> = outcome.curve.x().iter().map(|x| x.to_bits()).collect();
        (summary.to_string(), bits, outcome.history.clone())
    };
    let other = |method| {
        let keys = Map::from_iter([("degree".to_owned(), json!(5))]);
        SolveOptions::from_keys(method, keys).expect("both know it")
    };
    for (name, options) in [
        ("pendulum_2_swingup", by_flow().into()),
        ("kinova_free_03", by_flow().into()),
        ("pendulum_2_swingup", SolveOptions::default()),
    ] {
        let first = shown(&solved(name, options.clone()));
        solved("pendulum_1_swingup", other(options.method()));
        assert_eq!(shown(&solved(name, options)), first, "{name}");
    }
}

/// A motion that keeps the constraints is valid, and optimal if the search converged; what is missing is told.
#[test]
fn a_motion_that_keeps_its_constraints_is_valid() {
    let scenario = json!({
        "robot": "pendulum_2", "horizon_s": 2.0,
        "q_start": [0, 0], "v_start": [0, 0], "q_goal": [1.0, 0.5], "v_goal": [0, 0],
        "obstacles": [{ "shape": { "sphere": { "radius_m": 0.3 } }, "pose": { "position_m": [0.5, 0.0, -1.5] } }],
        "enforced_limits": { "position": false, "velocity": false, "torque": false }
    });
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("planned_first.json");
    std::fs::write(&path, scenario.to_string()).expect("the folder is writable");
    let scenario = Scenario::load(path.to_str().expect("it is text")).expect("it is good");
    let found = |planned, tolerance| {
        let options = DirectOptions {
            planned_starts: Some(planned),
            starts: Some(1),
            tolerance: Some(tolerance),
            ..Default::default()
        };
        let report = Solve::new(&scenario).options(options.clone()).run().expect("valid");
        let summary = report.summary;
        assert!(summary.success && summary.failure.is_none(), "{summary:?}");
        let told = summary.notes.iter().any(|note| note.starts_with("not optimal: "));
        assert_eq!(told, summary.verdict == Verdict::Valid, "{summary:?}");
        summary.verdict
    };
    for planned in [PlannedStarts::First, PlannedStarts::Never] {
        // Rounding alone leaves more of the gradient than the first asks for.
        assert_eq!(found(planned, 1e-30), Verdict::Valid);
        assert_eq!(found(planned, 1e-6), Verdict::Optimal);
    }
}

/// A search that is stopped before its first step knows no gradient norm, and says so.
#[test]
fn the_gradient_norm_of_a_stopped_search_may_be_unknown() {
    let scenario = Scenario::load("pendulum_1_swingup").expect("built in");
    let solve = Solve::new(&scenario).interrupt(Interrupt::after(Duration::ZERO));
    let summary = solve.run().expect("valid").summary;
    let Details::Direct(details) = &summary.details else {
        panic!("it is the direct method");
    };
    assert!(!details.gradient_norm.is_finite());
    let words = summary.failure.iter().chain(&summary.notes);
    assert!(
        words.clone().any(|words| words.contains("the gradient norm is not known")),
        "{:?}",
        words.collect::<Vec<_>>()
    );
}
