//! Goals by pose and conditions on the way, by closed forms of the gantry.

use crate::robot::{FROM, TO, failed, good, row, scenario, verdict};
use aghf_scenario::Quantity;
use aghf_scenario::judge::{Check, Outcome};
use serde_json::{Value, json};

const NONE: [Check; 0] = [];
const KEPT: Check = Check::Bounds(Quantity::Frame);

/// The elbow, which is the origin of the fore link, and the direction of that link.
fn elbow([slide, shoulder, elbow]: [f64; 3]) -> ([f64; 3], f64) {
    ([slide + 0.5 * shoulder.cos(), 0.5 * shoulder.sin(), 0.0], shoulder + elbow)
}

fn goal(position: [f64; 3], angle: f64) -> Value {
    let turn = [0.0, 0.0, (0.5 * angle).sin(), (0.5 * angle).cos()];
    json!({ "frame": "fore", "position_m": position, "orientation_xyzw": turn })
}

/// The failed checks of the motion from FROM to TO with these keys, and the excess, unit and place of one of them.
fn judged(test: &str, keys: Value, check: Check) -> (Vec<Check>, f64, String) {
    let scenario = scenario(test, keys);
    let judgement = verdict(&scenario, &good(&scenario.model, FROM, TO, 101));
    let worst = row(&judgement, check).worst.clone().expect("it was checked");
    let place = format!("{} {}", worst.unit, worst.place.unwrap_or_default());
    (failed(&judgement), worst.value, place)
}

#[test]
fn the_last_pose_is_that_of_the_goal() {
    let (at, angle) = elbow(TO);
    let (bad, worst, _) = judged("pose", json!({ "goal": goal(at, angle) }), Check::GoalPosition);
    assert_eq!(bad, NONE);
    assert!(worst < 1e-12, "{worst}");
    let off = json!({ "goal": goal([at[0] + 2e-3, at[1], at[2]], angle) });
    let (bad, worst, place) = judged("off", off, Check::GoalPosition);
    assert_eq!((bad, &*place), (vec![Check::GoalPosition], "m distance of frame 'fore'"));
    assert!((worst - 2e-3).abs() < 1e-12);
    for turned in [angle + 0.01, angle + std::f64::consts::PI] {
        let (bad, worst, place) = judged("turned", json!({ "goal": goal(at, turned) }), Check::GoalPosition);
        assert_eq!((bad, &*place), (vec![Check::GoalPosition], "rad angle of frame 'fore'"));
        assert!((worst - (turned - angle)).abs() < 1e-9, "{worst}");
    }
    // Of two goals the one that is missed least.
    let both = json!({ "goal": [goal([1.0; 3], 0.0), goal(at, angle)] });
    assert_eq!(judged("two", both, Check::GoalPosition).0, NONE);
}

#[test]
fn tolerances_boxes_and_axes() {
    let (at, angle) = elbow(TO);
    let with = |keys: Value| {
        let mut goal = json!({ "frame": "fore" });
        for (key, value) in keys.as_object().expect("an object") {
            goal[key] = value.clone();
        }
        judged("sets", json!({ "goal": goal }), Check::GoalPosition).0
    };
    let near = [at[0] + 0.03, at[1], at[2]];
    assert_eq!(with(json!({ "position_m": near, "tolerance_m": 0.031 })), NONE);
    assert_ne!(with(json!({ "position_m": near, "tolerance_m": 0.028 })), NONE);
    // A box that is turned by a right angle about z: its long edge is along y of the base.
    let turned = |centre: [f64; 3]| {
        let half = 0.5_f64.sqrt();
        json!({ "box": { "size_m": [0.2, 0.02, null],
            "pose": { "position_m": centre, "orientation_xyzw": [0, 0, half, half] } } })
    };
    assert_eq!(with(turned([at[0], at[1] + 0.09, 5.0])), NONE);
    assert_ne!(with(turned([at[0] + 0.09, at[1], 5.0])), NONE);
    let axis = |direction: f64, tolerance: f64| {
        json!({ "axis": { "of_frame": [2, 0, 0], "direction": [direction.cos(), direction.sin(), 0] },
            "tolerance_rad": tolerance })
    };
    assert_eq!(with(axis(angle, 1e-3)), NONE);
    assert_eq!(with(axis(angle + 0.2, 0.21)), NONE);
    assert_ne!(with(axis(angle + 0.2, 0.19)), NONE);
    assert_ne!(with(axis(angle + 3.0, 0.19)), NONE);
}

/// In the axes of the upper link the fore link turns by the elbow alone, whatever the others do.
#[test]
fn poses_relative_to_a_link_on_the_way() {
    let kept = |least: f64, most: f64| {
        let (middle, half) = (0.5 * (least + most), 0.5 * (most - least));
        json!({ "keep": [{ "poses": { "frame": "fore", "relative_to": "upper",
            "orientation_xyzw": [0.0, 0.0, (0.5 * middle).sin(), (0.5 * middle).cos()], "tolerance_rad": half } }] })
    };
    let (bad, worst, place) = judged("elbow", kept(FROM[2], TO[2]), KEPT);
    assert_eq!((bad, &*place), (NONE.to_vec(), "rad angle of frame 'fore'"));
    assert!((worst - 0.5 * (TO[2] - FROM[2])).abs() < 1e-3, "{worst}");
    assert_eq!(judged("bent", kept(FROM[2], TO[2] - 0.01), KEPT).0, [KEPT]);
}

/// A condition counts between its times alone, and between the samples.
#[test]
fn conditions_are_kept_between_their_times() {
    // The carriage moves from -0.5 to 0.5 and passes zero at half of the second.
    let kept = |times: Value| {
        let mut kept = json!({ "poses": { "frame": "carriage", "box": { "size_m": [1.0, null, null],
            "pose": { "position_m": [-0.5, 0, 0] } } } });
        for (key, value) in times.as_object().expect("an object") {
            kept[key] = value.clone();
        }
        judged("times", json!({ "keep": [kept] }), KEPT).0
    };
    assert_eq!(kept(json!({})), [KEPT]);
    assert_eq!(kept(json!({ "to_s": 0.5 })), NONE);
    assert_eq!(kept(json!({ "to_s": 0.505 })), [KEPT]);
    assert_eq!(kept(json!({ "from_s": 0.495, "to_s": 0.5 })), NONE);
    assert_eq!(kept(json!({ "from_s": 0.505 })), [KEPT]);
}

/// The carriage is fastest, at 15/8 m/s, halfway.
#[test]
fn speeds_are_those_of_the_point() {
    let kept = |most: f64| json!({ "keep": [{ "speed": { "frame": "carriage", "most_m_s": most } }] });
    let (bad, fastest, place) = judged("speed", kept(1.876), KEPT);
    assert_eq!((bad, &*place), (NONE.to_vec(), "m/s speed of frame 'carriage'"));
    // To the error of polynomials of degree two.
    assert!((fastest - 1.875).abs() < 1e-6, "{fastest}");
    assert_eq!(judged("fast", kept(1.87), KEPT).0, [KEPT]);
    let scenario = scenario("none", json!({}));
    let judgement = verdict(&scenario, &good(&scenario.model, FROM, TO, 101));
    assert!(judgement.checks.iter().all(|row| row.check != KEPT || row.outcome == Outcome::Pass));
}
