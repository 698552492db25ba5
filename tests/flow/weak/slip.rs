//! A running cost along a curve in the state, with its slip.

use crate::common::{robot, wave};
use aghf::cost::{ControlEffort, Point, PointCost};
use aghf::curve::{Basis, Continuity};
use aghf::flow::AghfLagrangian;
use aghf::flow::weak::{DualLagrangian, WithSlip};
use aghf::transcription::{Derivatives, Grid, Objective};
use nalgebra::{DMatrix, DVector};

/// The horizon, s.
const HORIZON: f64 = 1.3;

/// `segments` polynomials of degree 5 in the state, in normalised time.
fn grid(segments: usize) -> Grid<f64> {
    Grid::new(&Basis::new(segments, 5, Continuity::STATE), 9, 1.0)
}

/// By central differences of the value and of the gradient.
fn agrees_with_differences<L: PointCost<f64>>(grid: &Grid<f64>, lagrangian: L, n: usize) {
    const STEP: f64 = 1e-5;
    let mut action = Objective::new(grid, lagrangian, 2 * n);
    action.set_horizon(HORIZON);
    let at = DMatrix::from_column_slice(2 * n, grid.count(), &wave(2 * n * grid.count(), 0.9));
    let unknowns = 2 * n * (grid.count() - 2);
    let mut ours = Derivatives::new(grid, 2 * n);
    let mut derive = |at: &DMatrix<f64>, out: &mut Derivatives<f64>| {
        let value = action.gradient_and_hessian(at, out).expect("sizes agree");
        let alone = action.value(at).expect("sizes agree");
        assert!((value - alone).abs() <= 1e-12 * value.abs());
        value
    };
    let value = derive(&at, &mut ours);
    let along = DVector::from_vec(wave(unknowns, 2.3));
    let mut sides = Vec::new();
    for by in [STEP, -STEP] {
        let mut moved = at.clone();
        let own = &mut moved.as_mut_slice()[2 * n..2 * n + unknowns];
        own.iter_mut().zip(along.iter()).for_each(|(c, d)| *c += by * d);
        let mut out = Derivatives::new(grid, 2 * n);
        let value = derive(&moved, &mut out);
        sides.push((value, out.gradient));
    }
    let slope = (sides[0].0 - sides[1].0) / (2.0 * STEP);
    let expected = ours.gradient.dot(&along);
    assert!((slope - expected).abs() < 1e-6 * expected.abs().max(value), "{slope} {expected}");
    let rate = (&sides[0].1 - &sides[1].1) / (2.0 * STEP);
    let product = ours.hessian.to_dense() * &along;
    assert!((&rate - &product).amax() < 1e-6 * product.amax(), "{rate} {product}");
}

#[test]
fn the_derivatives_of_the_action_are_those_of_differences() {
    let model = robot("pendulum_3");
    for segments in [1, 3] {
        let grid = grid(segments);
        let points = 9 * segments;
        let mut lagrangian = WithSlip::new(ControlEffort::new(&model), 2.0, 3, points);
        lagrangian.multipliers = DMatrix::from_column_slice(3, points, &wave(3 * points, 1.1));
        agrees_with_differences(&grid, lagrangian, 3);
        agrees_with_differences(&grid, DualLagrangian::new(&model, AghfLagrangian, 2.0), 3);
    }
}

/// The value is that by hand, and the slips are those of the last evaluation.
#[test]
fn the_slip_costs_its_square_and_its_multiplier() {
    let model = robot("pendulum_2");
    let (x, xdot, rest) = (wave(4, 0.7), wave(4, 1.9), [0.0; 4]);
    let mut lagrangian = WithSlip::new(ControlEffort::new(&model), 3.0, 2, 5);
    lagrangian.multipliers = DMatrix::from_column_slice(2, 5, &wave(10, 1.1));
    let point = |q, v, a| Point { index: 4, phase: 0, time: 0.2, q, v, a };
    let ours = lagrangian.value(point(&x, &xdot, &rest)).expect("sizes agree");
    let effort = ControlEffort::new(&model).value(point(&x[..2], &x[2..], &xdot[2..]));
    let mut expected = effort.expect("sizes agree");
    for i in 0..2 {
        let slip = xdot[i] - x[2 + i];
        expected += 3.0 * slip * slip + lagrangian.multipliers[(i, 4)] * slip;
        assert_eq!(lagrangian.slips()[(i, 4)], slip);
    }
    assert!((ours - expected).abs() < 1e-12, "{ours} {expected}");
}

#[test]
fn another_robot_is_refused() {
    let (one, three) = (robot("pendulum_1"), robot("pendulum_3"));
    let grid = grid(1);
    let at = DMatrix::from_element(6, grid.count(), 0.1);
    let mut out = Derivatives::new(&grid, 6);
    let other = WithSlip::new(ControlEffort::new(&one), 1.0, 1, 9);
    let mut other = Objective::new(&grid, other, 6);
    assert!(other.value(&at).is_err() && other.derivatives(&at, &mut out).is_err());
    let own = WithSlip::new(ControlEffort::new(&three), 1.0, 3, 9);
    let mut own = Objective::new(&grid, own, 6);
    assert!(own.value(&at).is_ok());
    assert!(own.value(&at.columns(1, 4).into_owned()).is_err());
    assert!(own.value(&at.rows(0, 4).into_owned()).is_err());
}
