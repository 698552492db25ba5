//! The defaults against the least costs that are known of built-in scenarios, `robots/best_known.json`.

use aghf_scenario::{Details, Scenario, Solve, builtin_scenarios};
use serde_json::Value;

/// The factor above the least known cost that the defaults may find without limits.
const NEAR: f64 = 1.5;
/// The part that the digits of the file leave out.
const DIGITS: f64 = 1e-5;

fn known() -> Value {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/best_known.json"))
        .expect("it is there");
    serde_json::from_str(&text).expect("it is JSON")
}

/// The defaults on scenarios without limits and obstacles find nothing that costs much more, nor anything that costs
/// less.
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
        let Details::Direct(details) = &report.summary.details else {
            panic!("it is a direct solve");
        };
        assert!(report.summary.success, "{name}");
        let cost = details.minima[0].cost;
        let least = known[name]["cost"].as_f64().expect("a number");
        let ratio = cost / least;
        assert!((1.0 - DIGITS..NEAR).contains(&ratio), "{name}: {cost}, {least}");
    }
}
