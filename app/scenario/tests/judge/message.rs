//! Motions from messages of ROS 2.

use crate::robot::{FROM, TO, good, scenario};
use aghf_scenario::JointTrajectory;
use aghf_scenario::judge::Trajectory;
use serde_json::{Value, json};

/// A message with two points, the joints in another order than the robot has them.
fn message() -> Value {
    let point = |sec: i32, q: [f64; 3]| json!({ "positions": q, "time_from_start": { "sec": sec, "nanosec": 500 } });
    let points = [point(0, [3.0, 1.0, 2.0]), point(2, [6.0, 4.0, 5.0])];
    json!({ "joint_names": ["elbow", "slide", "shoulder"], "points": points })
}

#[test]
fn joints_are_found_by_name() {
    let scenario = scenario("message", json!({}));
    let read = JointTrajectory::parse(&message().to_string(), "m.json").expect("it is one");
    let motion = Trajectory::of_message(&read, "m.json", &scenario.model).expect("it is good");
    assert_eq!(motion.times, [5e-7, 2.0 + 5e-7]);
    assert_eq!(motion.q, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert!([motion.v, motion.a, motion.u].iter().all(Option::is_none));
}

/// A change of a message, and the element and the words that its error has.
type Wrong = (fn(&mut Value), &'static str);

#[test]
fn errors_name_the_point() {
    let scenario = scenario("message_errors", json!({}));
    let cases: [Wrong; 7] = [
        (|m| m["joint_names"][0] = json!("wrist"), "m.yaml: joint_names: they are not"),
        (|m| m["joint_names"] = json!(["elbow", "slide"]), "joint_names: they are not"),
        (|m| m["points"][1]["velocities"] = json!([1, 2]), "points[0].velocities: it has 0 numbers"),
        (|m| m["points"][1]["positions"] = json!([1]), "points[1].positions: it has 1 numbers"),
        (|m| m["points"][1]["time_from_start"]["sec"] = json!(0), "points[1].time_from_start"),
        (|m| m["points"] = json!([]), "points: 0 are given"),
        (|m| m["points"][0]["speed"] = json!(1), "points[0].speed: unknown field"),
    ];
    for (change, words) in cases {
        let mut wrong = message();
        change(&mut wrong);
        let read = JointTrajectory::parse(&wrong.to_string(), "m.yaml");
        let read = read.and_then(|m| Trajectory::of_message(&m, "m.yaml", &scenario.model));
        let error = read.expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    }
}

/// A motion is the same after it went through a message.
#[test]
fn a_motion_survives_a_message() {
    use aghf::motion::Sample;
    let scenario = scenario("message_whole", json!({}));
    let whole = good(&scenario.model, FROM, TO, 11);
    let [v, a, u] = [&whole.v, &whole.a, &whole.u].map(|of| of.as_ref().expect("given"));
    let samples = (0..11).map(|k| Sample {
        t: whole.times[k],
        q: whole.q[k].clone(),
        v: v[k].clone(),
        a: a[k].clone(),
        u: u[k].clone(),
        qdot: v[k].clone(),
    });
    let samples: Vec<_> = samples.collect();
    assert_eq!(Trajectory::of_samples(samples.clone()), whole);
    let message = JointTrajectory::of_samples(&scenario.model, samples);
    let back = Trajectory::of_message(&message, "it", &scenario.model).expect("it is good");
    let off = back.times.iter().zip(&whole.times).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) <= 0.5e-9);
    assert_eq!(Trajectory { times: whole.times.clone(), ..back }, whole);
}
