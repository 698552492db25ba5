//! Distances that a robot keeps: in a solve, before it, and for the judge.

use crate::written::load;
use aghf_scenario::judge::{Check, Tolerances, Trajectory, judge};
use aghf_scenario::{Scenario, Solve};
use serde_json::{Value, json};

/// A pendulum of balls that swings past a ball.
fn swing(clearance: Value) -> Scenario {
    let scenario = json!({
        "robot": "pendulum_3", "horizon_s": 2.0,
        "q_start": [0, 0, 0], "v_start": [0, 0, 0], "q_goal": [1.0, 0.5, 0], "v_goal": [0, 0, 0],
        "robot_shape": { "swept_links": { "radius_m": 0.05 } }, "clearance_m": clearance,
        "obstacles": [
            { "name": "ball", "shape": { "sphere": { "radius_m": 0.15 } },
              "pose": { "position_m": [-1.35, 0.0, 0.3] } },
            { "name": "block", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } },
              "pose": { "position_m": [-1.5, 0, 0.4] } }
        ],
    });
    load("swing", &scenario).expect("it is good")
}

#[test]
fn motions_keep_their_clearance() {
    for clearance in [0.0, 0.01] {
        let scenario = swing(json!({ "obstacles": clearance }));
        let report = Solve::new(&scenario).run().expect("it runs");
        let found = report
            .summary
            .feasibility
            .smallest_clearance_m
            .expect("there are obstacles");
        assert!(
            report.summary.success && found > clearance - 1e-6,
            "{found} {clearance}"
        );
        let samples = aghf::motion::sample(&scenario.model, &report.curve, 1000);
        let trajectory = Trajectory::of_samples(samples.expect("the same robot"));
        let of = |clearance: f64| {
            let scenario = swing(json!(clearance));
            let judged = judge(&scenario, &trajectory, Tolerances::default()).expect("judged");
            let mut rows = judged.checks.into_iter();
            rows.find(|row| row.check == Check::Obstacles)
                .expect("there is one")
        };
        let (kept, asked) = (of(clearance), of(clearance + 0.005));
        assert!(
            kept.outcome.is_good() && !asked.outcome.is_good(),
            "{kept:?} {asked:?}"
        );
        let worst = asked.worst.expect("it fails");
        assert_eq!(worst.at_least, Some(clearance + 0.005));
        // The judge looks at the balls, which stick out of the capsules.
        assert!((worst.value - clearance).abs() < 1e-3, "{worst:?}");
    }
}

#[test]
fn ends_without_their_clearance_are_refused() {
    let checked = |clearance: Value| swing(clearance).check_feasible();
    assert!(checked(json!(0.05)).is_ok());
    let text = checked(json!({ "obstacles": 1.0 }))
        .expect_err("both ends are nearer")
        .to_string();
    assert!(
        text.contains("q_start: link") && text.contains("its clearance_m is 1 m"),
        "{text}"
    );
}
