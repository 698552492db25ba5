//! The number of samples that the judge needs.

use crate::robot::{failed, verdict};
use aghf::motion::sample;
use aghf_scenario::judge::{Check, Trajectory, sufficient_samples};
use aghf_scenario::{DirectOptions, Scenario, Solve};

/// The motion is swift at its end: its velocities are no cubics between 201 samples.
#[test]
fn a_swift_motion_has_more_samples() {
    let scenario = Scenario::load("kinova_obstacles_03").expect("built in");
    let options = DirectOptions {
        starts: Some(1),
        ..DirectOptions::default()
    };
    let report = Solve::new(&scenario).options(options).run();
    let report = report.expect("it is good");
    assert!(report.summary.success, "{:?}", report.summary.failure);
    let samples = sufficient_samples(&scenario, &report.curve).expect("same robot");
    let failed_with = |intervals| {
        let samples = sample(&scenario.model, &report.curve, intervals).expect("same robot");
        failed(&verdict(&scenario, &Trajectory::of_samples(samples)))
    };
    assert_eq!(failed_with(samples - 1), []);
    assert!(samples > 201, "{samples}");
    assert_eq!(failed_with((samples - 1) / 2), [Check::VelocityIsRate]);
}

/// No number of samples makes a motion that does not end at the goal pass.
#[test]
fn a_motion_that_is_not_valid_has_the_fewest() {
    let mut scenario = Scenario::load("pendulum_1_swingup").expect("built in");
    let options = DirectOptions {
        starts: Some(1),
        ..DirectOptions::default()
    };
    let report = Solve::new(&scenario).options(options).run();
    let report = report.expect("it is good");
    scenario.file.q_goal[0] += 1.0;
    let samples = sufficient_samples(&scenario, &report.curve).expect("same robot");
    assert_eq!(samples, 201);
}
