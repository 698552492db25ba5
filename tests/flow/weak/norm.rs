//! The metric of a flow in its weak form.

use crate::common::{robot, wave};
use aghf::cost::{Point, PointCost, PointDerivatives};
use aghf::dynamics::{Data, crba};
use aghf::flow::ActuationMetric;
use aghf::flow::weak::{Norm, RestMetric};
use aghf::model::Model;
use nalgebra::DMatrix;
use std::f64::consts::PI;

/// The metric at a point of a robot with `n` joints.
fn at(model: &Model, kind: RestMetric, n: usize) -> aghf::Result<DMatrix<f64>> {
    let (x, xdot) = (wave(2 * n, 0.7), wave(2 * n, 1.9));
    let mut out = PointDerivatives::new(2 * n);
    let mut norm = Norm { model, kind, metric: ActuationMetric::default(), k: 5.0, horizon: 1.5 };
    let point = Point { index: 0, phase: 0, time: 0.0, q: &x, v: &xdot, a: &xdot };
    assert_eq!(norm.derivatives(point, &mut out)?, norm.value(point)?);
    assert_eq!((out.gradient.amax(), out.hessian.amax()), (0.0, 0.0));
    Ok(out.metric)
}

#[test]
fn it_is_that_of_the_flow_or_of_the_velocities() {
    let model = robot("pendulum_2");
    let mut h = DMatrix::zeros(2, 2);
    let q = &wave(4, 0.7)[..2];
    crba(&model, &mut Data::new(&model), q, &mut h).expect("sizes agree");
    // In the order q, v, rate of q, and rates that do not count.
    let mut expected = DMatrix::zeros(12, 12);
    expected.view_mut((0, 0), (2, 2)).fill_diagonal(5.0);
    expected.view_mut((2, 2), (2, 2)).copy_from(&(&h * &h));
    let ours = at(&model, RestMetric::Flow, 2).expect("sizes agree");
    assert_close!(&ours, &expected, 1e-12);
    expected.fill(0.0);
    expected.view_mut((2, 2), (4, 4)).fill_diagonal(0.75 / (PI * PI));
    let ours = at(&model, RestMetric::Velocity, 2).expect("sizes agree");
    assert_close!(&ours, &expected, 1e-15);
    assert!(at(&model, RestMetric::Flow, 3).is_err());
}
