//! Lagrangians at the points of a quadrature by dual numbers.

use crate::common::{robot, wave};
use aghf::cost::{ControlEffort, Point, PointCost, PointDerivatives};
use aghf::flow::weak::{DualLagrangian, WithSlip};
use aghf::flow::{AghfLagrangian, Lagrangian};
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, Tanh};
use nalgebra::DMatrix;

/// The value and the derivatives at one point.
fn found(lagrangian: &mut impl PointCost<f64>, x: &[f64], xdot: &[f64]) -> aghf::Result<(f64, PointDerivatives<f64>)> {
    let mut out = PointDerivatives::new(x.len());
    let rest = vec![0.0; x.len()];
    let point = Point { index: 0, phase: 0, time: 0.2, q: x, v: xdot, a: &rest };
    let value = lagrangian.derivatives(point, &mut out)?;
    assert_eq!(value, lagrangian.value(point)?);
    Ok((value, out))
}

/// A saddle that changes with time.
struct Saddle;

impl Lagrangian for Saddle {
    fn value<S: AlgebraOver<f64> + Tanh>(&self, _: &Model, t: S, x: &[S], xdot: &[S], k: f64) -> aghf::Result<S> {
        Ok(t * x[0] * xdot[1] + (xdot[0] * xdot[0]).scale(k) - x[1] * x[1])
    }
}

#[test]
fn the_derivatives_of_a_saddle_are_those_by_hand() {
    let model = robot("pendulum_1");
    let mut saddle = DualLagrangian::new(&model, Saddle, 3.0);
    let (x, xdot) = ([0.3, -0.7], [1.1, 0.4]);
    let (value, ours) = found(&mut saddle, &x, &xdot).expect("sizes agree");
    let t = 0.2;
    assert!((value - (t * 0.3 * 0.4 + 3.0 * 1.1 * 1.1 - 0.7 * 0.7)).abs() < 1e-15);
    let gradient = [t * 0.4, 1.4, 6.6, t * 0.3, 0.0, 0.0];
    assert_close!(ours.gradient.iter(), gradient.iter(), 1e-15);
    // In the order x[0], x[1], xdot[0], xdot[1].
    let mut hessian = DMatrix::zeros(6, 6);
    hessian[(0, 3)] = t;
    hessian[(3, 0)] = t;
    hessian[(1, 1)] = -2.0;
    hessian[(2, 2)] = 6.0;
    assert_close!(&ours.hessian, &hessian, 1e-15);
    assert!(found(&mut saddle, &[0.0; 4], &[0.0; 4]).is_err());
}

/// The paper's Lagrangian is that of the effort with its slip, which has derivatives by hand.
#[test]
fn the_lagrangian_of_the_paper_has_the_same_derivatives_by_hand() {
    let model = robot("pendulum_3");
    let (x, xdot) = (wave(6, 0.7), wave(6, 1.9));
    let mut duals = DualLagrangian::new(&model, AghfLagrangian, 2.0);
    let mut by_hand = WithSlip::new(ControlEffort::new(&model), 2.0, 3, 1);
    let [ours, expected] =
        [found(&mut duals, &x, &xdot), found(&mut by_hand, &x, &xdot)].map(|found| found.expect("sizes agree"));
    assert!((ours.0 - expected.0).abs() < 1e-12 * expected.0);
    let size = expected.1.hessian.amax();
    assert_close!(&ours.1.gradient, &expected.1.gradient, 1e-12 * size);
    assert_close!(&ours.1.hessian, &expected.1.hessian, 1e-12 * size);
}
