//! Joints without a motor: how a scenario names them, what is asked of a motion, and how it is simulated.

use crate::written::{load, with};
use aghf::curve::{Chebyshev, Curve};
use aghf::dynamics::{Data, aba};
use aghf::model::Model;
use aghf::motion::{Feedback, control_at, replay_error, simulate};
use aghf::urdf::builtin_robot;
use aghf_scenario::{DirectOptions, Feasibility, FlowOptions, PASSIVE_TORQUE_SHARE, Quantity, Solve, SolveReport};
use nalgebra::DMatrix;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// A pole that hangs and is to hang a little further on.
pub fn hanging(keys: Value) -> Value {
    let scenario = json!({
        "robot": "cart_pole", "passive": ["pivot"], "horizon_s": 2.0,
        "q_start": [0.0, 0.0], "v_start": [0.0, 0.0], "q_goal": [0.3, 0.0], "v_goal": [0.0, 0.0],
    });
    with(scenario, keys)
}

/// A pole that stands still upright as nearly as numbers say, where a simulation never ends in the goal to all digits.
fn upright(keys: Value) -> Value {
    let still = json!({ "q_start": [0.0, PI], "q_goal": [0.0, PI], "success_threshold": 1e-30 });
    with(hanging(still), keys)
}

fn solved(name: &str, scenario: &Value) -> SolveReport {
    let scenario = load(name, scenario).expect("it is good");
    let options = DirectOptions { degree: Some(8), starts: Some(1), ..DirectOptions::default() };
    Solve::new(&scenario).options(options.clone()).run().expect("it is good")
}

#[test]
fn passive_joints_have_a_torque_limit_of_zero_whatever_is_enforced() {
    let free = json!({ "position": false, "velocity": false, "torque": false });
    for (enforced, other) in [(json!({}), Some(20.0)), (free.clone(), None)] {
        let keys = json!({ "enforced_limits": enforced });
        let scenario = load("limits", &hanging(keys)).expect("it is good");
        assert_eq!(scenario.passive(), [1]);
        assert_eq!(scenario.torque_limits().0, [other, Some(0.0)]);
        assert!(scenario.torque_limits().is_equality(scenario.torque_limits().dim() - 1));
        assert_eq!(scenario.bound(Quantity::Torque, 1), Some([0.0, 0.0]));
        assert!(!scenario.is_free());
        let written = serde_json::to_value(&scenario.file).expect("numbers");
        assert_eq!(written["passive"], json!(["pivot"]));
    }
    // More starts than of a robot with all motors, with limits or without; no key without passive joints.
    let starts = |keys| {
        let scenario = load("starts", &keys).expect("it is good");
        let settings = DirectOptions::default().settings(&scenario);
        settings.expect("it is good").starts
    };
    let unlimited = json!({ "enforced_limits": free });
    for keys in [unlimited.clone(), json!({})] {
        assert_eq!(starts(hanging(keys.clone())), 40);
        assert!(starts(with(hanging(keys), json!({ "passive": [] }))) <= 32);
    }
    let driven = with(hanging(unlimited), json!({ "passive": [] }));
    let driven = load("driven", &driven).expect("it is good");
    assert!(driven.is_free() && driven.passive().is_empty());
    let written = serde_json::to_value(&driven.file).expect("numbers");
    assert_eq!(written.get("passive"), None);
    // In the order of the robot.
    let wrists = json!({
        "robot": "kinova_gen3", "locked_joints": { "joint_3": 0.0 }, "passive": ["joint_7", "joint_5"],
        "robot_shape": "joint_frames", "horizon_s": 2.0,
        "q_start": vec![0.0; 6], "v_start": vec![0.0; 6], "q_goal": vec![0.0; 6], "v_goal": vec![0.0; 6],
    });
    assert_eq!(load("wrists", &wrists).expect("it is good").passive(), [3, 5]);
}

/// At rest gravity asks nothing of a passive joint.
#[test]
fn an_end_that_a_passive_joint_cannot_hold_is_refused() {
    let refusal = |keys: Value| {
        let scenario = load("rest", &hanging(keys)).expect("it is good");
        scenario.check_feasible().err().map(|e| e.to_string())
    };
    assert_eq!(refusal(json!({})), None);
    assert_eq!(refusal(json!({ "q_goal": [0.3, PI] })), None);
    let words = "rest: q_goal: joint 'pivot' needs 0.143 N m to hold the robot at rest, it is passive";
    // 0.3 kg x 9.81 m/s^2 x 0.5 m x sin 0.097
    assert_eq!(refusal(json!({ "q_goal": [0.3, 0.097] })).as_deref(), Some(words));
    assert!(refusal(json!({ "q_start": [0.0, -0.097] })).is_some());
    assert_eq!(refusal(json!({ "q_goal": [0.3, 0.097], "passive": [] })), None);
    assert_eq!(refusal(json!({ "q_goal": [0.3, 0.097], "v_goal": [0.0, 0.1] })), None);
    assert_eq!(refusal(json!({ "q_goal": [0.3, 0.097], "free_final_velocity": true })), None);
}

#[test]
fn the_flow_knows_no_passive_joints() {
    let scenario = load("flow", &hanging(json!({}))).expect("it is good");
    let options = FlowOptions::default();
    let error = Solve::new(&scenario).options(options.clone()).run().expect_err("not yet").to_string();
    assert_eq!(error, "flow: passive: supported by the methods 'duals' and 'two_phases', not by the published flow");
}

/// A motion of the double pendulum that needs torques at both joints.
fn bent(model: &Model) -> Curve {
    let chebyshev = Chebyshev::new(9, 1.5).expect("a good degree");
    let times = chebyshev.times().to_vec();
    let n = model.dof();
    let x = DMatrix::from_fn(2 * n, 10, |i, k| {
        let (w, t) = (1.0 + (i % n) as f64, times[k]);
        if i < n { (w * t).sin() } else { w * (w * t).cos() }
    });
    Curve::new(chebyshev, x).expect("sizes agree")
}

/// The state in the end by Runge-Kutta's method, where `driven` joints have the torque of the curve and the feedback.
fn by_runge_kutta(model: &Model, curve: &Curve, gains: Feedback, driven: &[usize]) -> Vec<f64> {
    let (n, steps) = (model.dof(), 3000);
    let data = &mut Data::new(model);
    let mut rates = |t: f64, y: &[f64]| {
        let (x, xdot) = curve.at_in(0, t);
        let (mut wanted, mut u, mut a) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        control_at(model, data, &x, &xdot, &mut wanted).expect("of this robot");
        for i in driven {
            u[*i] = wanted[*i] - gains.kp * (y[*i] - x[*i]) - gains.kv * (y[n + i] - x[n + i]);
        }
        aba(model, data, &y[..n], &y[n..], &u, &mut a).expect("of this robot");
        [&y[n..], &a].concat()
    };
    let h = curve.horizon() / f64::from(steps);
    let add = |y: &[f64], s: f64, k: &[f64]| -> Vec<f64> { y.iter().zip(k).map(|(y, k)| y + s * k).collect() };
    let mut y = curve.x().column(0).as_slice().to_vec();
    for step in 0..steps {
        let t = h * f64::from(step);
        let k1 = rates(t, &y);
        let k2 = rates(t + 0.5 * h, &add(&y, 0.5 * h, &k1));
        let k3 = rates(t + 0.5 * h, &add(&y, 0.5 * h, &k2));
        let k4 = rates(t + h, &add(&y, h, &k3));
        for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
            y = add(&y, weight * h / 6.0, &k);
        }
    }
    y
}

#[test]
fn a_passive_joint_gets_neither_torque_nor_feedback() {
    let model = builtin_robot("pendulum_2").expect("built in");
    let curve = bent(&model);
    let gains = Feedback { kp: 7.0, kv: 3.0 };
    let mut ends = Vec::new();
    for (passive, driven) in [(&[][..], &[0, 1][..]), (&[1], &[0]), (&[0], &[1]), (&[1, 0], &[])] {
        let simulated = simulate(&model, &curve, gains, passive).expect("of this robot");
        assert_eq!(simulated.failure, None);
        let expected = by_runge_kutta(&model, &curve, gains, driven);
        for (a, b) in simulated.state.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-5, "{passive:?}: {:?}, {expected:?}", simulated.state);
        }
        ends.push(simulated.error_inf);
    }
    assert!(ends[0] < 1e-5 && ends[1..].iter().all(|error| *error > 0.5), "{ends:?}");
    // Nor over one interval.
    let replay = |passive: &[usize]| replay_error(&model, &curve, passive).expect("of this robot").expect("to the end");
    assert!(replay(&[1]) > 100.0 * replay(&[]), "{} {}", replay(&[1]), replay(&[]));
    let error = simulate(&model, &curve, gains, &[2]).expect_err("there are two").to_string();
    assert_eq!(error, "pendulum_2: passive: the robot has 2 joints, there is none with index 2");
    assert!(replay_error(&model, &curve, &[0, 2]).is_err());
}

/// The torque of a passive joint is judged beside the largest one.
#[test]
fn a_passive_torque_is_judged_by_its_share_of_the_largest() {
    let scenario = load("share", &hanging(json!({}))).expect("it is good");
    // The cart swings to and fro below the hanging pole, which is held by a small torque; in the middle and the ends
    // that is most.
    let along = |of_pole: f64| {
        let chebyshev = Chebyshev::new(12, 2.0).expect("a good degree");
        let times = chebyshev.times().to_vec();
        let x = DMatrix::from_fn(4, 13, |i, k| {
            let (s, w) = (times[k] - 1.0, 0.3);
            match i {
                0 => w * s * s,
                1 => of_pole * s * s,
                2 => 2.0 * w * s,
                _ => 2.0 * of_pole * s,
            }
        });
        let curve = Curve::new(chebyshev, x).expect("sizes agree");
        Feasibility::of(&scenario, &curve).expect("of this robot")
    };
    let found = along(0.0);
    // (1 + 0.3) x 0.6 N on the cart; 0.3 x 0.5 x 0.6 N m at the pole.
    assert!((found.largest_torque - 0.78).abs() < 1e-9, "{found:?}");
    let passive = found.largest_passive_torque.expect("one is passive");
    assert!((passive - 0.09).abs() < 1e-9, "{found:?}");
    let [violation] = &found.limit_violations[..] else {
        panic!("{found:?}");
    };
    assert_eq!((violation.limit, violation.unit.as_str(), violation.enforced), (Quantity::Passive, "N m", true));
    let reason = found.reason(1e-6).expect("it is too much");
    assert!(
        reason.starts_with("violated: torque of the passive joint 'pivot' by 0.0900 N m at ")
            && reason.ends_with(", above 0.001 of the largest torque, 0.780"),
        "{reason}"
    );
    // By the share, not by the tolerance of other limits, unless that is more.
    let share = |found: &mut Feasibility, of_most: f64| {
        found.limit_violations[0].by = of_most * found.largest_torque;
        found.holds(1e-6)
    };
    let mut found = found;
    assert!(share(&mut found, 0.99 * PASSIVE_TORQUE_SHARE));
    assert!(!share(&mut found, 1.01 * PASSIVE_TORQUE_SHARE));
    assert!(found.holds(0.01));
}

/// The simulation decides where a joint is passive, and nowhere else after a direct solve.
#[test]
fn a_motion_that_passive_joints_do_not_follow_is_no_success() {
    let still = solved("still", &hanging(json!({ "q_goal": [0.0, 0.0] }))).summary;
    assert!(still.success && still.failure.is_none(), "{still:?}");
    let off = solved("off", &upright(json!({}))).summary;
    assert!(off.feasibility.holds(1e-6) && !off.success, "{off:?}");
    let failure = off.failure.expect("it says why");
    let words = "the forward simulation with feedback ends ";
    assert!(failure.starts_with(words), "{failure}");
    let driven = solved("driven", &upright(json!({ "passive": [] }))).summary;
    assert!(driven.success && driven.notes[0].starts_with(words), "{driven:?}");
}

/// The control effort is that of the motors, and the largest torques are told.
#[test]
fn the_summary_tells_the_torques_apart() {
    // Little room for a motion without a torque at the pole: whatever comes of it, its numbers agree.
    let report = solved("apart", &hanging(json!({})));
    let summary = &report.summary;
    let model = builtin_robot("cart_pole").expect("built in");
    let samples = aghf::motion::sample(&model, &report.curve, 2000).expect("of this robot");
    let largest = |joint: usize| samples.iter().fold(0.0_f64, |m, at| m.max(at.u[joint].abs()));
    let told = &summary.feasibility;
    let passive = told.largest_passive_torque.expect("one is passive");
    assert!((passive - largest(1)).abs() < 1e-4 * passive, "{passive}");
    let most = largest(0).max(largest(1));
    assert!((told.largest_torque - most).abs() < 1e-4 * most);
    let effort: f64 = samples
        .windows(2)
        .map(|pair| {
            let squares = |at: &aghf::motion::Sample| at.u[0] * at.u[0];
            0.5 * (squares(&pair[0]) + squares(&pair[1])) * (pair[1].t - pair[0].t)
        })
        .sum();
    assert!((summary.control_effort - effort).abs() < 1e-5 * effort, "{effort}");
    let written = serde_json::to_value(summary).expect("numbers");
    assert_eq!(written["largest_passive_torque"], json!(passive));
    assert_eq!(written["largest_torque"], json!(told.largest_torque));
    let driven = solved("driven", &hanging(json!({ "passive": [] }))).summary;
    assert_eq!(driven.feasibility.largest_passive_torque, None);
}

#[test]
fn the_effort_of_some_joints_is_the_integral_of_their_squares() -> aghf::Result<()> {
    use aghf::curve::{Chebyshev, Curve};
    use aghf::motion::{Guess, Problem};
    let model = aghf::urdf::builtin_robot("cart_pole")?;
    let problem = Problem::new(&model, vec![0.0; 4], vec![0.3, 1.0, 0.0, 0.0], 2.0)?;
    let nodes = Chebyshev::new(9, problem.horizon())?;
    let line = problem.guess(Guess::LineConfiguration, &nodes);
    let curve = Curve::new(nodes, line)?;
    // The trapezoidal rule is within 1e-4 of Simpson's.
    let intervals = 4000;
    for joints in [vec![], vec![1], vec![0, 1]] {
        let effort = aghf_scenario::effort_of_joints(&model, &curve, &joints, intervals)?;
        // By Simpson's rule.
        let mut sum = 0.0;
        for (k, at) in aghf::motion::sample(&model, &curve, intervals)?.iter().enumerate() {
            let weight = match k {
                0 => 1.0,
                _ if k == intervals => 1.0,
                _ => 2.0 + 2.0 * (k % 2) as f64,
            };
            sum += weight * joints.iter().map(|i| at.u[*i] * at.u[*i]).sum::<f64>();
        }
        let expected = sum * 2.0 / (3.0 * intervals as f64);
        assert!((effort - expected).abs() <= 1e-4 * expected, "{joints:?} {effort} {expected}");
        assert_eq!(effort > 0.0, !joints.is_empty());
    }
    Ok(())
}
