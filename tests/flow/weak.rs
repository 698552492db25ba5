//! The weak form of the flow: its functions, the action of a curve, and Lagrangians at the points of a quadrature.

use crate::common::{robot, wave};
use aghf::constraint::{CollisionSphere, Constraints, Sphere, SphereClearance, TorqueLimits};
use aghf::curve::{Curve, gauss_legendre};
use aghf::flow::weak::{
    Action, ActionDerivatives, AnalyticLagrangian, AugmentedLagrangian, DualLagrangian,
    LagrangianDerivatives, PointLagrangian, StateGrid, StatePoints,
};
use aghf::flow::{AghfLagrangian, Lagrangian};
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, Tanh};
use nalgebra::{DMatrix, DVector, Vector3};

/// A continuous curve of several polynomials.
fn curve(n: usize, segments: usize, degree: usize) -> Curve {
    let mut x = DMatrix::from_fn(2 * n, segments * (degree + 1), |i, j| {
        (0.3 + 1.7 * i as f64 + 2.9 * j as f64).sin()
    });
    for e in 1..segments {
        let end = x.column(e * (degree + 1) - 1).into_owned();
        x.set_column(e * (degree + 1), &end);
    }
    Curve::piecewise(1.3, segments, x).expect("they meet")
}

/// A curve in the basis is reproduced, also on more segments, and its ends are the first and the last coefficients.
#[test]
fn a_curve_of_the_basis_is_kept() {
    for (segments, degree) in [(1, 4), (1, 9), (3, 5)] {
        let curve = curve(2, segments, degree);
        for finer in [1, 2] {
            let grid = StateGrid::new(finer * segments, degree, 7, 1.3);
            let coefficients = grid.fit(&curve);
            assert_eq!(coefficients.ncols(), grid.count());
            let (first, last) = (
                coefficients.column(0),
                coefficients.column(grid.count() - 1),
            );
            assert_eq!(first, curve.at(0.0).0);
            assert_close!(last.iter(), curve.at(1.3).0.iter(), 1e-13);
            let back = grid.curve(&coefficients, 1.3).expect("within range");
            for i in 0..=40 {
                let t = 1.3 * f64::from(i) / 40.0;
                assert_close!(&back.at(t).0, &curve.at(t).0, 1e-12);
            }
            // The slips are those of the curve at the points.
            for e in 0..grid.segments() {
                let slips = grid.slips(&coefficients, e);
                for (g, slip) in slips.column_iter().enumerate() {
                    let (x, xdot) = curve.at(grid.times()[e * grid.points() + g]);
                    let expected = xdot.rows(0, 2) - x.rows(2, 2);
                    assert_close!(slip.iter(), expected.iter(), 1e-11);
                }
            }
        }
    }
    // A curve of higher degree is interpolated at the breakpoints, with the best rate in the mean square between them.
    let curve = curve(1, 1, 9);
    let grid = StateGrid::new(2, 4, 7, 1.3);
    let near = grid.curve(&grid.fit(&curve), 1.3).expect("within range");
    assert_close!(&near.at(0.65).0, &curve.at(0.65).0, 1e-12);
    assert!((near.at(0.2).0 - curve.at(0.2).0).amax() > 1e-4);
    let missing = |t: f64| near.at(t).1 - curve.at(t).1;
    let (nodes, weights) = gauss_legendre(20);
    for power in 0..4 {
        let moments = nodes
            .iter()
            .zip(&weights)
            .map(|(s, w)| missing(0.325 * (1.0 + s)) * (*w * s.powi(power)));
        let sum = moments.fold(DVector::zeros(2), |sum, moment| sum + moment);
        assert!(sum.amax() < 1e-11, "{power}: {sum}");
    }
}

/// Points for equalities come last in each segment and have no quadrature weight.
#[test]
fn collocated_points_are_apart() {
    let grid = StateGrid::collocated(2, 5, 8, 4, 3.0);
    assert_eq!((grid.points(), grid.times().len()), (12, 24));
    let held: Vec<_> = (0..24).filter(|g| grid.is_collocated(*g)).collect();
    assert_eq!(held, [8, 9, 10, 11, 20, 21, 22, 23]);
    assert!((grid.horizon() - 3.0).abs() < 1e-13);
    // The Gauss points of the second half.
    let (nodes, _) = gauss_legendre(4);
    for (s, t) in nodes.iter().zip(&grid.times()[20..]) {
        assert!((t - (2.25 + 0.75 * s)).abs() < 1e-13);
    }
}

/// Random coefficients on a grid, the lengths of the unknown ones, and the first of these.
fn start(grid: &StateGrid<f64>, n: usize) -> (DMatrix<f64>, usize) {
    let coefficients =
        DMatrix::from_column_slice(2 * n, grid.count(), &wave(2 * n * grid.count(), 0.9));
    (coefficients, 2 * n * (grid.count() - 2))
}

/// By central differences of the value and of the gradient.
fn agrees_with_differences<L: PointLagrangian<f64>>(
    grid: &StateGrid<f64>,
    lagrangian: L,
    n: usize,
) {
    const STEP: f64 = 1e-5;
    let mut action = Action::new(grid, lagrangian, n);
    let (at, unknowns) = start(grid, n);
    let mut ours = ActionDerivatives::new(grid, n);
    let value = action.derivatives(&at, &mut ours).expect("sizes agree");
    assert!((value - action.value(&at).expect("sizes agree")).abs() <= 1e-12 * value.abs());
    let along = DVector::from_vec(wave(unknowns, 2.3));
    let moved = |by: f64| {
        let mut moved = at.clone();
        let own = &mut moved.as_mut_slice()[2 * n..2 * n + unknowns];
        own.iter_mut()
            .zip(along.iter())
            .for_each(|(c, d)| *c += by * d);
        moved
    };
    let mut sides = Vec::new();
    for by in [STEP, -STEP] {
        let mut out = ActionDerivatives::new(grid, n);
        let value = action
            .derivatives(&moved(by), &mut out)
            .expect("sizes agree");
        sides.push((value, out.gradient));
    }
    let slope = (sides[0].0 - sides[1].0) / (2.0 * STEP);
    let expected = ours.gradient.dot(&along);
    assert!(
        (slope - expected).abs() < 1e-6 * expected.abs().max(value),
        "{slope} {expected}"
    );
    let rate = (&sides[0].1 - &sides[1].1) / (2.0 * STEP);
    let product = ours.hessian.to_dense() * &along;
    assert!(
        (&rate - &product).amax() < 1e-6 * product.amax(),
        "{rate} {product}"
    );
}

#[test]
fn the_derivatives_of_the_action_are_those_of_differences() {
    let model = robot("pendulum_3");
    for segments in [1, 3] {
        let grid = StateGrid::new(segments, 5, 9, 1.3);
        agrees_with_differences(&grid, AnalyticLagrangian::new(&model, 2.0), 3);
        agrees_with_differences(&grid, DualLagrangian::new(&model, AghfLagrangian, 2.0), 3);
        // With duals of the slip, and penalties of a passive joint, a violated limit and a sphere about the robot.
        let grid = StateGrid::collocated(segments, 5, 9, 4, 1.3);
        let points = CollisionSphere::joint_frames(&model);
        let sphere = Sphere {
            centre: Vector3::new(0.1, 0.4, -0.3),
            radius: 2.0,
        };
        let limits = Constraints {
            state: SphereClearance {
                balls: points,
                spheres: vec![sphere],
            },
            torque: TorqueLimits(vec![None, Some(0.0), Some(2.0)]),
            stage: Default::default(),
        };
        let mut plain = AnalyticLagrangian::new(&model, 2.0);
        plain.silent = (0..grid.times().len())
            .map(|g| grid.is_collocated(g))
            .collect();
        plain.slip_duals =
            DMatrix::from_column_slice(3, grid.times().len(), &wave(3 * grid.times().len(), 1.1));
        let augmented = AugmentedLagrangian::new(plain, &limits, &grid).expect("the same robot");
        agrees_with_differences(&grid, augmented, 3);
    }
}

/// All results of a Lagrangian at five points, which do not fill the SIMD lanes.
fn found(
    lagrangian: &mut impl PointLagrangian<f64>,
    n: usize,
    convex: bool,
) -> LagrangianDerivatives<f64> {
    let states = DMatrix::from_column_slice(4 * n, 5, &wave(20 * n, 0.7));
    let mut out = LagrangianDerivatives::new(n, 5);
    out.convex = convex;
    let at = StatePoints {
        first: 0,
        times: &[0.0, 0.1, 0.2, 0.3, 0.4],
        states: &states,
    };
    lagrangian.derivatives(at, &mut out).expect("sizes agree");
    out
}

/// The whole Hessian at point `g`.
fn hessian(of: &mut LagrangianDerivatives<f64>, g: usize) -> DMatrix<f64> {
    let size = of.gradients.nrows();
    let mut whole = DMatrix::zeros(2 * size, 2 * size);
    for kind in 0..4 {
        let block = DMatrix::from_column_slice(size, size, of.block_mut(g, kind));
        let at = (kind / 2 * size, kind % 2 * size);
        whole.view_mut(at, (size, size)).copy_from(&block);
    }
    whole
}

/// A saddle that changes with time.
struct Saddle;

impl Lagrangian for Saddle {
    fn value<S: AlgebraOver<f64> + Tanh>(
        &self,
        _: &Model,
        t: S,
        x: &[S],
        xdot: &[S],
        k: f64,
    ) -> aghf::Result<S> {
        Ok(t * x[0] * xdot[1] + (xdot[0] * xdot[0]).scale(k) - x[1] * x[1])
    }
}

#[test]
fn what_is_convex_has_no_negative_eigenvalues() {
    let model = robot("pendulum_1");
    let mut saddle = DualLagrangian::new(&model, Saddle, 3.0);
    let mut exact = found(&mut saddle, 1, false);
    let mut cut = found(&mut saddle, 1, true);
    assert_eq!(exact.gradients, cut.gradients);
    let t = 0.2;
    // In the order x[0], x[1], xdot[0], xdot[1].
    let by_hand = DMatrix::from_row_slice(
        4,
        4,
        &[
            0.0, 0.0, 0.0, t, //
            0.0, -2.0, 0.0, 0.0, //
            0.0, 0.0, 6.0, 0.0, //
            t, 0.0, 0.0, 0.0,
        ],
    );
    assert_close!(&hessian(&mut exact, 2), &by_hand, 1e-15);
    let half = 0.5 * t;
    let positive = DMatrix::from_row_slice(
        4,
        4,
        &[
            half, 0.0, 0.0, half, //
            0.0, 0.0, 0.0, 0.0, //
            0.0, 0.0, 6.0, 0.0, //
            half, 0.0, 0.0, half,
        ],
    );
    assert_close!(&hessian(&mut cut, 2), &positive, 1e-14);

    // The convex part of the analytic Lagrangian lacks only the curvature of the dynamics, so it is the Hessian where
    // that curvature vanishes.
    let model = robot("pendulum_3");
    let mut analytic = AnalyticLagrangian::new(&model, 2.0);
    let (mut exact, mut convex) = (
        found(&mut analytic, 3, false),
        found(&mut analytic, 3, true),
    );
    for g in 0..5 {
        let (exact, convex) = (hessian(&mut exact, g), hessian(&mut convex, g));
        assert!(convex.clone().symmetric_eigenvalues().min() > -1e-9 * convex.amax());
        assert!((&exact - &convex).amax() > 1e-3 * convex.amax());
        // The dynamics have no curvature in the rate of the state.
        assert_close!(
            &exact.view((6, 6), (6, 6)).into_owned(),
            &convex.view((6, 6), (6, 6)).into_owned(),
            1e-12
        );
    }
}

#[test]
fn another_robot_is_refused() {
    let (one, three) = (robot("pendulum_1"), robot("pendulum_3"));
    let grid = StateGrid::new(1, 5, 9, 1.3);
    let (at, _) = start(&grid, 3);
    let mut out = ActionDerivatives::new(&grid, 3);
    let mut analytic = Action::new(&grid, AnalyticLagrangian::new(&one, 1.0), 3);
    let mut dual = Action::new(&grid, DualLagrangian::new(&one, AghfLagrangian, 1.0), 3);
    assert!(analytic.value(&at).is_err() && dual.value(&at).is_err());
    assert!(
        analytic.derivatives(&at, &mut out).is_err() && dual.derivatives(&at, &mut out).is_err()
    );
    assert!(
        analytic.metric(&at, &mut out.hessian).is_err()
            && dual.metric(&at, &mut out.hessian).is_err()
    );
    let mut own = Action::new(&grid, AnalyticLagrangian::new(&three, 1.0), 3);
    assert!(own.value(&at).is_ok());
    assert!(own.value(&at.columns(1, 4).into_owned()).is_err());
    assert!(own.value(&at.rows(0, 4).into_owned()).is_err());
    let limits = Constraints {
        state: (),
        torque: TorqueLimits(vec![Some(1.0)]),
        stage: Default::default(),
    };
    assert!(
        AugmentedLagrangian::new(AnalyticLagrangian::new(&three, 1.0), &limits, &grid).is_err()
    );
}
