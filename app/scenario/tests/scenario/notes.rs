//! Notes on a scenario.

use crate::written::load;
use aghf_scenario::{DirectOptions, Solve};
use serde_json::json;

/// A continuous joint goes to the number that is given, with a note if fewer turns lead to the same place.
#[test]
fn turns_that_are_not_needed_are_noted() {
    let notes = |q_goal: f64| {
        let scenario = json!({
            "robot": "pendulum_1", "horizon_s": 3.0, "q_start": [3.1], "v_start": [0.0],
            "q_goal": [q_goal], "v_goal": [0.0],
        });
        let scenario = load("turns", &scenario).expect("it is good");
        let options = DirectOptions {
            starts: Some(1),
            ..DirectOptions::default()
        };
        Solve::new(&scenario)
            .options(options)
            .run()
            .expect("it is good")
            .summary
            .notes
    };
    let words = "q_goal: continuous joint 'joint_1' turns by 6.2 rad; 3.183185307179586 would be the same place, \
                 0.0832 rad away";
    assert_eq!(notes(-3.1), [words]);
    assert!(notes(3.1832).is_empty());
    assert!(notes(0.5).is_empty());
}
