//! Simulations of the control along a curve.

use crate::common::robot;
use crate::run::consistent;
use aghf::model::pendulum;
use aghf::motion::{Feedback, sample, simulate};

/// The control of a dynamically consistent curve takes the robot along it, without any feedback.
#[test]
fn open_loop_control_follows_a_consistent_curve() {
    for (name, c, bound) in [("pendulum_1", 0.4, 1e-6), ("pendulum_2", 0.2, 1e-4), ("pendulum_3", 0.1, 1e-3)] {
        let model = robot(name);
        let curve = consistent(&model, c);
        let end = simulate(&model, &curve, Feedback::NONE, &[]).expect("same robot");
        assert_eq!(end.failure, None);
        assert!(end.error_inf < bound, "{name}: {:e}", end.error_inf);
        assert_eq!(end.state.len(), 2 * model.dof());
    }
}

/// Feedback holds an arm with light wrists that would drift away open loop.
#[test]
fn feedback_follows_where_open_loop_drifts() {
    let model = robot("kinova_gen3");
    let curve = consistent(&model, 0.5);
    let gains = Feedback { kp: 10.0, kv: 10.0 };
    let end = simulate(&model, &curve, gains, &[]).expect("same robot");
    assert_eq!(end.failure, None);
    assert!(end.error_inf < 1e-6, "{:e}", end.error_inf);
    // A wrong sign of the feedback pushes away.
    let wrong = Feedback { kp: -10.0, kv: -10.0 };
    let pushed = simulate(&model, &curve, wrong, &[]).expect("same robot");
    assert!(pushed.error_inf > 1.0);
}

#[test]
fn samples_are_on_the_curve() {
    let model = pendulum(2).expect("two links");
    let curve = consistent(&model, 0.3);
    let samples = sample(&model, &curve, 10).expect("same robot");
    assert_eq!(samples.len(), 11);
    for s in samples {
        let q = 0.3 * s.t * s.t * (2.0 - s.t);
        assert_close!(&s.q, &[q, q], 1e-13);
        assert_close!(&s.qdot, &s.v, 1e-12);
        assert_close!(&s.a, &[0.3 * (4.0 - 6.0 * s.t); 2], 1e-12);
    }
}
