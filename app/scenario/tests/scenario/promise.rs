//! The list of promises is that of the keys: nothing that is asked is missing, and each reader has all of it.

use crate::written::{load, with};
use aghf_scenario::judge::{Check, Outcome, Tolerances, Trajectory, judge};
use aghf_scenario::{Promise, Quantity, Scenario, Scope, builtin_scenarios};
use serde_json::{Value, json};

const THROUGHOUT: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

fn arm(keys: Value) -> Scenario {
    let zeros = [0.0; 7];
    let base = json!({ "robot": "kinova_gen3", "horizon_s": 3.0, "q_start": zeros, "v_start": zeros,
        "q_goal": [0.3, 0.2, 0.1, 0.4, 0.0, 0.2, 0.1], "v_goal": zeros, "robot_shape": "joint_frames" });
    load("arm", &with(base, keys)).expect("it is good")
}

/// The promises that the keys add to those of a scenario without them.
fn added(keys: Value) -> Vec<(Quantity, Option<usize>, Scope)> {
    let known = arm(json!({})).promises();
    let new = arm(keys).promises().into_iter().filter(|promise| !known.contains(promise));
    new.map(|Promise { quantity, index, scope, .. }| (quantity, index, scope)).collect()
}

#[test]
fn each_key_adds_its_promises() {
    let each = |quantity| (0..7).map(|joint| (quantity, Some(joint), Scope::THROUGHOUT)).collect::<Vec<_>>();
    for quantity in [Quantity::Acceleration, Quantity::Jerk, Quantity::Power] {
        assert_eq!(added(json!({ "enforced_limits": { quantity.name(): 50.0 } })), each(quantity));
    }
    let push = json!([0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    for (key, scope) in [("a_start", Scope::Start), ("a_goal", Scope::Goal)] {
        assert_eq!(added(json!({ key: push })), [(Quantity::Acceleration, None, scope)]);
    }
    let frame = "end_effector_link";
    let kept = json!([{ "speed": { "frame": frame, "most_m_s": 0.5 } },
        { "speed": { "frame": frame, "most_m_s": 0.4 }, "from_s": 1.0, "to_s": 2.0 }]);
    let scopes = [Scope::Between(THROUGHOUT), Scope::Between([1.0, 2.0])];
    let rows = scopes.into_iter().enumerate().map(|(i, scope)| (Quantity::Frame, Some(i), scope));
    assert_eq!(added(json!({ "keep": kept })), rows.collect::<Vec<_>>());
    let way = json!([{ "q": [0.1, 0.1, 0.1, 0.1, 0.0, 0.1, 0.1] }]);
    assert_eq!(added(json!({ "waypoints": way })), [(Quantity::Frame, Some(0), Scope::Waypoint(0))]);
    let ball = json!([{ "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [2.0, 0.0, 0.0] } }]);
    assert_eq!(added(json!({ "obstacles": ball })), [(Quantity::Obstacles, None, Scope::THROUGHOUT)]);
    let bounds = json!({ "free_horizon": { "shortest_s": 1.0, "longest_s": 4.0 } });
    assert_eq!(added(bounds), [(Quantity::Duration, None, Scope::Goal)]);
    // A joint without a motor has no other limit of its torque.
    let passive = arm(json!({ "passive": ["joint_1"], "continuity": "velocity" })).promises();
    let is_torque = |of: &&Promise| matches!(of.quantity, Quantity::Torque | Quantity::Passive);
    let of_first = passive.iter().filter(|of| of.index == Some(0)).find(is_torque).expect("it is there");
    assert_eq!((of_first.quantity, of_first.bounds), (Quantity::Passive, [0.0; 2]));
}

#[test]
fn the_judge_knows_every_promise_of_the_built_in_scenarios() {
    for name in builtin_scenarios() {
        let scenario = Scenario::load(name).expect("it is built in");
        // At the start, without moving.
        let table = |of: &[f64]| vec![of.to_vec(); 9];
        let (times, still) = ((0..9).map(f64::from).collect(), table(&vec![0.0; scenario.model.dof()]));
        let resting =
            Trajectory { times, q: table(&scenario.file.q_start), v: Some(still.clone()), a: Some(still), u: None };
        let judgement = judge(&scenario, &resting, Tolerances::default()).expect("its joints");
        assert!(judgement.checks.iter().all(|row| row.outcome != Outcome::NotChecked), "{name}");
        for check in scenario.limits().into_iter().map(|limit| Check::Bounds(limit.quantity)) {
            let row = judgement.checks.iter().find(|row| row.check == check);
            assert!(row.is_some_and(|row| row.worst.is_some()), "{name}: {check:?}");
        }
    }
}
