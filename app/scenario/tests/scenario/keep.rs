//! Conditions that are kept along the way.

use crate::written::{load, solved_once, with};
use aghf::dynamics::{forward_kinematics, frame_placement};
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf_scenario::Scenario;
use aghf_scenario::judge::{Check, Tolerances, Trajectory, judge, sufficient_samples};
use nalgebra::Vector3;
use serde_json::{Value, json};

const TOOL: &str = "end_effector_link";

fn kinova(keep: Value) -> Value {
    json!({
        "robot": "kinova_gen3", "horizon_s": 3.0,
        "q_start": [0.0, 0.5, 0.0, 1.6, 0.0, 1.0, 0.0], "v_start": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "q_goal": [1.4, 0.9, 0.0, 1.9, 0.0, 0.9, 0.0], "v_goal": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "keep": keep,
    })
}

fn pose(model: &Model, q: &[f64]) -> Placement<f64> {
    pose_of(model, TOOL, q)
}

fn pose_of(model: &Model, link: &str, q: &[f64]) -> Placement<f64> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements).expect("its joints");
    let mut frames = model.frames().iter();
    let frame = frames.find(|frame| frame.name == link).expect("a link");
    frame_placement(frame, &placements).expect("its frame")
}

fn samples(scenario: &Scenario) -> Trajectory {
    let report = solved_once(scenario);
    let samples = aghf::motion::sample(&scenario.model, &report.curve, 300);
    Trajectory::of_samples(samples.expect("its joints"))
}

/// A tilt that the motion takes without the condition is kept with it, and the judge proves it.
#[test]
fn a_tool_stays_upright() {
    let free = load("free", &kinova(json!([]))).expect("it is good");
    let up = |q: &[f64]| pose(&free.model, q).rotation * Vector3::z();
    let (from, to) = (up(&free.file.q_start), up(&free.file.q_goal));
    let tilt = |motion: &Trajectory| {
        let tilts = motion.q.iter().map(|q| up(q).angle(&from));
        tilts.fold(0.0, f64::max)
    };
    let bound = from.angle(&to) + 0.01;
    let keep = json!([{ "poses": { "frame": TOOL, "axis": { "of_frame": [0, 0, 1], "direction": from.as_slice() },
        "tolerance_rad": bound } }]);
    let kept = load("kept", &kinova(keep)).expect("it is good");
    let (loose, upright) = (samples(&free), samples(&kept));
    assert!(tilt(&loose) > bound + 0.02, "{} {bound}", tilt(&loose));
    assert!(tilt(&upright) < bound + 1e-6, "{} {bound}", tilt(&upright));
    let judged = |motion| judge(&kept, motion, Tolerances::default()).expect("its joints");
    assert!(judged(&upright).valid);
    let failed = judged(&loose)
        .checks
        .into_iter()
        .filter(|row| !row.outcome.is_good());
    assert_eq!(
        failed.map(|row| row.check).collect::<Vec<_>>(),
        [Check::Kept]
    );
}

/// Two arms carry a bar over a post: the relative pose is that of the start at all times, by the judge and by the poses
/// of the hands.
#[test]
fn two_arms_carry_a_bar() {
    let bar = Scenario::load("two_arms_bar_01").expect("built in");
    let report = solved_once(&bar);
    assert!(report.summary.success, "{:?}", report.summary.failure);
    let intervals = sufficient_samples(&bar, &report.curve).expect("its joints") - 1;
    let samples = aghf::motion::sample(&bar.model, &report.curve, intervals);
    let motion = Trajectory::of_samples(samples.expect("its joints"));
    let judged = judge(&bar, &motion, Tolerances::default()).expect("its joints");
    assert!(judged.valid, "{:?}", judged.worst());
    let kept = judged.checks.iter().find(|row| row.check == Check::Kept);
    let worst = kept.and_then(|row| row.worst.clone()).expect("it is kept");
    assert!(worst.value < 1e-5, "{worst:?}");
    for q in &motion.q {
        let [one, other] = ["arm_1", "arm_2"].map(|arm| {
            let hand = format!("{arm}_end_effector_link");
            pose_of(&bar.model, &hand, q)
        });
        let off = other.translation - one.translation - one.rotation * Vector3::new(0.0, -0.5, 0.0);
        let turned = other.rotation - one.rotation;
        assert!(off.norm() < 1e-5 && turned.norm() < 1e-5, "{off} {turned}");
    }
}

/// A goal with fewer digits than the condition needs is refused with its row.
#[test]
fn rounded_configurations_of_two_hands_are_refused() {
    let mut bar = Scenario::load("two_arms_bar_01").expect("built in");
    bar.file.q_goal[3] += 1e-5;
    let error = bar.check_feasible().expect_err("it is refused").to_string();
    assert!(error.contains("q_goal: it violates"), "{error}");
    assert!(error.contains("arm_2_end_effector_link"), "{error}");
}

/// A bound on the speed holds after its time and not before.
#[test]
fn a_speed_is_kept_from_a_time_on() {
    let free = load("free", &kinova(json!([]))).expect("it is good");
    let speed = |motion: &Trajectory, late: bool| {
        let steps = 0..motion.times.len() - 1;
        let steps = steps.filter(|k| (motion.times[*k] >= 1.5) == late);
        let speed = |k: usize| {
            let [a, b] = [k, k + 1].map(|k| pose(&free.model, &motion.q[k]).translation);
            (b - a).norm() / (motion.times[k + 1] - motion.times[k])
        };
        steps.map(speed).fold(0.0, f64::max)
    };
    let loose = samples(&free);
    let bound = 0.7 * speed(&loose, true);
    let keep = json!([{ "speed": { "frame": TOOL, "most_m_s": bound }, "from_s": 1.5 }]);
    let slow = samples(&load("slow", &kinova(keep)).expect("it is good"));
    assert!(
        speed(&slow, true) < bound + 1e-4,
        "{} {bound}",
        speed(&slow, true)
    );
    assert!(
        speed(&slow, false) > bound,
        "{} {bound}",
        speed(&slow, false)
    );
}

#[test]
fn what_cannot_be_kept_is_refused() {
    let refused = |keep: Value| load("refused", &kinova(json!([keep]))).expect_err("it is refused");
    let speed = json!({ "frame": TOOL, "most_m_s": 0.2 });
    let plane = json!({ "frame": TOOL, "box": { "size_m": [null, null, 0], "pose": { "position_m": [0, 0, 0.4] } } });
    for (keep, words) in [
        (
            json!({}),
            "keep[0]: one of the keys poses and speed is needed",
        ),
        (
            json!({ "poses": plane, "speed": speed }),
            "keep[0]: one of the keys poses and speed is needed",
        ),
        (
            json!({ "poses": plane, "to_s": 1.0 }),
            "keep[0]: rows: equalities: position along z",
        ),
        (
            json!({ "speed": speed, "from_s": 2.0, "to_s": 1.0 }),
            "keep[0]: rows: times: they are 2 s and 1 s",
        ),
        (
            json!({ "speed": with(speed.clone(), json!({ "most_m_s": 0 })) }),
            "keep[0].speed.most_m_s: it is 0",
        ),
        (
            json!({ "speed": with(speed.clone(), json!({ "frame": "base_link" })) }),
            "keep[0].speed.frame: the robot",
        ),
        (
            json!({ "poses": { "frame": TOOL } }),
            "keep[0].poses: one of the keys position_m",
        ),
        (
            json!({ "poses": with(plane.clone(), json!({ "relative_to": TOOL })) }),
            "keep[0].poses.relative_to: the robot",
        ),
    ] {
        let error = refused(keep);
        assert!(error.starts_with(words), "{error}");
    }
    // The start is not in the plane.
    let off = load("off", &kinova(json!([{ "poses": plane }]))).expect("it is good");
    let error = off.check_feasible().expect_err("it is refused").to_string();
    assert!(
        error.contains("q_start: it violates position along z of frame"),
        "{error}"
    );
}
