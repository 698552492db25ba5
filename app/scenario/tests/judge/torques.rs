//! Torques at all times.

use crate::robot::{bounds, scenario, verdict};
use aghf_scenario::Quantity;
use aghf_scenario::judge::{Outcome, Trajectory};
use serde_json::json;

/// A force that is largest between a sample and the middle of an interval: the slide, of 4 kg with the arm, has the
/// acceleration 60 s (1 - s) (1 - 2 s), at most 10 / sqrt(3).
#[test]
fn forces_between_samples_are_proved() {
    let largest = 4.0 * 10.0 / 3.0_f64.sqrt();
    for (share, wanted) in [(1.002, Outcome::Pass), (0.998, Outcome::Fail)] {
        // The limits of the robot are 300 N and more.
        let keys = json!({ "q_start": [0.0, 0.0, 0.0], "q_goal": [1.0, 0.0, 0.0],
            "enforced_limits": { "torque": { "joints": ["slide"], "share": share * largest / 300.0 } } });
        let scenario = scenario("force", keys);
        let rows = |end: [f64; 3]| vec![vec![0.0; 3], end.to_vec()];
        let motion = Trajectory {
            times: vec![0.0, 1.0],
            q: rows([1.0, 0.0, 0.0]),
            v: Some(rows([0.0; 3])),
            a: Some(rows([0.0; 3])),
            u: None,
        };
        let judgement = verdict(&scenario, &motion);
        let row = bounds(&judgement, Quantity::Torque);
        assert_eq!(row.outcome, wanted, "{row:?}");
    }
}
