//! The number of samples that the judge needs.

use crate::robot::{failed, verdict};
use aghf::motion::sample;
use aghf_scenario::judge::{Trajectory, sufficient_samples};
use aghf_scenario::{DirectOptions, Scenario, Solve};

/// The torques of the acrobot change fast: its motion takes more than 201 samples, and fails with half of these.
#[test]
fn a_swift_motion_has_more_samples() {
    let scenario = Scenario::load("acrobot_swingup").expect("built in");
    let options = DirectOptions { starts: Some(1), ..DirectOptions::default() };
    let report = Solve::new(&scenario).options(options).run();
    let report = report.expect("it is good");
    let samples = sufficient_samples(&scenario, &report.curve).expect("same robot");
    let judged = |intervals| {
        let samples = sample(&scenario.model, &report.curve, intervals).expect("same robot");
        failed(&verdict(&scenario, &Trajectory::of_samples(samples)))
    };
    assert_eq!(judged(samples - 1), []);
    assert!(samples > 300, "{samples}");
    assert_ne!(judged((samples - 1) / 2), []);
    // The ends of segments are samples.
    assert_eq!((samples - 1) % report.curve.segments(), 0);
}

/// No number of samples makes a motion that does not end at the goal pass.
#[test]
fn a_motion_that_is_not_valid_has_the_fewest() {
    let mut scenario = Scenario::load("pendulum_1_swingup").expect("built in");
    let options = DirectOptions { starts: Some(1), ..DirectOptions::default() };
    let report = Solve::new(&scenario).options(options).run();
    let report = report.expect("it is good");
    scenario.file.q_goal[0] += 1.0;
    let samples = sufficient_samples(&scenario, &report.curve).expect("same robot");
    assert_eq!(samples, 201);
}
