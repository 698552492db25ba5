//! Bounds on the speed of a point.

use crate::common::{any_model, config, numbers, robot};
use aghf::constraint::{AnyConstraint, Constraint, Evaluator, PointSpeedLimit};
use aghf::dynamics::forward_kinematics;
use aghf::model::Model;
use aghf::spatial::Placement;
use nalgebra::Vector3;
use num_dual::Dual64;
use proptest::prelude::*;

fn limit(body: Option<usize>) -> PointSpeedLimit {
    PointSpeedLimit { body, point: Vector3::new(0.3, -0.2, 0.4), most: 0.8, name: "tool".to_owned() }
}

fn value(model: &Model, row: &PointSpeedLimit, x: &[f64]) -> f64 {
    let mut g = [0.0];
    let mut evaluator = Evaluator::<f64>::new(model);
    let row = AnyConstraint::Speed(row.clone());
    evaluator.at(x).and_then(|at| at.value(&row, &mut g)).expect("its rows");
    g[0]
}

proptest! {
    #![proptest_config(config(48))]

    /// The speed is the rate of the position of the point along the velocities, by dual numbers.
    #[test]
    fn the_speed_is_the_rate_of_the_position((model, x, body) in any_model().prop_flat_map(|model| {
        let n = model.dof();
        (Just(model), numbers(2 * n), 0..n)
    })) {
        let (row, n) = (limit(Some(body)), model.dof());
        let q: Vec<Dual64> = (0..n).map(|i| Dual64::new(x[i], x[n + i])).collect();
        let mut placements = vec![Placement::identity(); n];
        forward_kinematics(&model, &q, &mut placements).expect("its joints");
        let at = &placements[body];
        let point = at.rotation * row.point.map(Dual64::from) + at.translation;
        let square: f64 = point.iter().map(|p| p.eps * p.eps).sum();
        prop_assert!((value(&model, &row, &x) - (square - 0.64)).abs() < 1e-11 * (1.0 + square));
    }
}

#[test]
fn a_scaled_row_is_a_speed_at_the_bound() {
    let model = robot("pendulum_1");
    let row = limit(Some(0));
    let scale = row.row_scales();
    let still = value(&model, &row, &[0.4, 0.0]);
    assert!((still + 0.64).abs() < 1e-15);
    // The speed is proportional to the velocity of the joint.
    let at_bound = (0.64 / (value(&model, &row, &[0.4, 1.0]) + 0.64)).sqrt();
    let beyond = value(&model, &row, &[0.4, 1.001 * at_bound]) / scale[0];
    assert!((beyond / 0.0008 - 1.0).abs() < 1e-2, "{beyond}");
    let label = row.label(0, &model);
    assert_eq!((&*label.name, label.unit), ("speed of frame 'tool'", "m/s"));
    assert!((value(&model, &limit(None), &[0.4, 3.0]) + 0.64).abs() < 1e-15);
}
