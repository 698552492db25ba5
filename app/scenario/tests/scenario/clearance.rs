//! Distances that a robot keeps: in a solve, before it, and for the judge.

use crate::written::load;
use aghf::constraint::{AnyConstraint, Constraint, PlacedState};
use aghf::dynamics::forward_kinematics;
use aghf::spatial::Placement;
use aghf_scenario::judge::{Check, Tolerances, Trajectory, judge};
use aghf_scenario::{Quantity, Scenario, Solve};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// A pendulum of balls that swings past a ball.
fn swing(clearance: Value) -> Scenario {
    let scenario = json!({
        "robot": "pendulum_3", "horizon_s": 2.0,
        "q_start": [0, 0, 0], "v_start": [0, 0, 0], "q_goal": [1.0, 0.5, 0], "v_goal": [0, 0, 0],
        "robot_shape": { "swept_links": { "radius_m": 0.05 } }, "clearance_m": clearance,
        "obstacles": [
            { "name": "ball", "shape": { "sphere": { "radius_m": 0.15 } },
              "pose": { "position_m": [1.0, 0.0, 0.3] } },
            { "name": "block", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } },
              "pose": { "position_m": [0, 0, 2.5] } }
        ],
    });
    load("swing", &scenario).expect("it is good")
}

#[test]
fn motions_keep_their_clearance() {
    for clearance in [0.0, 0.01] {
        let scenario = swing(json!({ "obstacles": clearance }));
        let report = Solve::new(&scenario).run().expect("it runs");
        let found = report.summary.feasibility.smallest_clearance_m.expect("there are obstacles");
        assert!(report.summary.success && found > clearance - 1e-6, "{found} {clearance}");
        let samples = aghf::motion::sample(&scenario.model, &report.curve, 1000);
        let trajectory = Trajectory::of_samples(samples.expect("the same robot"));
        let of = |clearance: f64| {
            let scenario = swing(json!(clearance));
            let judged = judge(&scenario, &trajectory, Tolerances::default()).expect("judged");
            let mut rows = judged.checks.into_iter();
            rows.find(|row| row.check == Check::Bounds(Quantity::Obstacles)).expect("there is one")
        };
        let (kept, asked) = (of(clearance), of(clearance + 0.005));
        assert!(kept.outcome.is_good() && !asked.outcome.is_good(), "{kept:?} {asked:?}");
        let worst = asked.worst.expect("it fails");
        assert_eq!(worst.at_least, Some(clearance + 0.005));
        // The judge looks at the balls, which stick out of the capsules.
        assert!((worst.value - clearance).abs() < 1e-3, "{worst:?}");
    }
}

/// An obstacle with a distance of its own, whatever that of the others: planned, refused at ends, and judged.
#[test]
fn an_obstacle_has_a_distance_of_its_own() {
    let ball = |own: Value| {
        let mut scenario = swing(json!(0.01)).file;
        scenario.obstacles[0].clearance_m = serde_json::from_value(own).expect("it is a number");
        let text = serde_json::to_string(&scenario).expect("it is written");
        Scenario::parse(&text, "swing", std::path::Path::new(""))
    };
    let clearance = |scenario: &Scenario, trajectory: &Trajectory, outcome: bool| {
        let judged = judge(scenario, trajectory, Tolerances::default()).expect("judged");
        let mut rows = judged.checks.into_iter();
        let row = rows.find(|row| row.check == Check::Bounds(Quantity::Obstacles)).expect("there is one");
        assert_eq!(row.outcome.is_good(), outcome, "{row:?}");
        row.worst.expect("there are obstacles")
    };
    let mut found = Vec::new();
    for own in [json!(0.02), json!(null), json!(0.0)] {
        let scenario = ball(own.clone()).expect("it is good");
        let report = Solve::new(&scenario).run().expect("it runs");
        assert!(report.summary.success, "{own}");
        let least = own.as_f64().unwrap_or(0.01);
        let smallest = report.summary.feasibility.smallest_clearance_m.expect("there are obstacles");
        assert!(smallest > least.min(0.01) - 1e-6, "{own}: {smallest}");
        found.push(smallest);
        let samples = aghf::motion::sample(&scenario.model, &report.curve, 1000);
        let trajectory = Trajectory::of_samples(samples.expect("the same robot"));
        clearance(&scenario, &trajectory, true);
        let asked = ball(json!(least + 0.005)).expect("it is good");
        let worst = clearance(&asked, &trajectory, false);
        assert_eq!(worst.at_least, Some(least + 0.005), "{own}");
        assert!((worst.value - least).abs() < 1e-3, "{own}: {worst:?}");
    }
    assert!(found[0] > found[1] + 5e-3 && found[1] > found[2] + 5e-3, "{found:?}");
    let text = ball(json!(1.0)).expect("it is good").check_feasible();
    let text = text.expect_err("both ends are nearer").to_string();
    assert!(text.contains("'ball', its clearance_m is 1 m"), "{text}");
    let text = ball(json!(-1.0)).expect_err("it is negative").to_string();
    assert!(text.contains("obstacles[0].clearance_m: it is -1"), "{text}");
}

/// Two pairs of links of a robot of balls with distances of their own.
#[test]
fn pairs_of_links_have_distances_of_their_own() {
    let ready = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
    let with_pairs = |pairs: Value| {
        let scenario = json!({
            "robot": "panda", "horizon_s": 2.0, "q_start": ready, "v_start": [0, 0, 0, 0, 0, 0, 0],
            "q_goal": ready, "v_goal": [0, 0, 0, 0, 0, 0, 0], "clearance_m": { "itself": 0.01, "pairs": pairs }
        });
        load("pairs", &scenario)
    };
    let links = ["panda_link6", "panda_link0"];
    let pair = |distance: f64| json!([{ "links": links, "clearance_m": distance }]);
    let near = with_pairs(pair(0.05)).expect("it is good");
    near.check_feasible().expect("they are further");
    let scene = &near.scene;
    let names = |pair: &[usize; 2]| pair.map(|i| scene.robot().link_of(&scene.trees()[i]));
    for (pair, margin) in scene.tree_pairs().iter().zip(scene.pair_margins()) {
        let is_it = names(pair).iter().flatten().all(|link| links.contains(link));
        assert_eq!(*margin, if is_it { 0.05 } else { 0.01 }, "{:?}", names(pair));
    }
    let rows = |margin| scene.pairs_with_margin(margin).len();
    assert!(rows(0.05) > 0 && rows(0.05) + rows(0.01) == scene.pairs().len());
    let far = with_pairs(pair(2.0)).expect("it is good").check_feasible();
    let far = far.expect_err("they are nearer").to_string();
    assert!(
        far.contains("its clearance_m is 2 m; clearance_m.obstacles is") && links.iter().all(|link| far.contains(link)),
        "{far}"
    );
    let twice = [pair(0.1)[0].clone(), pair(0.2)[0].clone()];
    for (pairs, words) in [
        (json!([{ "links": ["panda_link6", "leg"], "clearance_m": 0.1 }]), "no link 'leg'"),
        (json!([{ "links": ["panda_link3", "panda_link4"], "clearance_m": 0.1 }]), "not kept clear"),
        (pair(-0.1), "clearance_m.pairs[0].clearance_m: it is -0.1"),
        (json!(twice), "clearance_m.pairs[1].links: ;given twice"),
    ] {
        let error = with_pairs(pairs).expect_err(words);
        assert!(words.split(';').all(|part| error.contains(part)), "{error}; {words}");
    }
}

/// The largest row of the bodies of a robot is the deepest contact but for the smoothing, each with the distance of its
/// own obstacle or pair.
#[test]
fn rows_of_bodies_keep_the_distance_of_their_own() {
    let sphere = |x: f64, own: Value| {
        let pose = json!({ "position_m": [x, 0.2, 0.6] });
        json!({ "shape": { "sphere": { "radius_m": 0.1 } }, "pose": pose, "clearance_m": own })
    };
    let zeros = [0.0; 7];
    let scenario = json!({
        "robot": "kinova_gen3", "horizon_s": 2.0, "q_start": zeros, "v_start": zeros, "q_goal": zeros, "v_goal": zeros,
        "obstacles": [sphere(0.3, json!(null)), sphere(-0.3, json!(0.15))],
        "clearance_m": { "obstacles": 0.05, "itself": 0.02, "pairs": [
            { "links": ["base_link", "bracelet_link"], "clearance_m": 0.12 }
        ] },
    });
    let scenario = load("rows", &scenario).expect("it is good");
    let (model, mut rng) = (&scenario.model, ChaCha8Rng::seed_from_u64(3));
    let mut placements = vec![Placement::identity(); 7];
    let mut margins = BTreeSet::new();
    for _ in 0..300 {
        let q = model.random_configuration(&mut rng);
        forward_kinematics(model, &q, &mut placements).expect("lengths agree");
        let deepest = scenario.scene.deepest_contact(&placements).expect("lengths agree");
        let deepest = deepest.expect("there are obstacles");
        let x = [q, zeros.to_vec()].concat();
        let at = PlacedState { model, x: &x, placements: &placements, active_pairs: None };
        let rows = AnyConstraint::of_scene(&scenario.scene);
        let rows = rows.iter().flat_map(|rows| {
            let mut g = vec![0.0; rows.dim()];
            rows.value(&at, &mut g).expect("lengths agree");
            g
        });
        let largest = rows.fold(f64::NEG_INFINITY, f64::max);
        // In an overlap there may be several planes with the largest gap nearby.
        if (-deepest.margin..0.0).contains(&deepest.distance) {
            assert!((-1e-9..0.004).contains(&(largest + deepest.distance)), "{largest} {deepest:?}");
            margins.insert((1e3 * deepest.margin) as i64);
        }
        assert!(deepest.distance > 0.0 || largest > 0.0, "{largest} {deepest:?}");
    }
    assert!([20, 50, 120, 150].iter().all(|margin| margins.contains(margin)), "{margins:?}");
}

#[test]
fn ends_without_their_clearance_are_refused() {
    let checked = |clearance: Value| swing(clearance).check_feasible();
    assert!(checked(json!(0.05)).is_ok());
    let text = checked(json!({ "obstacles": 1.0 })).expect_err("both ends are nearer").to_string();
    assert!(text.contains("q_start: link") && text.contains("its clearance_m is 1 m"), "{text}");
}
