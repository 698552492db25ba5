//! Rows that are kept for a part of the time.

use crate::common::{assert_refused, config, robot};
use aghf::constraint::{
    AnyConstraint, Constraint, Constraints, Evaluator, FrameRows, PointSpeedLimit, StageConstraint, StageConstraints,
    StageInput, TimeWindow, TorqueLimits, Weights,
};
use aghf::curve::{Chebyshev, Curve};
use aghf::model::{Frame, Model};
use aghf::motion::violations;
use aghf::spatial::Placement;
use nalgebra::{DMatrix, Vector3};
use proptest::prelude::*;
use std::sync::Arc;

fn rows(model: &Model) -> Vec<AnyConstraint> {
    let tool = model.frames().last().expect("it has links");
    let rows = FrameRows::new(tool, Frame::new("goal", None, Placement::identity()));
    let rows = rows.within_distance(0.3).and_then(|rows| rows.within_angle(0.4)).expect("bounds");
    let speed =
        PointSpeedLimit { body: Some(6), point: Vector3::new(0.1, 0.0, 0.2), most: 0.5, name: "tool".to_owned() };
    vec![AnyConstraint::Frame(rows), AnyConstraint::Speed(speed)]
}

/// Within the times the rows and their derivatives are those of the constraints; elsewhere they are constant and
/// negative.
#[test]
fn rows_are_those_of_the_state_within_their_times() {
    let model = robot("kinova_gen3");
    let rows = rows(&model);
    let window = TimeWindow::new(model.clone(), rows.clone(), [0.5, 1.0]).expect("times");
    let [q, v] = [[0.3, -0.4, 0.1, 1.0, 0.2, -0.3, 0.5], [0.5, 0.1, -0.7, 0.2, 0.4, 0.9, -0.3]];
    let input = |t| StageInput { t, q: &q, v: &v, a: &[0.0; 7], u: &[0.0; 7] };
    let x = [q, v].concat();
    let mut evaluator = Evaluator::<f64>::new(&model);
    let mut placed = evaluator.at(&x).expect("its joints");
    let (mut g, mut expected) = (vec![0.0; 3], vec![0.0; 3]);
    placed.value(&rows, &mut expected).expect("its rows");
    let multipliers = [0.7, -1.2, 0.4];
    let weights = Weights { first_order: &multipliers, gauss_newton: Some(&[0.0; 3]) };
    let sums = placed.weighted_derivatives(&rows, weights).expect("its rows");
    for t in [0.5, 0.7, 1.0] {
        window.value(&input(t), &mut g).expect("three rows");
        assert_eq!(g, expected);
        let (mut gradients, mut hessian) = (DMatrix::zeros(28, 3), DMatrix::from_element(28, 28, 1.0));
        window.derivatives(&input(t), &multipliers, &mut gradients, &mut hessian).expect("three rows");
        let sum = &gradients * nalgebra::Vector3::from(multipliers);
        assert_close!(&sum.as_slice()[..14], sums.gradient(), 1e-14);
        assert!(sum.rows(14, 14).amax() == 0.0);
        hessian.add_scalar_mut(-1.0);
        assert_close!(&hessian.view((0, 0), (14, 14)).into_owned(), sums.hessian(), 1e-14);
        assert_eq!(hessian.view((14, 0), (14, 28)).amax(), 0.0);
    }
    for t in [0.0, 0.499, 1.001] {
        window.value(&input(t), &mut g).expect("three rows");
        assert!(g.iter().enumerate().all(|(row, g)| *g == -window.scale(row) && *g < 0.0));
        let (mut gradients, mut hessian) = (DMatrix::from_element(28, 3, 1.0), DMatrix::zeros(28, 28));
        window.derivatives(&input(t), &multipliers, &mut gradients, &mut hessian).expect("three rows");
        assert_eq!((gradients.amax(), hessian.amax()), (0.0, 0.0));
    }
    assert_eq!(window.label(2, &model), rows.label(2, &model));
}

#[test]
fn equalities_and_times_in_the_wrong_order_are_refused() {
    let model = robot("kinova_gen3");
    let tool = model.frames().last().expect("it has links").clone();
    let found = TimeWindow::new(model.clone(), rows(&model), [1.0, 1.0]);
    assert_refused(found, "they are 1 s and 1 s, the first one is to be before the second");
    let at = FrameRows::new(&tool, Frame::new("goal", None, Placement::identity())).at_origin();
    let found = TimeWindow::new(model, vec![AnyConstraint::Frame(at)], [0.0, 1.0]);
    assert_refused(found, "position along x of frame");
}

/// A violation of a row is a difference of squares or of cosines, and its excess one of speeds or of angles.
#[test]
fn the_excess_of_a_row_is_in_its_unit() {
    let model = robot("kinova_gen3");
    let window = TimeWindow::new(model.clone(), rows(&model), [0.5, 1.0]).expect("times");
    let all = Constraints {
        state: Vec::<AnyConstraint>::new(),
        torque: TorqueLimits(Vec::new()),
        stage: StageConstraints { custom: vec![Arc::new(window)], ..StageConstraints::default() },
    };
    let excess = |row, by| all.excess(row, by, &model);
    assert!((excess(0, 1.2_f64.powi(2) - 0.3_f64.powi(2)) - 0.9).abs() < 1e-14);
    assert!((excess(1, 2.0 * (0.4_f64.cos() - 2.0_f64.cos())) - 1.6).abs() < 1e-14);
    assert!((excess(2, 0.0 - 0.5_f64.powi(2)) + 0.5).abs() < 1e-14);
    assert_eq!(excess(2, f64::INFINITY), f64::INFINITY);
}

proptest! {
    #![proptest_config(config(64))]

    /// The largest value of a row that is kept between two times is that of a dense evaluation between them, at these
    /// times too, and a motion that ends before has none.
    #[test]
    fn violations_are_those_within_the_times(
        entries in proptest::collection::vec(-1.0..1.0, 14 * 7), from in -0.2..2.2, length in 1e-3..1.5,
        steps in 3..40_usize
    ) {
        let (model, to) = (robot("kinova_gen3"), from + length);
        let rows = rows(&model);
        let window = TimeWindow::new(model.clone(), rows.clone(), [from, to]).expect("times");
        let all = Constraints {
            state: Vec::<AnyConstraint>::new(),
            torque: TorqueLimits(Vec::new()),
            stage: StageConstraints { custom: vec![Arc::new(window)], ..StageConstraints::default() },
        };
        let chebyshev = Chebyshev::new(6, 2.0).expect("a degree");
        let curve = Curve::new(chebyshev, DMatrix::from_vec(14, 7, entries)).expect("nodes");
        let found = violations(&model, &curve, &all, steps).expect("its joints");
        let mut most = [f64::NEG_INFINITY; 3];
        let (first, last) = (from.max(0.0), to.min(2.0));
        let mut evaluator = Evaluator::<f64>::new(&model);
        for k in (0..=2000).filter(|_| first <= last) {
            let t = first + (last - first) * f64::from(k) / 2000.0;
            let mut g = vec![0.0; 3];
            let state = curve.at(t).0;
            evaluator.at(state.as_slice()).and_then(|placed| placed.value(&rows, &mut g)).expect("its rows");
            for (most, g) in most.iter_mut().zip(&g) {
                *most = most.max(*g);
            }
        }
        for (violation, most) in found.iter().zip(most) {
            // Between few times a maximum may be missed.
            let is_bound = violation.by <= most || violation.by <= most + 1e-3 * most.abs().max(1.0);
            prop_assert!(is_bound, "{violation:?} {most}");
            let is_kept = (first..=last).contains(&violation.at_s);
            prop_assert!(is_kept == most.is_finite(), "{violation:?}");
        }
        let fine = violations(&model, &curve, &all, 2000).expect("its joints");
        for (violation, most) in fine.iter().zip(most).filter(|(_, most)| most.is_finite()) {
            prop_assert!((violation.by - most).abs() < 1e-4 * most.abs().max(1.0), "{violation:?} {most}");
        }
    }
}
