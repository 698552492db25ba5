//! Nothing passes through unseen.

use crate::robot::{bounds, good, scenario, verdict};
use aghf::dynamics::forward_kinematics;
use aghf::spatial::Placement;
use aghf_scenario::judge::{Hermite, Outcome, Tolerances, Trajectory, judge};
use aghf_scenario::{Quantity, Scenario};
use serde_json::json;

/// The carriage slides by 1 m between two samples, through what is 0.1 mm thick.
#[test]
fn a_thin_obstacle_between_two_samples_is_seen() {
    let obstacles = [
        json!({ "obstacles": [{ "name": "sheet", "shape": { "box": { "size_m": [1e-4, 0.02, 0.02] } },
            "pose": { "position_m": [0.1, 0, 0] } }] }),
        json!({ "obstacles": [{ "name": "wire", "shape": { "cylinder": { "radius_m": 1e-4, "length_m": 0.1 } },
            "pose": { "position_m": [0.1, 0, 0] } }] }),
        json!({ "obstacles": [{ "name": "wire", "shape": { "capsule": { "radius_m": 1e-4, "length_m": 0.1 } },
            "pose": { "position_m": [0.1, 0, 0.05] } }] }),
        json!({ "obstacles": [{ "name": "grain", "shape": { "sphere": { "radius_m": 1e-4 } },
            "pose": { "position_m": [0.1, 0.0, 0.0] } }] }),
    ];
    for (i, keys) in obstacles.into_iter().enumerate() {
        let scenario = scenario(&format!("thin_{i}"), keys.clone());
        let motion = good(&scenario.model, [-0.5, 1.5, 0.0], [0.5, 1.5, 0.0], 2);
        let judgement = verdict(&scenario, &motion);
        let row = bounds(&judgement, Quantity::Obstacles);
        assert_eq!(row.outcome, Outcome::Fail, "{keys}");
        let worst = row.worst.as_ref().expect("it fails");
        let place = worst.place.as_deref().unwrap_or_default();
        assert!(
            ["sheet", "wire", "grain"].iter().any(|name| place == format!("link 'carriage' and '{name}'")),
            "{place}"
        );
        // At x = 0.1, 0.6 of the way, 10 s^3 - 15 s^4 + 6 s^5 = 0.6; it is as deep as the middle of the ball is beyond
        // its surface.
        assert!((worst.at_s - 0.5537).abs() < 0.01, "{worst:?}");
        assert!((worst.value + 0.01005).abs() < 6e-4, "{worst:?}");
    }
}

/// The elbow folds through half a turn between two samples, so that the fore link goes through the carriage.
#[test]
fn a_fold_through_itself_is_seen() {
    let keys = json!({ "self_collision": { "ignored_pairs": [] }, "enforced_limits": { "torque": false } });
    let (from, to) = ([0.0, 0.0, 2.6], [0.0, 0.0, 3.9]);
    let scenario_of = |test, keys| scenario(test, keys);
    let scenario = scenario_of("fold", keys);
    let motion = good(&scenario.model, from, to, 2);
    let judgement = verdict(&scenario, &motion);
    let row_of = bounds(&judgement, Quantity::SelfCollision);
    assert_eq!(row_of.outcome, Outcome::Fail);
    let worst = row_of.worst.as_ref().expect("it fails");
    assert_eq!(worst.place.as_deref(), Some("link 'carriage' and link 'fore'"));
    assert!((worst.value + 0.02).abs() < 1.1e-3, "{worst:?}");
    let keys = json!({ "self_collision": { "ignored_pairs": [["fore", "carriage"]] } });
    let scenario = scenario_of("folded", keys);
    assert_eq!(bounds(&verdict(&scenario, &motion), Quantity::SelfCollision).outcome, Outcome::NotApplicable);
}

/// A floor that the carriage slides along, just above it, at the accepted depth, and deeper.
#[test]
fn grazing_is_decided() {
    for (offset, wanted) in [(-0.01, Outcome::Pass), (-0.00995, Outcome::Pass), (-0.0098, Outcome::Fail)] {
        let keys = json!({ "obstacles": [{ "shape": { "half_space": {} },
            "pose": { "position_m": [0.0, 0.0, offset] } }] });
        let scenario = scenario(&format!("grazing_{offset}"), keys);
        let motion = good(&scenario.model, [-0.5, 1.5, 0.0], [0.5, 1.5, 0.0], 11);
        let judgement = verdict(&scenario, &motion);
        let row = bounds(&judgement, Quantity::Obstacles);
        assert_eq!(row.outcome, wanted, "{row:?}");
    }
}

/// Within the resolution of what is accepted nothing is claimed.
#[test]
fn what_cannot_be_proved_is_undecided() {
    let keys = json!({ "obstacles": [{ "shape": { "half_space": {} },
        "pose": { "position_m": [0.0, 0.0, -0.009_900_001] } }] });
    let scenario = scenario("undecided", keys);
    let motion = good(&scenario.model, [-0.5, 1.5, 0.0], [0.5, 1.5, 0.0], 11);
    let judgement = verdict(&scenario, &motion);
    assert!(!judgement.valid);
    let row = bounds(&judgement, Quantity::Obstacles);
    assert_eq!(row.outcome, Outcome::Undecided);
    assert!(row.note.as_ref().is_some_and(|note| note.starts_with("within ")));
}

/// The least clearance of the quintics at many times.
fn dense(scenario: &Scenario, motion: &Trajectory) -> f64 {
    let mut placements = vec![Placement::identity(); 3];
    let mut least = f64::INFINITY;
    for k in 0..motion.times.len() - 1 {
        let interval = motion.times[k + 1] - motion.times[k];
        let ends = |of: &[Vec<f64>], i: usize| [of[k][i], of[k + 1][i]];
        for step in 0..=2000 {
            let s = f64::from(step) / 2000.0;
            let [v, a] = [&motion.v, &motion.a].map(|of| of.as_ref().expect("it is given"));
            let quintic = |i| {
                let a = ends(a, i).map(Some);
                Hermite::new(ends(&motion.q, i), ends(v, i), a, interval)
            };
            let q: Vec<f64> = (0..3).map(|i| quintic(i).at(0, s)).collect();
            forward_kinematics(&scenario.model, &q, &mut placements).expect("three joints");
            least = least.min(scenario.scene.clearance(&placements).expect("they fit"));
        }
    }
    least
}

proptest::proptest! {
    #![proptest_config(crate::common::config(32))]

    /// What is proved holds at all times, and what is found is nearly that.
    #[test]
    fn proved_clearances_are_bounds(
        x in -0.6..0.6f64, y in -1.0..1.0f64, size in 0.001..0.3f64,
        from in proptest::array::uniform3(-1.5..1.5f64), to in proptest::array::uniform3(-1.5..1.5f64),
    ) {
        let keys = json!({ "obstacles": [{ "shape": { "box": { "size_m": [size, 0.001, 0.03] } },
            "pose": { "position_m": [x, y, 0.02] } }] });
        let scenario = scenario("proved", keys);
        let motion = good(&scenario.model, from, to, 4);
        let tolerances = Tolerances { overlap_m: 1e-3, ..Tolerances::default() };
        let judgement = judge(&scenario, &motion, tolerances).expect("it is of this robot");
        let row = bounds(&judgement, Quantity::Obstacles);
        let least = row.worst.as_ref().expect("it is checked").value;
        let (proved, dense) = (row.proved_at_least.expect("it is proved"), dense(&scenario, &motion));
        proptest::prop_assert!(proved <= dense + 1e-12, "{proved}, {dense}");
        let precision = f64::max(1e-4, 0.05 * least.abs()) + 1e-12;
        proptest::prop_assert!(least - dense <= precision, "{least}, {dense}");
        proptest::prop_assert!(least - proved <= precision, "{least}, {proved}");
    }
}
