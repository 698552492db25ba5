//! Conditions at single times are refused if they are broken there: rest at the ends, rates, and windows of time.

use crate::gantry::{FROM, TO, scenario};
use crate::{certified, curve, smooth};
use serde_json::json;

/// A motion at rest at its ends has no acceleration there unless the continuity is that of the velocity, and its
/// velocities are the rates of its positions.
#[test]
fn accelerations_at_rest_and_slipping_velocities_are_refused() {
    let pushed = curve(3, 8, 1.0, |i, t| {
        let (way, rise) = (TO[i] - FROM[i], t * t * (3.0 - 2.0 * t));
        [FROM[i] + way * rise, way * 6.0 * t * (1.0 - t)]
    });
    for (continuity, failures) in [("acceleration", 2), ("velocity", 0)] {
        let keys = json!({ "continuity": continuity });
        let found = certified(&scenario("rest", keys), &pushed, &[], 0.0).expect("three joints");
        let rests = found.failures.iter().filter(|f| f.promise.ends_with(" acceleration"));
        assert_eq!((found.failures.len(), rests.count()), (failures, failures));
    }
    let slipping = curve(3, 8, 1.0, |i, t| {
        let (way, rise) = (TO[i] - FROM[i], t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t));
        [FROM[i] + way * rise, way * 30.0 * (t * (1.0 - t)).powi(2) + 1e-8 * (t * (1.0 - t))]
    });
    let scenario = scenario("slip", json!({}));
    let found = certified(&scenario, &slipping, &[], 0.0).expect("three joints");
    assert!(found.failures[0].promise.contains("rate of the position"), "{:?}", found.failures);
}

/// A window of time that no time of the motion is in promises nothing.
#[test]
fn windows_after_the_motion_are_refused() {
    let keep = json!([{ "speed": { "frame": "carriage", "most_m_s": 1e-3 }, "from_s": 2.0 }]);
    let keys = json!({ "keep": keep, "free_horizon": { "shortest_s": 0.5, "longest_s": 5.0 } });
    let found = certified(&scenario("window", keys), &smooth(), &[], 0.0).expect("three joints");
    assert!(found.failures.iter().any(|f| f.promise.starts_with("keep[0]")), "{:?}", found.failures);
}
