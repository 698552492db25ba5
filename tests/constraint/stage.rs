//! Rows in $(t, q, v, a, u)$: their derivatives, names and checks.

use crate::common::{robot, slider};
use aghf::constraint::{
    Constraints, Quantity, RateLimit, StageConstraint, StageConstraints, StageInput, StageRows, TorqueLimits,
};
use nalgebra::DMatrix;
use std::sync::Arc;

/// The power of the first joint beyond a limit that grows with time, and a coupling of all parts of the input.
fn rows() -> Arc<dyn StageConstraint> {
    Arc::new(StageRows::new("power", vec![10.0, 2.0], |at, g| {
        g[0] = at.u[0] * at.v[0] - at.t * at.t - 3.0;
        g[1] = at.q[0] * at.a[1] * at.a[1] + at.u[1] * at.q[1];
    }))
}

#[test]
fn derivatives_of_a_closure_are_those_by_hand() {
    let [q, v, a, u] = [[0.3, -0.8], [1.1, 0.2], [-0.4, 2.0], [5.0, -7.0]];
    let at = StageInput { t: 0.6, q: &q, v: &v, a: &a, u: &u };
    let rows = rows();
    let (mut g, mut rates) = ([0.0; 2], [0.0; 2]);
    rows.value(&at, &mut g).expect("two rows");
    rows.time_rates(&at, &mut rates).expect("two rows");
    assert_eq!(g, [5.5 - 0.36 - 3.0, 0.3 * 4.0 + 7.0 * 0.8]);
    assert_eq!(rates, [-1.2, 0.0]);
    let (mut gradients, mut hessian) = (DMatrix::zeros(8, 2), DMatrix::zeros(8, 8));
    rows.derivatives(&at, &[2.0, 3.0], &mut gradients, &mut hessian).expect("two rows");
    let mut expected = DMatrix::zeros(8, 2);
    (expected[(2, 0)], expected[(6, 0)]) = (u[0], v[0]);
    (expected[(0, 1)], expected[(1, 1)]) = (a[1] * a[1], u[1]);
    (expected[(5, 1)], expected[(7, 1)]) = (2.0 * q[0] * a[1], q[1]);
    assert_close!(&gradients, &expected, 1e-15);
    let mut expected = DMatrix::zeros(8, 8);
    for (i, j, second) in [(2, 6, 2.0), (0, 5, 3.0 * 2.0 * a[1]), (1, 7, 3.0)] {
        (expected[(i, j)], expected[(j, i)]) = (second, second);
    }
    expected[(5, 5)] = 3.0 * 2.0 * q[0];
    assert_close!(&hessian, &expected, 1e-15);
}

#[test]
fn rows_have_names_and_units() {
    let model = robot("pendulum_2");
    let limits = StageConstraints {
        rates: [RateLimit::both(2, 1, 4.0), RateLimit::both(3, 0, 9.0)].concat(),
        foot: None,
        phases: Vec::new(),
        custom: vec![rows()],
    };
    limits.check(&model).expect("valid");
    assert_eq!(limits.dim(), 6);
    let all = Constraints { state: (), torque: TorqueLimits(vec![Some(1.0), None]), stage: limits };
    assert_eq!(all.dim(), 8);
    let label = |row| all.label(row, &model);
    let joint = |i: usize| model.joints()[i].name();
    let name = format!("lower acceleration limit of joint '{}'", joint(1));
    assert_eq!((label(3).name, label(3).unit), (name, "rad/s^2"));
    let name = format!("upper jerk limit of joint '{}'", joint(0));
    assert_eq!((label(4).name, label(4).quantity, label(4).joint), (name, Quantity::Jerk, Some(0)));
    assert_eq!(label(7).name, "row 1 of power");
    assert_eq!((label(1).quantity, label(1).joint), (Quantity::Torque, Some(0)));
}

#[test]
fn invalid_limits_are_refused_by_joint() {
    let model = slider(1.0);
    let refused = |order: usize, joint: usize, limit: f64| {
        let rates = RateLimit::both(order, joint, limit).to_vec();
        let limits = StageConstraints { rates, ..StageConstraints::default() };
        limits.check(&model).expect_err("invalid").to_string()
    };
    let name = model.joints()[0].name();
    let zero = refused(2, 0, 0.0);
    assert!(zero.contains(name) && zero.contains("acceleration limit: it is 0"), "{zero}");
    assert!(refused(2, 1, 3.0).contains("there is no joint 1"));
    assert!(refused(1, 0, 3.0).contains("is 1 and must be from 2 to 3"));
}

#[test]
fn a_scale_that_is_not_positive_is_refused() {
    let model = slider(1.0);
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let rows = StageRows::new("power", vec![1.0, bad], |_, _| {});
        let all = Constraints {
            state: (),
            torque: TorqueLimits(Vec::new()),
            stage: StageConstraints { custom: vec![Arc::new(rows)], ..StageConstraints::default() },
        };
        let refused = all.check(&model).expect_err("a scale").to_string();
        let words = format!("scale of row 1 of power: it is {bad} and must be a positive number");
        assert!(refused.contains(&words), "{refused}");
    }
}
