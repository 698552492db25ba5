//! The boundary value problem.

use crate::common::{point_mass, robot};
use aghf::motion::Problem;
use nalgebra::Vector3;

/// A joint that slides counts with its way from start to goal, a joint that turns with its link alone, and velocities
/// do not count.
#[test]
fn the_reach_is_that_of_links_and_sliders() {
    let point = point_mass(&[Vector3::x(), Vector3::y()]);
    let goal = vec![3.0, -4.0, 9.0, 9.0];
    let across = Problem::new(&point, vec![1.0, 0.0, 0.0, 0.0], goal, 1.0).expect("valid");
    assert_eq!(across.reach(), 6.0);

    let arm = robot("pendulum_3");
    let lengths = arm.joints().iter().map(|joint| joint.origin().translation.norm());
    let (length, n) = (lengths.sum::<f64>(), arm.dof());
    assert!(length > 0.0);
    for turned in [0.0, 2.0] {
        let goal = vec![turned; 2 * n];
        let turn = Problem::new(&arm, vec![0.0; 2 * n], goal, 1.0).expect("valid");
        assert_eq!(turn.reach(), length);
    }
}
