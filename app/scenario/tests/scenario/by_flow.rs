//! The flows to rest by their names: what each makes of scenarios, and the options that it knows.

use aghf_scenario::{
    Details, DirectOptions, Method, RestDetails, RestOptions, Scenario, Solve, SolveOptions, SolveReport,
};
use serde_json::{Map, Value, json};

/// The least efforts that IPOPT found, with the command that found them.
const IPOPT: &str = include_str!("../../../../robots/underactuated_ipopt.json");

/// A method of its kind with these options.
type Rest = fn(RestOptions) -> SolveOptions;

fn usual(method: Rest) -> SolveOptions {
    method(RestOptions::default())
}

fn solved(name: &str, options: &SolveOptions) -> SolveReport {
    let scenario = Scenario::load(name).expect("built in");
    Solve::new(&scenario).options(options.clone()).run().expect("valid")
}

fn details(report: &SolveReport) -> &RestDetails {
    match &report.summary.details {
        Details::Rest(details) => details,
        other => panic!("it is a flow to rest: {other:?}"),
    }
}

#[test]
fn without_constraints_penalty_and_duals_come_to_the_effort_of_the_direct_method_from_the_same_guess() {
    let direct = SolveOptions::Direct(DirectOptions { starts: Some(1), ..DirectOptions::default() });
    let name = "pendulum_3_swingup";
    let direct = solved(name, &direct).summary.control_effort;
    for method in [SolveOptions::Rest as Rest, SolveOptions::Duals] {
        let stiff = method(RestOptions { k: Some(1e8), ..RestOptions::default() });
        let report = solved(name, &stiff);
        assert!(report.summary.success, "{:?}", report.summary.failure);
        let effort = report.summary.control_effort;
        assert!((effort / direct - 1.0).abs() < 1e-6, "{effort} {direct}");
    }
}

#[test]
fn a_line_that_collides_is_bent_around_by_duals_and_in_two_phases() {
    for (method, name) in [(SolveOptions::Duals as Rest, Method::Duals), (SolveOptions::TwoPhases, Method::TwoPhases)] {
        let options = usual(method);
        for scenario in ["kinova_gap_02", "kinova_floor_04"] {
            let report = solved(scenario, &options);
            assert!(report.summary.success, "{scenario}: {:?}", report.summary.failure);
            let details = details(&report);
            assert!(details.largest_violation.is_some_and(|by| by <= 1e-5));
            assert!(details.slip <= 1e-6, "{}", details.slip);
            assert_eq!(report.summary.method, name);
        }
    }
}

#[test]
fn what_a_penalty_alone_leaves_of_the_slip_goes_with_duals() {
    let soft = RestOptions { k: Some(1e4), ..RestOptions::default() };
    let [alone, with_duals] = [SolveOptions::Rest as Rest, SolveOptions::Duals]
        .map(|method| solved("pendulum_2_swingup", &method(soft.clone())));
    let [alone, with_duals] = [details(&alone).slip, details(&with_duals).slip];
    assert!(alone > 1e-4 && with_duals < 1e-6, "{alone} {with_duals}");
}

#[test]
fn robots_without_a_motor_at_each_joint_swing_up() {
    let ipopt: Value = serde_json::from_str(IPOPT).expect("it is JSON");
    let duals = usual(SolveOptions::Duals);
    let direct = SolveOptions::default();
    for (name, options) in [
        ("cart_pole_swingup", &duals),
        ("acrobot_swingup", &duals),
        ("pendubot_swingup", &duals),
        ("cart_pole_swingup", &direct),
        ("pendubot_swingup", &direct),
    ] {
        let report = solved(name, options);
        let summary = &report.summary;
        assert!(summary.success, "{name}: {:?}", summary.failure);
        let error = summary.final_error_inf.expect("it was simulated");
        assert!(error < 0.05, "{name}: {error}");
        let passive = summary.feasibility.largest_passive_torque.expect("one is passive");
        assert!(passive < 1e-3 * summary.feasibility.largest_torque, "{name}: {passive}");
        let least = ipopt[name]["effort"].as_f64().expect("a number");
        // Less than the least known would be a motion that carries torque where none may be.
        let ratio = summary.control_effort / least;
        assert!((0.999..1.05).contains(&ratio), "{name}: {ratio}");
    }
}

#[test]
fn a_flow_to_rest_knows_no_options_of_the_published_flow_and_repeats_itself() {
    let scenario = Scenario::load("pendulum_1_swingup").expect("built in");
    let keys = |key: &str, value: Value| Map::from_iter([(key.to_owned(), value)]);
    for (method, key, value) in [
        (Method::Duals, "s_max", json!(1.0)),
        (Method::Direct, "k", json!(1.0)),
        (Method::Direct, "variant", json!("duals")),
    ] {
        let refused = SolveOptions::from_keys(method, keys(key, value)).expect_err("foreign");
        let words = format!("options: {key}: unknown field `{key}`; the");
        assert!(refused.to_string().starts_with(&words), "{refused}");
    }
    let asked = SolveOptions::Duals(RestOptions { starts: Some(3), seed: Some(4), ..RestOptions::default() });
    let solve = |options| Solve::new(&scenario).options(options).run().expect("valid");
    let first = solve(asked.clone());
    let again = solve(asked.in_full(&scenario).expect("in range"));
    assert_eq!(first.curve.x(), again.curve.x());
    assert_eq!(details(&first).starts_tried, 3);
}
