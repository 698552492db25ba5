//! The published flow on the built-in scenarios.

use crate::common::assert_refused;
use crate::written::sampled;
use aghf_scenario::judge::{Tolerances, judge};
use aghf_scenario::{
    FlowOptions, Quantity, RestOptions, Scenario, Solve, SolveOptions, SolveReport, Verdict, builtin_scenarios,
};

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
            let words = format!("{name}: passive: supported by the methods 'duals'");
            assert_refused(outcome, &words);
            continue;
        }
        if scenario.file.free_horizon.is_some() {
            let words = format!("{name}: objective with a weight of time: supported by the method 'direct' only");
            assert_refused(outcome, &words);
            continue;
        }
        let summary = outcome.expect("valid").summary;
        println!("{name}: {:?} {:?}", summary.final_error_inf, summary.open_loop_error_inf);
        let beyond = BEYOND_TORQUE_LIMITS.contains(&name);
        assert_eq!(summary.success, !beyond, "{name}: {summary:?}");
        if beyond {
            let error = summary.final_error_inf.expect("it was simulated");
            assert!(error < summary.success_threshold, "{name}: {error}");
            let violations = summary.feasibility.limit_violations;
            let torque = violations.iter().all(|v| v.limit == Quantity::Torque);
            assert!(torque, "{name}: {violations:?}");
        }
    }
}

/// Solves a scenario, and returns whether the judge accepts the motion.
fn judged(name: &str, options: SolveOptions) -> (SolveReport, bool) {
    let scenario = Scenario::load(name).expect("built in");
    let found = Solve::new(&scenario).options(options).run();
    let report = found.expect("it is good");
    let judged = judge(&scenario, &sampled(&scenario, &report), Tolerances::default()).expect("its joints");
    (report, judged.valid)
}

/// No flow is called optimal or valid with a motion that the judge refuses: wherever the published one stops, its
/// verdict is that it is there, with its defect, and a flow to rest with a soft penalty is not valid.
#[test]
fn a_verdict_does_not_contradict_the_judge() {
    let mut refused = [0, 0];
    for name in ["pendulum_1_swingup", "pendulum_2_swingup", "kinova_free_04"] {
        for s_max in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1] {
            let options = FlowOptions { s_max: Some(s_max), ..FlowOptions::default() };
            let (SolveReport { summary, .. }, is_good) = judged(name, options.into());
            let defect = summary.dynamics_defect;
            println!("| {name} | {s_max:e} | {} | {defect:.1e} | {is_good} |", summary.verdict);
            assert_eq!(summary.verdict, Verdict::AtSMax, "{name} {s_max}");
            let words = format!("the curve of the flow at s = {s_max:e}, which is no minimum");
            let note = summary.notes.iter().find(|note| note.starts_with(&words));
            let note = note.unwrap_or_else(|| panic!("{:?}", summary.notes));
            let told: Option<f64> = note.rsplit(' ').next().and_then(|last| last.parse().ok());
            let off = told.map(|told| (told / defect - 1.0).abs());
            assert!(off.is_some_and(|off| off < 0.01), "{note} {defect}");
            refused[0] += usize::from(!is_good);
        }
        for k in [1e2, 1e4, 1e6, 1e8] {
            let options = RestOptions { k: Some(k), ..RestOptions::default() };
            let (SolveReport { summary, .. }, is_good) = judged(name, SolveOptions::Rest(options));
            println!("| {name} | {k:e} | {} | {:.1e} | {is_good} |", summary.verdict, summary.dynamics_defect);
            assert!(is_good || summary.verdict == Verdict::NotValid, "{name} {k}: {summary:?}");
            refused[1] += usize::from(!is_good);
        }
    }
    assert!(refused.iter().all(|count| *count > 0), "{refused:?}");
}
