//! Rows that are kept for a part of the time.

use crate::common::{assert_refused, robot};
use aghf::constraint::{
    AnyConstraint, Between, Constraint, Constraints, Evaluator, FrameRows, PointSpeedLimit,
    StageConstraint, StageConstraints, StageInput, TorqueLimits, Weights,
};
use aghf::model::{Frame, Model};
use aghf::spatial::Placement;
use nalgebra::{DMatrix, Vector3};
use std::sync::Arc;

fn rows(model: &Model) -> Vec<AnyConstraint> {
    let tool = model.frames().last().expect("it has links");
    let rows = FrameRows::new(tool, Frame::new("goal", None, Placement::identity()));
    let rows = rows
        .within_distance(0.3)
        .and_then(|rows| rows.within_angle(0.4))
        .expect("bounds");
    let speed = PointSpeedLimit {
        body: Some(6),
        point: Vector3::new(0.1, 0.0, 0.2),
        most: 0.5,
        name: "tool".to_owned(),
    };
    vec![AnyConstraint::Frame(rows), AnyConstraint::Speed(speed)]
}

/// Within the times the rows and their derivatives are those of the constraints; elsewhere they are constant and
/// negative.
#[test]
fn rows_are_those_of_the_state_within_their_times() {
    let model = robot("kinova_gen3");
    let rows = rows(&model);
    let between = Between::new(model.clone(), rows.clone(), [0.5, 1.0]).expect("times");
    let [q, v] = [
        [0.3, -0.4, 0.1, 1.0, 0.2, -0.3, 0.5],
        [0.5, 0.1, -0.7, 0.2, 0.4, 0.9, -0.3],
    ];
    let input = |t| StageInput {
        t,
        q: &q,
        v: &v,
        a: &[0.0; 7],
        u: &[0.0; 7],
    };
    let x = [q, v].concat();
    let mut evaluator = Evaluator::<f64>::new(&model);
    let mut placed = evaluator.at(&x).expect("its joints");
    let (mut g, mut expected) = (vec![0.0; 3], vec![0.0; 3]);
    placed.value(&rows, &mut expected).expect("its rows");
    let multipliers = [0.7, -1.2, 0.4];
    let weights = Weights {
        first_order: &multipliers,
        gauss_newton: Some(&[0.0; 3]),
    };
    let sums = placed
        .weighted_derivatives(&rows, weights)
        .expect("its rows");
    for t in [0.5, 0.7, 1.0] {
        between.value(&input(t), &mut g).expect("three rows");
        assert_eq!(g, expected);
        let (mut gradients, mut hessian) =
            (DMatrix::zeros(28, 3), DMatrix::from_element(28, 28, 1.0));
        between
            .derivatives(&input(t), &multipliers, &mut gradients, &mut hessian)
            .expect("three rows");
        let sum = &gradients * nalgebra::Vector3::from(multipliers);
        assert_close!(&sum.as_slice()[..14], sums.gradient(), 1e-14);
        assert!(sum.rows(14, 14).amax() == 0.0);
        hessian.add_scalar_mut(-1.0);
        assert_close!(
            &hessian.view((0, 0), (14, 14)).into_owned(),
            sums.hessian(),
            1e-14
        );
        assert_eq!(hessian.view((14, 0), (14, 28)).amax(), 0.0);
    }
    for t in [0.0, 0.499, 1.001] {
        between.value(&input(t), &mut g).expect("three rows");
        assert!(
            g.iter()
                .enumerate()
                .all(|(row, g)| *g == -between.scale(row) && *g < 0.0)
        );
        let (mut gradients, mut hessian) =
            (DMatrix::from_element(28, 3, 1.0), DMatrix::zeros(28, 28));
        between
            .derivatives(&input(t), &multipliers, &mut gradients, &mut hessian)
            .expect("three rows");
        assert_eq!((gradients.amax(), hessian.amax()), (0.0, 0.0));
    }
    assert_eq!(between.label(2, &model), rows.label(2, &model));
}

#[test]
fn equalities_and_times_in_the_wrong_order_are_refused() {
    let model = robot("kinova_gen3");
    let tool = model.frames().last().expect("it has links").clone();
    let found = Between::new(model.clone(), rows(&model), [1.0, 1.0]);
    assert_refused(
        found,
        "they are 1 s and 1 s, the first one is to be before the second",
    );
    let at = FrameRows::new(&tool, Frame::new("goal", None, Placement::identity())).at_origin();
    let found = Between::new(model, vec![AnyConstraint::Frame(at)], [0.0, 1.0]);
    assert_refused(found, "position along x of frame");
}

/// A violation of a row is a difference of squares or of cosines, and its excess one of speeds or of angles.
#[test]
fn the_excess_of_a_row_is_in_its_unit() {
    let model = robot("kinova_gen3");
    let between = Between::new(model.clone(), rows(&model), [0.5, 1.0]).expect("times");
    let all = Constraints {
        state: Vec::<AnyConstraint>::new(),
        torque: TorqueLimits(Vec::new()),
        stage: StageConstraints {
            others: vec![Arc::new(between)],
            ..StageConstraints::default()
        },
    };
    let excess = |row, by| all.excess(row, by, &model);
    assert!((excess(0, 1.2_f64.powi(2) - 0.3_f64.powi(2)) - 0.9).abs() < 1e-14);
    assert!((excess(1, 2.0 * (0.4_f64.cos() - 2.0_f64.cos())) - 1.6).abs() < 1e-14);
    assert!((excess(2, 0.0 - 0.5_f64.powi(2)) + 0.5).abs() < 1e-14);
    assert_eq!(excess(2, f64::INFINITY), f64::INFINITY);
}
