//! The published flow on the built-in scenarios.

use crate::common::assert_refused;
use aghf_scenario::{FlowOptions, Limit, Scenario, Solve, builtin_scenarios};

/// The scenarios in which the flow reaches the goal with a torque beyond its limit: the penalty that stands for the
/// limit in its action is finite.
const BEYOND_TORQUE_LIMITS: [&str; 1] = ["three_arms_01"];

/// Acceptance: the flow solves every built-in scenario with the parameters in its file, but for those that are told
/// above and those with passive joints or a free horizon, which it refuses.
#[test]
fn every_built_in_scenario_succeeds() {
    for name in builtin_scenarios() {
        let scenario = Scenario::load(name).expect("built in");
        let options = FlowOptions::default();
        let outcome = Solve::new(&scenario).options(options.clone()).run();
        if !scenario.passive().is_empty() {
            let words = format!("{name}: passive: the published flow does not know it");
            assert_refused(outcome, &words);
            continue;
        }
        if scenario.file.free_horizon.is_some() {
            let words = format!(
                "{name}: objective with a weight of time: the method 'flow' does not know it"
            );
            assert_refused(outcome, &words);
            continue;
        }
        let summary = outcome.expect("valid").summary;
        println!(
            "{name}: {:?} {:?}",
            summary.final_error_inf, summary.open_loop_error_inf
        );
        let beyond = BEYOND_TORQUE_LIMITS.contains(&name);
        assert_eq!(summary.success, !beyond, "{name}: {summary:?}");
        if beyond {
            let error = summary.final_error_inf.expect("it was simulated");
            assert!(error < summary.success_threshold, "{name}: {error}");
            let violations = summary.feasibility.limit_violations;
            let torque = violations.iter().all(|v| v.limit == Limit::Torque);
            assert!(torque, "{name}: {violations:?}");
        }
    }
}
