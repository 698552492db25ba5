//! Conditions that are kept along the way.

use crate::written::{load, sampled, solved_once, with};
use aghf::curve::Curve;
use aghf::direct::DirectSettings;
use aghf::dynamics::{Data, forward_kinematics, frame_jacobian, frame_placement};
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf_scenario::certify::{Texts, certify};
use aghf_scenario::judge::{Check, Tolerances, Trajectory, judge};
use aghf_scenario::{DirectOptions, Quantity, Scenario, Solve, Verdict};
use nalgebra::{DMatrix, DVector, Vector3};
use proptest::prelude::*;
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
    let failed = judged(&loose).checks.into_iter().filter(|row| !row.outcome.is_good());
    assert_eq!(failed.map(|row| row.check).collect::<Vec<_>>(), [Check::Bounds(Quantity::Frame)]);
}

/// Two arms carry a bar over a post: the relative pose is that of the start at all times, by the judge and by the poses
/// of the hands.
#[test]
fn two_arms_carry_a_bar() {
    let bar = Scenario::load("two_arms_bar_01").expect("built in");
    let report = solved_once(&bar);
    assert!(report.summary.success, "{:?}", report.summary.failure);
    let motion = sampled(&bar, &report);
    let judged = judge(&bar, &motion, Tolerances::default()).expect("its joints");
    assert!(judged.valid, "{:?}", judged.worst());
    let kept = judged.checks.iter().find(|row| row.check == Check::Bounds(Quantity::Frame));
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
    assert!(speed(&slow, true) < bound + 1e-4, "{} {bound}", speed(&slow, true));
    assert!(speed(&slow, false) > bound, "{} {bound}", speed(&slow, false));
}

#[test]
fn what_cannot_be_kept_is_refused() {
    let refused = |keep: Value| load("refused", &kinova(json!([keep]))).expect_err("it is refused");
    let speed = json!({ "frame": TOOL, "most_m_s": 0.2 });
    let plane = json!({ "frame": TOOL, "box": { "size_m": [null, null, 0], "pose": { "position_m": [0, 0, 0.4] } } });
    for (keep, words) in [
        (json!({}), "keep[0]: one of the keys poses and speed is needed"),
        (json!({ "poses": plane, "speed": speed }), "keep[0]: one of the keys poses and speed is needed"),
        (json!({ "poses": plane, "to_s": 1.0 }), "keep[0]: rows: equalities: position along z"),
        (json!({ "speed": speed, "from_s": 2.0, "to_s": 1.0 }), "keep[0]: it is kept from 2 s to 1 s"),
        (json!({ "speed": with(speed.clone(), json!({ "most_m_s": 0 })) }), "keep[0].speed.most_m_s: it is 0"),
        (json!({ "speed": with(speed.clone(), json!({ "frame": "base_link" })) }), "keep[0].speed.frame: the robot"),
        (json!({ "poses": { "frame": TOOL } }), "keep[0].poses: one of the keys position_m"),
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
    assert!(error.contains("q_start: it violates position along z of frame"), "{error}");
}

/// Windows for which the motion has no time, or too little, are refused with their times, whatever their order.
#[test]
fn empty_windows_are_refused() {
    let speed = |window: Value| with(json!({ "speed": { "frame": TOOL, "most_m_s": 0.2 } }), window);
    let load = |scenario: Value, window: Value| load("window", &with(scenario, json!({ "keep": [speed(window)] })));
    let fixed = kinova(json!([]));
    for (window, words) in [
        (json!({ "from_s": 2.0, "to_s": 1.0 }), "from 2 s to 1 s, of which the motion, 3 s at most"),
        (json!({ "from_s": 1.0, "to_s": 1.0 }), "from 1 s to 1 s"),
        (json!({ "from_s": 1.0, "to_s": 1.0000001 }), "from 1 s to 1.0000001 s"),
        (json!({ "from_s": 3.0 }), "from 3 s to the end"),
        (json!({ "from_s": 2000.0, "to_s": 3000.0 }), "from 2000 s to 3000 s"),
        (json!({ "to_s": 0.0 }), "from the start to 0 s"),
        (json!({ "from_s": -2.0, "to_s": -1.0 }), "from -2 s to -1 s"),
        (json!({ "from_s": -2.0, "to_s": 1e-9 }), "from -2 s to 1e-9 s"),
        (json!({ "from_s": 2.9999999, "to_s": 9.0 }), "from 2.9999999 s to 9 s"),
    ] {
        let error = load(fixed.clone(), window).expect_err("it is refused");
        assert!(error.starts_with("keep[0]: it is kept ") && error.contains(words), "{error}");
    }
    load(fixed, json!({ "from_s": 2.99, "to_s": 9.0 })).expect("it is good");
}

/// A free horizon may end before a window, which only the motion shows: then a note says so.
#[test]
fn a_window_beyond_the_end_of_the_motion_is_noted() {
    let load = |from: f64| {
        let speed = json!({ "speed": { "frame": TOOL, "most_m_s": 2.0 }, "from_s": from });
        let free = json!({
            "free_horizon": { "shortest_s": 1.0, "longest_s": 4.0 }, "objective": { "time": 300.0, "effort": 1.0 },
        });
        load("window_free", &with(kinova(json!([speed])), free))
    };
    let error = load(4.0).expect_err("it is refused");
    assert!(error.contains("the motion, 4 s at most"), "{error}");
    let late = load(3.9).expect("it is good");
    let report = solved_once(&late);
    assert!(report.curve.horizon() < 3.9, "{}", report.curve.horizon());
    let note = "keep[0] is not tested: the motion ends at ";
    assert!(report.summary.notes.iter().any(|found| found.starts_with(note)));
    let early = load(0.1).expect("it is good");
    let notes = solved_once(&early).summary.notes;
    assert!(!notes.iter().any(|found| found.starts_with(note)), "{notes:?}");
}

/// The shortest horizon of a motion with a condition in a window, if it is free, s.
const MIN_HORIZON: f64 = 1.0;

/// A motion between random configurations of one of two robots with a condition in a random window, short, long or
/// open, which the motion without it breaks by some share; on a given horizon or a free one.
#[derive(Debug)]
struct Windowed {
    scenario: Value,
    tool: &'static str,
    times: [f64; 2],
    share: f64,
    is_speed: bool,
}

impl Windowed {
    fn any() -> impl Strategy<Value = Self> {
        let length = prop_oneof![0.02..0.1, 0.1..0.5, 0.5..2.0, Just(f64::INFINITY)];
        let windows = (0.0..1.9, length).prop_map(|(from, length)| [from, from + length]);
        let ends = proptest::array::uniform14(-1.0..1.0);
        let all = (ends, any::<[bool; 3]>(), windows, 0.6..0.95);
        all.prop_map(|(ends, [planar, is_free, is_speed], times, share)| {
            let (robot, tool, n) = if planar { ("pendulum_3", "link_3", 3) } else { ("kinova_gen3", TOOL, 7) };
            let rest = [0.0, 0.5, 0.0, 1.6, 0.0, 1.0, 0.0];
            let of_end =
                |end: usize, range: f64| -> Vec<f64> { (0..n).map(|i| rest[i] + range * ends[7 * end + i]).collect() };
            let mut scenario = json!({
                "robot": robot, "horizon_s": 2.0, "q_start": of_end(0, 0.3), "q_goal": of_end(1, 0.7),
                "v_start": vec![0.0; n], "v_goal": vec![0.0; n],
            });
            if is_free {
                scenario["free_horizon"] = json!({ "shortest_s": MIN_HORIZON, "longest_s": 3.0 });
                scenario["objective"] = json!({ "time": 40.0, "effort": 1.0 });
            }
            Self { scenario, tool, times, share, is_speed }
        })
    }

    /// The times of the window on a motion, many of them, its ends included; none beyond the end of the motion.
    fn dense(&self, curve: &Curve) -> impl Iterator<Item = f64> {
        let [from, to] = self.times;
        let last = to.min(curve.horizon());
        let times = (0..=2000).map(move |k| from + (last - from) * f64::from(k) / 2000.0);
        times.filter(move |_| from <= last)
    }

    /// The largest speed of the tool, or its largest distance from a place, in the window.
    fn largest(&self, model: &Model, curve: &Curve, place: &Vector3<f64>) -> f64 {
        let n = model.dof();
        let frame = model.frames().iter().find(|frame| frame.name == self.tool).expect("a link");
        let (mut data, mut jacobian) = (Data::new(model), DMatrix::zeros(6, n));
        self.dense(curve).fold(f64::NEG_INFINITY, |most, t| {
            let (x, _) = curve.at(t);
            let (q, v) = x.as_slice().split_at(n);
            let value = if self.is_speed {
                frame_jacobian(model, &mut data, q, frame, &mut jacobian).expect("its joints");
                (&jacobian * DVector::from_column_slice(v)).rows(3, 3).norm()
            } else {
                (pose_of(model, self.tool, q).translation - place).norm()
            };
            most.max(value)
        })
    }
}

proptest! {
    #![proptest_config(crate::common::config(6))]

    /// A condition in a window is broken nowhere in it, at its ends neither, as a dense evaluation and the certificate
    /// say.
    #[test]
    fn a_condition_is_kept_at_the_ends_of_its_window(of in Windowed::any()) {
        let free = load("window_free", &of.scenario).expect("it is good");
        let curve = solved_once(&free).curve;
        let middle = 0.5 * (of.times[0] + of.times[1]).min(curve.horizon());
        let place = pose_of(&free.model, of.tool, &curve.at(middle).0.as_slice()[..free.model.dof()]).translation;
        let mut bound = of.share * of.largest(&free.model, &curve, &place);
        if !of.is_speed && of.times[1] >= MIN_HORIZON {
            // The end of the motion is given.
            let last = pose_of(&free.model, of.tool, &free.file.q_goal).translation;
            bound = bound.max(1.01 * (last - place).norm());
        }
        prop_assume!(bound > 1e-3);
        let condition = if of.is_speed {
            json!({ "speed": { "frame": of.tool, "most_m_s": bound } })
        } else {
            json!({ "poses": { "frame": of.tool, "position_m": place.as_slice(), "tolerance_m": bound } })
        };
        let times = json!({ "from_s": of.times[0], "to_s": of.times[1] });
        let kept = with(of.scenario.clone(), json!({ "keep": [with(condition, times)] }));
        let kept = load("window_kept", &kept).expect("it is good");
        let options = DirectOptions { starts: Some(1), time_limit_s: Some(20.0), ..DirectOptions::default() };
        let found = Solve::new(&kept).options(options).run().expect("it is good");
        let most = of.largest(&kept.model, &found.curve, &place);
        let texts = Texts { scenario: &[], run: "" };
        let proved = certify(&kept, &found.summary.curve, texts, &[], 0.0).expect("its joints");
        if found.summary.success && found.curve.horizon() < of.times[0] {
            let is_noted = found.summary.notes.iter().any(|note| note.starts_with("keep[0] is not tested: "));
            prop_assert!(is_noted, "{:?}", found.summary.notes);
            prop_assert!(proved.certificate.is_none());
            for failure in &proved.failures {
                prop_assert!(failure.promise.ends_with("at no time of the motion"), "{failure:?}");
            }
        } else if found.summary.success {
            prop_assert!(most < bound + 1e-6, "{}", most - bound);
            // A motion that is no minimum keeps its limits to the tolerance of the search, without the reserve.
            let is_optimal = found.summary.verdict == Verdict::Optimal;
            for failure in &proved.failures {
                let is_within = (failure.value - failure.bound).abs() <= DirectSettings::FEASIBLE;
                prop_assert!(!is_optimal && is_within, "{failure:?}");
            }
        }
    }
}
