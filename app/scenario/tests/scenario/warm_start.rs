//! Starts from the motion of another solve.

use crate::written::{load, solved_once};
use aghf_scenario::{Details, DirectDetails, Method, Scenario, Solve, SolveOptions, SolveReport, Solved, Verdict};
use serde_json::{Value, json};

/// An arm that has to keep its limits, with these.
fn arm(goal: f64, enforced: Value) -> Scenario {
    let zeros = [0.0; 7];
    let file = json!({
        "robot": "kinova_gen3", "horizon_s": 1.6, "robot_shape": "joint_frames",
        "q_start": [0.0, 0.5, 0.0, 1.6, 0.0, 1.0, 0.0], "v_start": zeros,
        "q_goal": [goal, 0.9, 0.0, 1.9, 0.0, 0.9, 0.0], "v_goal": zeros,
        "enforced_limits": enforced,
    });
    load("arm", &file).expect("it is good")
}

fn all() -> Value {
    json!({ "position": true, "velocity": true, "torque": true })
}

fn details(report: &SolveReport) -> &DirectDetails {
    match &report.summary.details {
        Details::Direct(details) => details,
        _ => panic!("it was solved directly"),
    }
}

/// The solve as it is read from its summary.
fn written(report: &SolveReport, name: &str) -> Solved {
    let file = std::env::temp_dir().join(format!("aghf_warm_start_{name}_{}.json", std::process::id()));
    let text = serde_json::to_string(&report.summary).expect("it is JSON");
    std::fs::write(&file, text).expect("the folder is writable");
    let solved = Solved::load(&file.display().to_string());
    std::fs::remove_file(&file).expect("it is there");
    solved.unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_solve_starts_from_another_one_and_says_so() {
    let first = arm(1.4, all());
    let first = written(&solved_once(&first), "first");
    let moved = arm(1.41, all());
    let cold = solved_once(&moved);
    let warm = Solve::new(&moved).start(&first).run().expect("it is good");
    let [few, many] = [&warm, &cold].map(|report| details(report).iterations);
    assert!(few < many, "{few} {many}");
    let [cost, other] = [&warm, &cold].map(|report| details(report).cost);
    // The margins between the points are not those of the other search.
    assert!((cost - other).abs() < 2e-3 * other, "{cost} {other}");
    let said = |report: &SolveReport| report.summary.notes.iter().any(|n| n.ends_with("with its multipliers"));
    assert!(said(&warm) && !said(&cold), "{:?}", warm.summary.notes);

    let fewer = arm(1.41, json!({ "position": false, "velocity": true, "torque": false }));
    let other = Solve::new(&fewer).start(&first).run().expect("it is good");
    let noted = |words: &str| other.summary.notes.iter().any(|note| note.contains(words));
    assert!(noted("the constraints are others"), "{:?}", other.summary.notes);
}

/// From its own solution a problem is solved at once, whatever the objective.
#[test]
fn an_unchanged_problem_is_solved_at_once() {
    for objective in ["least-effort", "least-time", "balanced"] {
        let mut scenario = arm(1.4, all());
        scenario.file.objective = serde_json::from_value(json!(objective)).expect("it is one");
        let cold = solved_once(&scenario);
        assert_eq!(cold.summary.verdict, Verdict::Optimal);
        let warm = Solve::new(&scenario).start(&written(&cold, objective)).run().expect("it is good");
        assert_eq!(warm.summary.verdict, Verdict::Optimal);
        assert!(details(&warm).iterations <= 5, "{objective}: {}", details(&warm).iterations);
        let of = |report: &SolveReport| [report.curve.horizon(), details(report).cost];
        for (is, was) in of(&warm).into_iter().zip(of(&cold)) {
            assert!((is - was).abs() <= 1e-6 * was, "{objective}: {is} {was}");
        }
    }
}

/// A given horizon is that of the scenario, whatever that of the other motion was.
#[test]
fn a_start_leaves_the_horizon_that_is_given() {
    let first = arm(1.4, all());
    let first = written(&solved_once(&first), "shorter");
    let mut longer = arm(1.4, all());
    longer.file.horizon_s = 2.0;
    let warm = Solve::new(&longer).start(&first).run();
    let warm = warm.expect("it is good");
    assert!((warm.curve.horizon() - 2.0).abs() < 1e-12);
}

#[test]
fn a_start_that_does_not_fit_is_refused() {
    let first = arm(1.4, all());
    let first = written(&solved_once(&first), "other");
    let cart = Scenario::load("cart_pole_swingup").expect("it is built in");
    let error = Solve::new(&cart).start(&first).run().map(|_| ()).expect_err("other joints");
    let words = "start: the motion of 'arm': curve.joints: the motion and robot '";
    assert!(error.to_string().starts_with(words), "{error}");
    let moved = arm(1.41, all());
    let rest = SolveOptions::from_keys(Method::Rest, Default::default()).expect("there are none");
    let error = Solve::new(&moved).options(rest).start(&first).run();
    let error = error.map(|_| ()).expect_err("another method");
    assert!(error.to_string().contains("only the direct method"), "{error}");
}
