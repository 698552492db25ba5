//! Points on the way, by the straight motion of the gantry.

use crate::robot::{FROM, TO, failed, good, row, scenario, verdict};
use aghf_scenario::judge::{Check, Judgement};
use serde_json::{Value, json};

/// The configuration at a share of the way.
fn at(share: f64) -> Vec<f64> {
    let ends = FROM.iter().zip(TO);
    ends.map(|(from, to)| from + share * (to - from)).collect()
}

fn judged(test: &str, waypoints: Value) -> Judgement {
    let scenario = scenario(test, json!({ "waypoints": waypoints }));
    verdict(&scenario, &good(&scenario.model, FROM, TO, 101))
}

/// Points of the motion in their order are passed, between samples too; one beside it, one too late and a stop are not.
#[test]
fn points_are_passed_in_their_order() {
    let passed = judged("passed", json!([{ "q": at(0.2) }, { "q": at(0.731) }]));
    assert!(failed(&passed).is_empty());
    let worst = row(&passed, Check::Waypoints).worst.clone().expect("it is checked");
    assert!((worst.value - worst.at_least.expect("it has a bound")).abs() < 1e-6);
    let mut beside = at(0.4);
    beside[1] += 0.02;
    let cases = [
        ("beside", json!([{ "q": beside }]), "waypoint 0"),
        ("late", json!([{ "q": at(0.6) }, { "q": at(0.3) }]), "waypoint 1"),
        ("stop", json!([{ "q": at(0.5), "stop": true }]), "waypoint 0"),
    ];
    for (test, waypoints, place) in cases {
        let judgement = judged(test, waypoints);
        assert_eq!(failed(&judgement), [Check::Waypoints], "{test}");
        let worst = row(&judgement, Check::Waypoints).worst.clone().expect("it is checked");
        assert!(worst.place.clone().is_some_and(|of| of.ends_with(place)), "{worst:?}");
    }
}

/// A given time is the only one that counts, and a start is a stop.
#[test]
fn a_given_time_counts() {
    let half = |time: f64| json!([{ "q": at(0.5), "time_s": time }]);
    assert!(failed(&judged("half", half(0.5))).is_empty());
    assert_eq!(failed(&judged("third", half(0.35))), [Check::Waypoints]);
    // The motion is over before it, or just before it and elsewhere.
    for (time, share) in [(1.5, 1.0), (1.0 + 1e-6, 0.9)] {
        let mut scenario = scenario("after", json!({ "waypoints": [{ "q": at(share), "time_s": 0.5 }] }));
        scenario.file.waypoints[0].time_s = Some(time);
        let motion = good(&scenario.model, FROM, TO, 101);
        assert_eq!(failed(&verdict(&scenario, &motion)), [Check::Waypoints]);
    }
    // Another one comes first.
    let order = json!([{ "q": at(0.9) }, { "q": at(0.5), "time_s": 0.5 }]);
    assert_eq!(failed(&judged("order", order)), [Check::Waypoints]);
    let rest = json!([{ "q": FROM, "stop": true }]);
    assert!(failed(&judged("rest", rest)).is_empty());
}

/// The pose of a frame on the way is as good as its configuration.
#[test]
fn poses_are_passed() {
    let [slide, shoulder, _] = at(0.5)[..] else {
        panic!("the gantry has three joints");
    };
    let elbow = [slide + 0.5 * shoulder.cos(), 0.5 * shoulder.sin(), 0.0];
    let poses = |x: f64| json!([{ "poses": { "frame": "fore", "position_m": [x, elbow[1], elbow[2]] } }]);
    assert!(failed(&judged("pose", poses(elbow[0]))).is_empty());
    assert_eq!(failed(&judged("off", poses(elbow[0] + 5.0))), [Check::Waypoints]);
}
