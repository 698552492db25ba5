//! Promises are proved where they hold, and refused where they are broken for a moment.

use crate::gantry::scenario;
use crate::{certified, curve, shaped, smooth};
use aghf::constraint::Bounds;
use aghf::curve::Curve;
use aghf::motion::samples_at;
use aghf_scenario::certify::{Certification, LEFT_OUT, TOLERANCE};
use aghf_scenario::{Quantity, Scenario};
use serde_json::{Value, json};
use std::path::Path;

const SLIDER: &str = r#"<robot name="slider"><link name="rail"/>
  <link name="carriage"><inertial><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="carriage"/><axis xyz="1 0 0"/>
    <limit lower="-100" upper="100" velocity="1000" effort="EFFORT"/></joint></robot>"#;

fn proved(certification: &Certification) -> &[Quantity] {
    assert_eq!(certification.failures, []);
    let certificate = certification.certificate.as_ref().expect("it is proved");
    let reserves = certificate.intervals.iter().flat_map(|interval| &interval.3);
    assert!(reserves.into_iter().all(|reserve| *reserve >= -TOLERANCE));
    &certificate.promises
}

#[test]
fn a_good_motion_is_certified() {
    let obstacles = json!([
        { "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [0.0, 0.8, 0.3] } },
        { "shape": { "box": { "size_m": [4, 4, 0.1] } }, "pose": { "position_m": [0, 0, 1] } },
        { "shape": { "cylinder": { "radius_m": 0.1, "length_m": 0.4 } }, "pose": { "position_m": [0, -1.2, 0] } },
        { "shape": { "capsule": { "radius_m": 0.1, "length_m": 0.4 } }, "pose": { "position_m": [2, 0, 0] } },
        { "shape": { "half_space": {} }, "pose": { "position_m": [0, 0, -0.2] } }
    ]);
    let keys = json!({ "obstacles": obstacles, "self_collision": { "ignored_pairs": [] },
        "enforced_limits": { "acceleration": 30.0, "jerk": 300.0, "power": 300.0 } });
    let certification = certified(&scenario("certified", keys), &smooth(), &[], 0.0).expect("it is of this robot");
    assert_eq!(proved(&certification).len(), 8);
}

/// The torque of a slider of 1 kg is its acceleration: with limits below its largest one by 1e-6 the motion is beyond
/// them for about 1e-4 s, between samples.
#[test]
fn a_torque_beyond_its_limit_between_samples_is_refused() {
    // 12.5 T_8 with a bias that makes the extremum in the middle the largest, and moves it off the samples.
    let chebyshev = |x: f64| ((128.0 * x * x - 256.0) * x * x + 160.0) * x.powi(4) - 32.0 * x * x + 1.0;
    let acceleration = |x: f64| 12.5 * chebyshev(x) + 2.0 * (1.0 - x * x) + 0.4 * x;
    let velocity = |x: f64| {
        let eighth = 128.0 / 9.0 * x.powi(9) - 256.0 / 7.0 * x.powi(7) + 32.0 * x.powi(5);
        let eighth = eighth - 32.0 / 3.0 * x.powi(3) + x;
        12.5 * eighth + 2.0 * (x - x.powi(3) / 3.0) + 0.2 * x * x
    };
    let position = |x: f64| {
        let eighth = 12.8 / 9.0 * x.powi(10) - 32.0 / 7.0 * x.powi(8) + 16.0 / 3.0 * x.powi(6);
        let eighth = eighth - 8.0 / 3.0 * x.powi(4) + 0.5 * x * x;
        12.5 * eighth + x * x - x.powi(4) / 6.0 + 0.2 / 3.0 * x.powi(3)
    };
    let motion = curve(1, 12, 2.0, |_, t| [position(t - 1.0), velocity(t - 1.0)]);
    let top = (0..100_000).map(|k| acceleration(-1e-3 + 2e-8 * f64::from(k)));
    let top = top.fold(f64::MIN, f64::max);
    let limited = |effort: f64| slider(effort, &motion);
    let scenario = limited(top - 1e-6);
    let times = (0..=2000).map(|k| (0, 1e-3 * f64::from(k)));
    for sample in samples_at(&scenario.model, &motion, times) {
        assert!(sample.expect("one joint").u[0].abs() <= top - 1e-6);
    }
    let certification = certified(&scenario, &motion, &[], 0.0).expect("one joint");
    assert_eq!(certification.certificate, None);
    let [failure] = &certification.failures[..] else {
        panic!("{:?}", certification.failures);
    };
    assert!(failure.is_broken && failure.promise == "torque limits" && failure.place == "joint 'slide'");
    assert!((failure.value - top).abs() < 1e-7 && (failure.at_s - 1.0).abs() < 1e-3);
    // A little above, and it holds.
    assert_eq!(proved(&certified(&limited(top + 1e-6), &motion, &[], 0.0).expect("one joint")).len(), 3);
}

/// A scenario of the slider for this motion.
fn slider(effort: f64, motion: &Curve) -> Scenario {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("certify");
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    let name = format!("slider_{}.urdf", effort.to_bits());
    let urdf = SLIDER.replace("EFFORT", &format!("{effort:?}"));
    std::fs::write(folder.join(&name), urdf).expect("the folder is writable");
    let (start, end) = (motion.at(0.0).0, motion.at(motion.horizon()).0);
    let file = json!({ "robot": name, "horizon_s": 2.0, "q_start": [start[0]], "v_start": [start[1]],
        "q_goal": [end[0]], "v_goal": [end[1]] });
    Scenario::parse(&file.to_string(), "slider", &folder).expect("it is good")
}

/// Positions begin and end nearest to their limits, so the least distance there is the widest tube.
#[test]
fn positions_in_a_tube_are_certified() {
    let keys = json!({ "self_collision": "off", "enforced_limits": { "position": 0.9, "torque": 0.3 } });
    let (scenario, motion) = (scenario("tube", keys), smooth());
    let of = |tube: f64| certified(&scenario, &motion, &[], tube);
    let alone = of(0.0).expect("it is of this robot").certificate.expect("it is proved");
    let ends = [0.0, motion.horizon()].map(|t| motion.at(t).0);
    let bounds = (0..3).map(|joint| (joint, scenario.bound(Quantity::Position, joint)));
    let distances = bounds.flat_map(|(joint, bounds)| {
        let [lower, upper] = bounds.expect("it is enforced");
        (ends.iter()).map(move |q| (q[joint] - lower).min(upper - q[joint]))
    });
    let widest = distances.fold(f64::INFINITY, f64::min);
    assert!(widest.is_finite() && widest > 0.0);
    let inside = of(0.999 * widest).expect("it is of this robot");
    assert!(inside.failures.iter().all(|failure| failure.promise != "position limits"));
    let beyond = of(1.001 * widest).expect("it is of this robot");
    assert_eq!(beyond.certificate, None);
    let failure = beyond.failures.iter().find(|failure| failure.promise == "position limits");
    assert!(failure.is_some_and(|f| !f.is_broken && (f.value - f.bound).abs() < 0.01 * widest));
    let narrow = of(1e-3).expect("it is of this robot");
    assert_eq!(proved(&narrow), alone.promises);
    for wrong in [-1e-3, f64::NAN, f64::INFINITY] {
        assert!(of(wrong).is_err());
    }
}

fn refused(keys: Value, promise: &str, place: &str) {
    let test = format!("refused {promise}");
    let certification = certified(&scenario(&test, keys), &smooth(), &[], 0.0).expect("it is of this robot");
    assert_eq!(certification.certificate, None);
    let found = certification.failures.iter().find(|f| f.promise == promise && f.place.contains(place));
    let found = found.unwrap_or_else(|| panic!("{promise}: {:?}", certification.failures));
    assert!(found.is_broken, "{found:?}");
}

#[test]
fn broken_promises_are_refused() {
    // The largest velocity of the elbow is 15/8 rad/s, its largest acceleration 5.7735 rad/s^2, its jerk 60 rad/s^3.
    let limits = |key: &str, most: f64| json!({ "enforced_limits": { key: [null, null, most] } });
    refused(limits("max_velocity", 1.874_999), "velocity limits", "elbow");
    refused(limits("acceleration", 5.773_5), "acceleration limits", "elbow");
    refused(limits("jerk", 59.999), "jerk limits", "elbow");
    refused(json!({ "enforced_limits": { "torque": 0.02 } }), "torque limits", "slide");
    refused(json!({ "q_start": [-0.5, 0.2, 0.400_001] }), "start position", "");
    refused(json!({ "v_goal": [0.0, 1e-8, 0.0] }), "goal velocity", "");
    refused(json!({ "horizon_s": 1.001 }), "horizon", "");
    // The carriage passes the origin.
    let ball = json!({ "shape": { "sphere": { "radius_m": 0.021 } }, "pose": { "position_m": [0.0, 0.0, 0.03] } });
    refused(json!({ "obstacles": [ball] }), "obstacles", "carriage");
}

/// The box on the carriage is 40 mm high and begins 10 mm below a ball.
#[test]
fn shapes_that_come_too_close_are_refused() {
    let ball = |z: f64| {
        json!([{ "shape": { "sphere": { "radius_m": 0.02 } }, "clearance_m": 0.01,
            "pose": { "position_m": [-0.5, 0.0, z] } }])
    };
    for (z, holds) in [(0.050_001, true), (0.049_999, false)] {
        let certification = certified(&shaped("close", ball(z)), &smooth(), &[], 0.0).expect("it is of this robot");
        assert_eq!(certification.certificate.is_some(), holds, "{:?}", certification.failures);
        if let [failure] = &certification.failures[..] {
            assert!(failure.is_broken && failure.place.contains("'carriage'"), "{failure:?}");
        }
    }
}

/// Conditions along the way hold on intervals that reach beyond their times by rounding alone.
#[test]
fn broken_conditions_are_refused() {
    let kept = |condition: Value| json!({ "keep": [condition] });
    let speed =
        |most: f64, from: f64| kept(json!({ "speed": { "frame": "carriage", "most_m_s": most }, "from_s": from }));
    let promise = "conditions along the way";
    // The carriage has 15/8 m/s at most, and 0.768 m/s at 0.8 s.
    refused(speed(1.874_999, 0.0), promise, "speed of frame 'carriage'");
    refused(speed(0.767_999, 0.8), promise, "speed of frame 'carriage'");
    for good in [speed(1.875, 0.0), speed(0.768, 0.8)] {
        let certification = certified(&scenario("kept", good), &smooth(), &[], 0.0).expect("it is of this robot");
        assert!(proved(&certification).contains(&Quantity::Frame));
    }
    let poses = |keys: Value| {
        let mut poses = json!({ "frame": "upper" });
        for (key, value) in keys.as_object().expect("an object") {
            poses[key] = value.clone();
        }
        kept(json!({ "poses": poses }))
    };
    // The shoulder turns from 0.2 to -0.3 rad.
    let tilt = json!({ "axis": { "of_frame": [1, 0, 0], "direction": [1, 0, 0] }, "tolerance_rad": 0.299_999 });
    refused(poses(tilt), promise, "tilt of the axis");
    let turn = json!({ "orientation_xyzw": [0, 0, 0, 1], "tolerance_rad": 0.299_999 });
    refused(poses(turn), promise, "angle of frame 'upper'");
    refused(poses(json!({ "position_m": [0, 0, 0], "tolerance_m": 0.499_999 })), promise, "distance");
    let within = |size: f64, y: f64| {
        json!({ "box":
        { "size_m": [size, null, 0], "pose": { "position_m": [0, y, 0] } } })
    };
    refused(poses(within(0.999_998, 0.0)), promise, "bound of the position along x");
    let stand = |friction: f64| {
        json!({ "stand":
        { "frame": "rail", "half_length_m": 2.0, "half_width_m": 1.5, "friction": friction } })
    };
    refused(stand(0.1), "standing foot", "friction of foot 'rail'");
}

/// The end is in a set of poses, and the motion passes points at the times that are given.
#[test]
fn goals_and_waypoints_off_their_places_are_refused() {
    // The fore arm is turned by 1.1 rad about z, half a metre along the upper one from (0.5, 0).
    let (sin, cos) = (0.3_f64.sin(), 0.3_f64.cos());
    let goal = |y: f64, tolerance: f64| {
        json!({ "frame": "fore", "position_m": [0.5 + 0.5 * cos, y - 0.5 * sin, 0.0],
        "axis": { "of_frame": [1, 0, 0], "direction": [1.1_f64.cos(), 1.1_f64.sin(), 0] }, "tolerance_rad": tolerance })
    };
    let of = |goals: Value, points: Value, times: &[f64]| {
        let scenario = scenario("placed", json!({ "goal": goals, "waypoints": points }));
        certified(&scenario, &smooth(), times, 0.0).expect("it is of this robot")
    };
    let middle = json!({ "q": [0.0, -0.05, 0.9] });
    let along = json!({ "poses": { "frame": "carriage", "position_m": [0.0, 0.0, 0.0] } });
    let good = of(json!([goal(0.0, 1e-3), goal(1e-3, 0.1)]), json!([middle, along]), &[0.5, 0.5]);
    let certificate = good.certificate.expect("it is proved");
    assert!(certificate.goal.is_some_and(|reserve| reserve > 6e-7 && reserve < 7e-7));
    assert!(certificate.complete && certificate.waypoints.len() == 2);
    let still = json!({ "q": [0.0, -0.05, 0.9], "stop": true });
    for (goals, points, times, promise, at_s) in [
        (json!(goal(1e-6, 0.1)), json!([]), vec![], "goal", 1.0),
        (json!(goal(0.0, 1e-3)), json!([middle]), vec![0.500_001], "waypoints[0]", 0.500_001),
        (json!(goal(0.0, 1e-3)), json!([middle, still]), vec![0.5, 0.5], "waypoints[1]", 0.5),
    ] {
        let failed = of(goals, points, &times);
        let [failure] = &failed.failures[..] else {
            panic!("{promise}: {:?}", failed.failures);
        };
        assert!(failure.is_broken && failure.promise == promise && failure.at_s == at_s, "{failure:?}");
    }
    let scenario = scenario("untimed", json!({ "waypoints": [middle] }));
    let error = certified(&scenario, &smooth(), &[], 0.0).expect_err("no time is given");
    assert!(error.to_string().contains("waypoint_times_s"), "{error}");
}

/// A certificate names the parts that no proof covers.
#[test]
fn parts_without_proofs_are_listed() {
    let keys = json!({ "passive": ["elbow"], "continuity": "velocity", "robot_shape": "joint_frames",
        "payload": { "link": "fore", "mass_kg": 0.1, "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } } },
        "obstacles": [{ "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [0.0, 5.0, 0.0] } }] });
    let certification = certified(&scenario("listed", keys), &smooth(), &[], 0.0).expect("it is of this robot");
    let certificate = certification.certificate.expect("the rest is proved");
    let listed: Vec<_> = certificate.left_out().collect();
    let [("clearance_m", _) | ("obstacles", _), .., ("passive", _)] = listed[..] else {
        panic!("{listed:?}");
    };
    let reason = &certificate.keys["obstacles"];
    assert!(reason.starts_with(LEFT_OUT) && reason.contains("a load that is a ball can be certified"), "{reason}");
    assert!(!certificate.complete);
}

/// Constraints that were added in code are left out.
#[test]
fn constraints_of_code_are_listed() {
    let mut scenario = scenario("of code", json!({}));
    scenario.add_constraint(Bounds(Vec::new()));
    let certification = certified(&scenario, &smooth(), &[], 0.0).expect("it is of this robot");
    let certificate = certification.certificate.expect("the rest is proved");
    assert!(!certificate.complete);
    assert_eq!(certificate.left_out().count(), 1);
}
