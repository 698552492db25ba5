//! The curve of duration against effort.

use crate::units::cart;
use crate::written::load;
use aghf::motion::Interrupt;
use aghf_scenario::{DirectOptions, Preset, Scenario, Tradeoff};
use serde_json::json;

#[test]
fn longer_motions_cost_less_and_each_solves_its_scenario() {
    let scenario = Scenario::load("limits_02").expect("generated");
    let options = DirectOptions { threads: Some(1), ..DirectOptions::default() };
    let mut iterations = 0;
    let found =
        Tradeoff::new(&scenario).points(5).options(options).observe(|_| iterations += 1).run().expect("it is good");
    assert_eq!(found.len(), 5);
    assert!(iterations > 0);
    let horizons: Vec<f64> = found.iter().map(|(_, of)| of.curve.horizon()).collect();
    let efforts = found.iter().map(|(_, of)| of.summary.control_effort);
    assert!(efforts.clone().rev().is_sorted(), "{:?}", efforts.collect::<Vec<_>>());
    let ratio = horizons[1] / horizons[0];
    assert!(ratio > 1.0);
    for pair in horizons.windows(2) {
        assert!((pair[1] / pair[0] - ratio).abs() < 1e-6, "{horizons:?}");
    }
    for (of, report) in &found[1..4] {
        assert!(report.summary.success, "{:?}", report.summary);
        assert_eq!(of.file.objective.preset(), Some(Preset::LeastEffort));
        assert_eq!((of.file.horizon_s, of.horizon_bounds()), (report.curve.horizon(), None));
    }
    assert_eq!(found[0].0.file.objective.preset(), Some(Preset::LeastTime));
}

#[test]
fn what_has_no_curve_is_refused() {
    let scenario = load("cart", &cart(2.0, 40.0, json!({}))).expect("it is good");
    for points in [1, 1001] {
        let error = Tradeoff::new(&scenario).points(points).run().expect_err("too few or many");
        let words = format!("options: points: it is {points} and must be at least 2");
        assert!(error.to_string().starts_with(&words), "{error}");
    }
    let limits = json!({ "position": false, "velocity": false, "torque": false });
    let free = cart(2.0, 40.0, json!({ "enforced_limits": limits }));
    let free = load("free", &free).expect("it is good");
    let error = Tradeoff::new(&free).run().expect_err("nothing bounds it");
    assert!(error.to_string().contains("without limits there is no least time"), "{error}");
}

#[test]
fn what_was_found_before_a_stop_remains() {
    let scenario = Scenario::load("limits_02").expect("generated");
    let interrupt = Interrupt::default();
    let (stop, mut solves) = (interrupt.clone(), 0);
    let found = Tradeoff::new(&scenario)
        .points(8)
        .interrupt(interrupt)
        .observe(|_| {
            solves += 1;
            if solves == 400 {
                stop.raise();
            }
        })
        .run()
        .expect("it is good");
    assert!((1..=8).contains(&found.len()), "{}", found.len());
}
