//! Good motions pass, and each kind of violation is found.

use crate::robot::{FROM, TO, bounds, failed, good, row, scenario, torques, verdict};
use aghf::model::Model;
use aghf_scenario::Quantity;
use aghf_scenario::judge::{Check, Outcome, Tolerances, Trajectory, judge};
use serde_json::{Value, json};

#[test]
fn a_good_motion_passes() {
    let scenario = scenario(
        "good",
        json!({ "self_collision": { "ignored_pairs": [] },
        "obstacles": [{ "shape": { "box": { "size_m": [4, 4, 0.1] } }, "pose": { "position_m": [0, 0, 1] } }] }),
    );
    let whole = good(&scenario.model, FROM, TO, 101);
    let judgement = verdict(&scenario, &whole);
    assert_eq!(failed(&judgement), []);
    let checked = judgement.checks.iter().filter(|row| row.outcome == Outcome::Pass);
    // All but passive joints and limits of accelerations and jerks.
    assert_eq!(checked.count(), 14);
    let clearance = bounds(&judgement, Quantity::Obstacles);
    let least = clearance.worst.as_ref().expect("there is one").value;
    assert!((least - 0.94).abs() < 1e-12, "{least}");
    let proved = clearance.proved_at_least.expect("there is one");
    assert!((0.94 * 0.95 - 1e-9..=0.94).contains(&proved), "{proved}");
}

/// A table means the motion that its columns determine, and what it leaves open is not checked.
#[test]
fn each_table_means_a_motion() {
    let scenario = scenario("columns", json!({}));
    let whole = good(&scenario.model, FROM, TO, 101);
    let mut table = Trajectory { u: None, ..whole };
    let mut judged = |words: &str, left_out: &[Check]| {
        let judgement = verdict(&scenario, &table);
        assert_eq!(failed(&judgement), []);
        assert!(judgement.between_samples.contains(words), "{}", judgement.between_samples);
        let dynamics = row(&judgement, Check::Dynamics);
        assert_eq!(dynamics.outcome, Outcome::NotApplicable);
        let rows = judgement.checks.iter();
        let found = rows.filter(|row| row.outcome == Outcome::NotChecked);
        assert_eq!(found.map(|row| row.check).collect::<Vec<_>>(), left_out);
        if table.a.take().is_none() {
            table.v = None;
        }
    };
    judged("quintics through q, v and a", &[]);
    judged("cubics through q and v", &[Check::Continuity]);
    // The accelerations at the ends are known to 8e-3 rad/s^2.
    judged("rates of q by five neighbouring samples", &[Check::Continuity]);
}

/// Asserts that a motion that `change` spoils fails these checks of a scenario with these keys, at this place.
fn assert_found(name: &str, keys: Value, change: fn(&Model, &mut Trajectory), wanted: &[Check], place: &str) {
    let scenario = scenario(name, keys);
    let mut motion = good(&scenario.model, FROM, TO, 101);
    change(&scenario.model, &mut motion);
    let judgement = verdict(&scenario, &motion);
    assert_eq!(failed(&judgement), wanted, "{name}");
    for check in wanted {
        let worst = row(&judgement, *check).worst.as_ref().expect("it failed");
        let found = worst.place.as_deref().unwrap_or_default();
        assert!(found.contains(place), "{name}: {found}");
    }
}

#[test]
fn another_duration_and_other_ends_are_found() {
    for (name, keys, check, place) in [
        ("late", json!({ "horizon_s": 0.9 }), Check::Bounds(Quantity::Duration), "duration"),
        (
            "too early",
            json!({ "horizon_s": 1.2, "free_horizon": { "shortest_s": 1.1, "longest_s": 1.5 } }),
            Check::Bounds(Quantity::Duration),
            "duration",
        ),
        ("another start", json!({ "q_start": [-0.5, 0.2, 0.41] }), Check::StartPosition, "elbow"),
        ("another goal", json!({ "q_goal": [0.49, -0.3, 1.4] }), Check::GoalPosition, "slide"),
        ("a flying start", json!({ "v_start": [0.0, 0.1, 0.0] }), Check::StartVelocity, "shoulder"),
        ("no stop", json!({ "v_goal": [0.0, 0.0, 0.1] }), Check::GoalVelocity, "elbow"),
    ] {
        assert_found(name, keys, |_, _| (), &[check], place);
    }
    let free = json!({ "v_goal": [0.0, 0.0, 0.1], "free_final_velocity": true });
    assert_found("any stop", free, |_, _| (), &[], "");
}

#[test]
fn each_broken_limit_is_found() {
    for (quantity, limit, place) in [
        (Quantity::Acceleration, json!([1e3, 1e3, 0.5]), "elbow"),
        (Quantity::Jerk, json!([1e4, 0.5, 1e4]), "shoulder"),
        (Quantity::Torque, json!(0.05), "slide"),
        (Quantity::Power, json!(0.05), "slide"),
        (Quantity::Velocity, json!(0.23), "slide"),
        (Quantity::Position, json!(0.2), "elbow"),
    ] {
        let keys = json!({ "enforced_limits": { quantity.name(): limit } });
        assert_found(quantity.name(), keys, |_, _| (), &[Check::Bounds(quantity)], place);
    }
    let without = json!({ "passive": ["shoulder"] });
    assert_found("passive", without, |_, _| (), &[Check::Bounds(Quantity::Passive)], "shoulder");
}

fn rates(table: &mut Option<Vec<Vec<f64>>>) -> &mut Vec<Vec<f64>> {
    table.as_mut().expect("given")
}

#[test]
fn columns_that_contradict_each_other_are_found() {
    let wrong = |name, change, wanted: &[Check], place| {
        assert_found(name, json!({}), change, wanted, place);
    };
    wrong("a wrong torque", |_, t| t.u.as_mut().expect("given")[40][1] += 0.1, &[Check::Dynamics], "shoulder");
    wrong(
        "torques of another acceleration",
        |model, t| {
            rates(&mut t.a).iter_mut().for_each(|a| a[0] += 0.1);
            t.u = torques(model, t);
        },
        &[Check::Continuity, Check::AccelerationIsRate],
        "slide",
    );
    wrong(
        "velocities of another motion",
        |model, t| {
            rates(&mut t.v).iter_mut().for_each(|v| v[2] *= 1.02);
            rates(&mut t.a).iter_mut().for_each(|a| a[2] *= 1.02);
            t.u = torques(model, t);
        },
        &[Check::VelocityIsRate],
        "elbow",
    );
    wrong(
        "a jolt in the velocity",
        |model, t| {
            rates(&mut t.v)[50][2] += 0.05;
            t.u = torques(model, t);
        },
        &[Check::VelocityIsRate, Check::AccelerationIsRate],
        "elbow",
    );
}

/// The worst is at the time and has the value that it should have, between the samples too.
#[test]
fn extrema_between_samples_are_found() {
    let scenario = scenario(
        "extrema",
        json!({ "q_start": [0.0, 0.0, 0.0], "q_goal": [0.0, 0.0, 0.0],
        "continuity": "velocity", "v_start": [0.0, 2.0, 0.0], "v_goal": [0.0, -2.0, 0.0],
        "enforced_limits": { "torque": false, "velocity": { "joints": ["shoulder"] } } }),
    );
    // q = 2 t (1 - t) is within the samples of a cubic, with the highest point halfway.
    let mut motion = good(&scenario.model, [0.0; 3], [0.0; 3], 2);
    motion.v = Some(vec![vec![0.0, 2.0, 0.0], vec![0.0, -2.0, 0.0]]);
    motion.a = Some(vec![vec![0.0, -4.0, 0.0]; 2]);
    motion.u = None;
    let judgement = verdict(&scenario, &motion);
    assert_eq!(failed(&judgement), []);
    // The samples of a cubic whose speed is highest between them: 3/2 of the mean one.
    let mut motion = good(&scenario.model, [0.0; 3], [0.0, 1.0, 0.0], 2);
    (motion.a, motion.u) = (None, None);
    let velocity = bounds(&verdict(&scenario, &motion), Quantity::Velocity).worst.clone();
    let worst = velocity.expect("it is limited");
    assert!((worst.value - 1.5).abs() < 1e-12 && worst.at_s == 0.5, "{worst:?}");
    // And one that swings beyond the limit of 3 and back.
    let mut motion = good(&scenario.model, [0.0, 2.9, 0.0], [0.0, 2.9, 0.0], 2);
    motion.v = Some(vec![vec![0.0, 2.0, 0.0], vec![0.0, -2.0, 0.0]]);
    motion.a = None;
    let position = bounds(&verdict(&scenario, &motion), Quantity::Position).worst.clone();
    let worst = position.expect("it is limited");
    assert!((worst.value - 3.4).abs() < 1e-12 && worst.at_s == 0.5, "{worst:?}");
}

/// A force that is there between the samples alone.
#[test]
fn torques_between_samples_are_found() {
    let keys = json!({ "enforced_limits": { "torque": 0.01 } });
    let scenario = scenario("between", keys);
    let mut motion = good(&scenario.model, [0.0; 3], [1.0, 0.0, 0.0], 2);
    rates(&mut motion.v)[1][0] = 2.0;
    (motion.a, motion.u) = (None, None);
    let judgement = verdict(&scenario, &motion);
    let row = bounds(&judgement, Quantity::Torque);
    assert_eq!(row.outcome, Outcome::Fail);
    // 4 kg gain 2 m/s in a second.
    let worst = row.worst.as_ref().expect("it fails");
    assert!((worst.value - 8.0).abs() < 1e-9, "{worst:?}");
    assert_eq!(worst.at_most, Some(3.0));
}

/// Numbers that overflow are no motion.
#[test]
fn overflow_is_not_valid() {
    let scenario = scenario(
        "overflow",
        json!({ "obstacles": [{ "shape": { "box": { "size_m": [4, 4, 0.1] } },
            "pose": { "position_m": [0, 0, 1] } }] }),
    );
    let mut motion = good(&scenario.model, FROM, TO, 11);
    rates(&mut motion.v)[5][0] = 1e308;
    motion.times.iter_mut().for_each(|t| *t *= 1e3);
    let failed = failed(&verdict(&scenario, &motion));
    let wanted = [Quantity::Obstacles, Quantity::Velocity].map(Check::Bounds);
    assert!(wanted.iter().all(|check| failed.contains(check)), "{failed:?}");
}

#[test]
fn bad_arguments_are_refused() {
    let scenario = scenario("arguments", json!({}));
    let motion = good(&scenario.model, FROM, TO, 11);
    let refused =
        |motion: &Trajectory, tolerances| judge(&scenario, motion, tolerances).expect_err("it is bad").to_string();
    let all = Tolerances::default();
    assert!(refused(&motion, Tolerances { tolerance: f64::NAN, ..all }).contains("tolerance"));
    assert!(refused(&motion, Tolerances { overlap_m: -1.0, ..all }).contains("overlap"));
    let mut short = motion.clone();
    short.q[3].pop();
    assert!(refused(&short, all).contains("q: expected 3"));
    let mut back = motion;
    back.times[4] = 0.0;
    assert!(refused(&back, all).contains("times"));
}
