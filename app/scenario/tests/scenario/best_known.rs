//! The least costs that are known of the built-in scenarios, `robots/best_known.json`, and how near the defaults come to them.

use aghf_scenario::{Details, Scenario, Solve, builtin_scenarios};
use serde_json::Value;

/// The factor above the least known cost that the defaults may find without limits.
const NEAR: f64 = 1.5;
/// The part that the digits of the file leave out.
const DIGITS: f64 = 1e-5;

fn known() -> Value {
    let text = std::fs::read_to_string("robots/best_known.json").expect("it is there");
    serde_json::from_str(&text).expect("it is JSON")
}

/// The least efforts of scenarios with passive joints, which are IPOPT's.
fn of_ipopt() -> Value {
    let text = std::fs::read_to_string("robots/underactuated_ipopt.json").expect("it is there");
    serde_json::from_str(&text).expect("it is JSON")
}

/// The scenarios that take IPOPT too long: minutes from each start.
const TOO_LONG: &str = "kinova_dead_wrist_01";

/// Each built-in scenario with passive joints but one has an effort that IPOPT found, on a mesh that is fine enough, and nothing else has.
#[test]
fn every_scenario_with_passive_joints_has_an_effort_of_ipopt() {
    let found = of_ipopt();
    let entries = found.as_object().expect("it is an object");
    let passive = |name: &&str| {
        let scenario = Scenario::load(name).expect("built in");
        !scenario.passive().is_empty() && *name != TOO_LONG
    };
    let names: Vec<&str> = builtin_scenarios().filter(passive).collect();
    for name in &names {
        let entry = entries.get(*name).unwrap_or_else(|| panic!("{name}"));
        let [fine, coarse] = ["effort", "effort_of_half_the_intervals"]
            .map(|key| entry[key].as_f64().expect("a number"));
        assert!(fine > 0.0 && (fine - coarse).abs() < 1e-3 * fine, "{entry}");
        assert_eq!(entry["status"], "Solve_Succeeded", "{name}");
        let command = entry["command"].as_str().expect("a command");
        let start = format!("benches/underactuated.py {name} ");
        assert!(command.starts_with(&start), "{command}");
    }
    assert_eq!(entries.len(), names.len());
}

/// Every other built-in scenario has an entry with the command that found it, and nothing else has.
#[test]
fn every_built_in_scenario_has_a_best_known_cost() {
    let known = known();
    let entries = known.as_object().expect("it is an object");
    let driven = |name: &&str| {
        let scenario = Scenario::load(name).expect("built in");
        scenario.passive().is_empty()
    };
    let names: Vec<&str> = builtin_scenarios().filter(driven).collect();
    for name in &names {
        let entry = entries.get(*name).unwrap_or_else(|| panic!("{name}"));
        let command = entry["command"].as_str().expect("a command");
        assert!(
            command.starts_with(&format!("aghf solve {name}")),
            "{command}"
        );
        assert!(
            entry["cost"].as_f64().is_some_and(|cost| cost > 0.0),
            "{name}"
        );
    }
    assert_eq!(entries.len(), names.len());
}

/// The defaults on scenarios without limits and obstacles find nothing that costs much more, nor anything that costs less.
#[test]
fn the_defaults_come_near_the_best_known_cost() {
    let known = known();
    let names = builtin_scenarios().filter(|name| {
        let arm = name.starts_with("kinova_free");
        arm || (name.starts_with("pendulum") && *name != "pendulum_1_swingup")
    });
    for name in names {
        let scenario = Scenario::load(name).expect("built in");
        let report = Solve::new(&scenario).run().expect("valid");
        let Details::Relax(details) = &report.summary.details else {
            panic!("it is a relaxation");
        };
        assert!(report.summary.success, "{name}");
        let cost = details.minima[0].cost;
        let least = known[name]["cost"].as_f64().expect("a number");
        let ratio = cost / least;
        assert!(
            (1.0 - DIGITS..NEAR).contains(&ratio),
            "{name}: {cost}, {least}"
        );
    }
}
