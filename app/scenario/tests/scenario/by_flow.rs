//! Variants of the flow by their names: what each makes of scenarios, and the options that it knows.

use aghf_scenario::{
    Details, FlowVariant, Method, RestDetails, Scenario, SolveOptions, SolveReport, solve,
};
use serde_json::Value;

/// The least efforts that IPOPT found, with the command that found them.
const IPOPT: &str = include_str!("../../../../robots/underactuated_ipopt.json");

fn options(variant: FlowVariant) -> SolveOptions {
    SolveOptions {
        method: Method::Flow,
        variant: Some(variant),
        ..SolveOptions::default()
    }
}

fn solved(name: &str, options: &SolveOptions) -> SolveReport {
    let scenario = Scenario::load(name).expect("built in");
    solve(&scenario, options, &mut |_| {}).expect("valid")
}

fn details(report: &SolveReport) -> &RestDetails {
    match &report.summary.details {
        Details::Rest(details) => details,
        other => panic!("it is a flow to rest: {other:?}"),
    }
}

#[test]
fn without_constraints_penalty_and_duals_come_to_the_effort_of_the_relaxation_from_the_same_guess()
{
    let relaxation = SolveOptions {
        num_starts: Some(1),
        ..SolveOptions::default()
    };
    let name = "pendulum_3_swingup";
    let relaxed = solved(name, &relaxation).summary.control_effort;
    for variant in [FlowVariant::Rest, FlowVariant::Duals] {
        let stiff = SolveOptions {
            k: Some(1e8),
            ..options(variant)
        };
        let report = solved(name, &stiff);
        assert!(report.summary.success, "{:?}", report.summary.failure);
        let effort = report.summary.control_effort;
        assert!((effort / relaxed - 1.0).abs() < 1e-6, "{effort} {relaxed}");
    }
}

#[test]
fn a_line_that_collides_is_bent_around_by_duals_and_in_two_phases() {
    for variant in [FlowVariant::Duals, FlowVariant::TwoPhases] {
        for name in ["kinova_gap_02", "kinova_floor_04"] {
            let report = solved(name, &options(variant));
            assert!(
                report.summary.success,
                "{name}: {:?}",
                report.summary.failure
            );
            let details = details(&report);
            assert!(details.largest_violation.is_some_and(|by| by <= 1e-5));
            assert!(details.slip <= 1e-6, "{}", details.slip);
            assert_eq!(details.variant, variant);
        }
    }
}

#[test]
fn what_a_penalty_alone_leaves_of_the_slip_goes_with_duals() {
    let soft = |variant| SolveOptions {
        k: Some(1e4),
        ..options(variant)
    };
    let [alone, with_duals] =
        [FlowVariant::Rest, FlowVariant::Duals].map(|v| solved("pendulum_2_swingup", &soft(v)));
    let [alone, with_duals] = [details(&alone).slip, details(&with_duals).slip];
    assert!(alone > 1e-4 && with_duals < 1e-6, "{alone} {with_duals}");
}

#[test]
fn robots_without_a_motor_at_each_joint_swing_up() {
    let ipopt: Value = serde_json::from_str(IPOPT).expect("it is JSON");
    let duals = options(FlowVariant::Duals);
    let relaxation = SolveOptions::default();
    for (name, options) in [
        ("cart_pole_swingup", &duals),
        ("acrobot_swingup", &duals),
        ("pendubot_swingup", &duals),
        ("cart_pole_swingup", &relaxation),
        ("pendubot_swingup", &relaxation),
    ] {
        let report = solved(name, options);
        let summary = &report.summary;
        assert!(summary.success, "{name}: {:?}", summary.failure);
        let error = summary.final_error_inf.expect("it was simulated");
        assert!(error < 0.05, "{name}: {error}");
        let passive = summary
            .feasibility
            .largest_passive_torque
            .expect("one is passive");
        assert!(
            passive < 1e-3 * summary.feasibility.largest_torque,
            "{name}: {passive}"
        );
        let least = ipopt[name]["effort"].as_f64().expect("a number");
        // Less than the least known would be a motion that carries torque where none may be.
        let ratio = summary.control_effort / least;
        assert!((0.999..1.05).contains(&ratio), "{name}: {ratio}");
    }
}

#[test]
fn a_flow_to_rest_knows_no_options_of_the_published_flow_and_repeats_itself() {
    let scenario = Scenario::load("pendulum_1_swingup").expect("built in");
    let foreign = SolveOptions {
        s_max: Some(1.0),
        ..options(FlowVariant::Duals)
    };
    let refused = solve(&scenario, &foreign, &mut |_| {}).expect_err("there is no end in s");
    assert_eq!(
        refused.to_string(),
        "options: s_max: the method 'flow to rest' has no such parameter"
    );
    let relaxation = SolveOptions {
        variant: Some(FlowVariant::Duals),
        ..SolveOptions::default()
    };
    let refused = solve(&scenario, &relaxation, &mut |_| {}).expect_err("it is no flow");
    assert_eq!(
        refused.to_string(),
        "options: variant: the method 'relax' has no such parameter"
    );
    let asked = SolveOptions {
        num_starts: Some(3),
        seed: Some(4),
        ..options(FlowVariant::Duals)
    };
    let first = solve(&scenario, &asked, &mut |_| {}).expect("valid");
    let again = solve(&scenario, &asked.in_full(&scenario), &mut |_| {}).expect("valid");
    assert_eq!(first.curve.x(), again.curve.x());
    assert_eq!(details(&first).guesses, 3);
}
