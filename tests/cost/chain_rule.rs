//! Running costs through the inverse dynamics: their derivatives.

use crate::common::tree;
use aghf::cost::{
    ControlEffort, CostThroughDynamics, HyperDual64, Point, PointCost, PointDerivatives, StageInput, WeightedSquares,
};
use aghf::dynamics::{Data, rnea};
use aghf::model::Model;
use nalgebra::DMatrix;
use num_dual::DualNum;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A point of a robot with `n` joints in `z`.
fn point(z: &[f64]) -> Point<'_, f64> {
    let n = z.len() / 3;
    Point { index: 0, phase: 0, time: 0.7, q: &z[..n], v: &z[n..2 * n], a: &z[2 * n..] }
}

/// A random robot at a random point.
fn anywhere(n: usize, seed: u64) -> (Model, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let z = (0..3 * n).map(|_| rng.random_range(-1.0..1.0)).collect();
    (tree(n, seed), z)
}

fn derivatives<P: PointCost<f64>>(cost: &mut P, z: &[f64]) -> (f64, PointDerivatives<f64>) {
    let mut out = PointDerivatives::new(z.len() / 3);
    // Nothing of what was there before is left.
    out.hessian.fill(7.0);
    let value = cost.derivatives(point(z), &mut out).expect("sizes agree");
    let again = cost.value(point(z)).expect("sizes agree");
    assert!((value - again).abs() <= 1e-12 * (1.0 + value.abs()));
    (value, out)
}

/// A cost of everything, with curvature of both signs.
fn mixed(at: &StageInput<'_, HyperDual64>) -> HyperDual64 {
    let n = at.q.len();
    (0..n).fold(at.t * at.t, |sum, i| {
        let j = (i + 1) % n;
        let power = at.u[i] * at.v[i];
        sum + power * power + at.q[i].sin() * at.u[j] * at.t + at.a[i] * at.v[j] * at.q[j] + at.a[i] * at.u[j] * 0.3
    })
}

/// The chain rule, against numbers that move twice through the inverse dynamics.
#[test]
fn derivatives_are_those_of_duals_through_the_dynamics() {
    for (n, seed) in [(1, 3), (3, 1), (4, 6)] {
        let (model, z) = anywhere(n, seed);
        let (_, out) = derivatives(&mut CostThroughDynamics::new(&model, mixed), &z);
        let (mut gradient, mut hessian) = (vec![0.0; 3 * n], DMatrix::zeros(3 * n, 3 * n));
        for i in 0..3 * n {
            for j in 0..3 * n {
                let mut z: Vec<HyperDual64> = z.iter().map(|x| HyperDual64::from(*x)).collect();
                z[i].eps1 = 1.0;
                z[j].eps2 = 1.0;
                let (q, rest) = z.split_at(n);
                let (v, a) = rest.split_at(n);
                let mut u = vec![HyperDual64::from(0.0); n];
                rnea(&model, &mut Data::new(&model), q, v, a, &mut u).expect("sizes agree");
                let t = HyperDual64::from(0.7);
                let l = mixed(&StageInput { t, q, v, a, u: &u });
                hessian[(i, j)] = l.eps1eps2;
                gradient[i] = l.eps1;
            }
        }
        // Sums of some hundred products in another order.
        assert_close!(&out.gradient, &gradient, 1e-12);
        assert_close!(&out.hessian, &hessian, 1e-12);
        let least = out.metric.clone().symmetric_eigenvalues().min();
        assert!(least >= -1e-12 * out.metric.amax(), "{least}");
        assert!(out.metric.amax() > 0.0);
    }
}

/// Squares: what is written by hand is what duals say, and of torques alone it is the control effort with its metric.
#[test]
fn weighted_squares_are_those_of_duals_and_of_the_effort() {
    for (n, seed) in [(2, 4), (5, 5)] {
        let (model, z) = anywhere(n, seed);
        let weights = |from: f64| -> Vec<f64> { (0..n).map(|i| from + i as f64).collect() };
        let squares = |x: &[HyperDual64], from: f64| {
            let all = x.iter().zip(weights(from));
            all.map(|(x, w)| *x * *x * w).sum::<HyperDual64>()
        };
        let by_hand = WeightedSquares::new(n, weights(0.5), weights(0.0), weights(0.2)).expect("good");
        let (value, left) = derivatives(&mut CostThroughDynamics::of(&model, by_hand), &z);
        let by_duals = |at: &StageInput<'_, HyperDual64>| squares(at.u, 0.5) + squares(at.v, 0.0) + squares(at.a, 0.2);
        let (again, right) = derivatives(&mut CostThroughDynamics::new(&model, by_duals), &z);
        assert!((value - again).abs() < 1e-12 * value);
        assert_close!(&left.gradient, &right.gradient, 1e-13);
        assert_close!(&left.hessian, &right.hessian, 1e-13);
        assert_close!(&left.metric, &right.metric, 1e-13);

        let torques = WeightedSquares::new(n, vec![1.0; n], vec![0.0; n], vec![0.0; n]).expect("good");
        let (value, left) = derivatives(&mut CostThroughDynamics::of(&model, torques), &z);
        let (again, right) = derivatives(&mut ControlEffort::<f64, f64>::new(&model), &z);
        assert!((value - again).abs() < 1e-12 * value);
        assert_close!(&left.gradient, &right.gradient, 1e-13);
        assert_close!(&left.hessian, &right.hessian, 1e-13);
        assert_close!(&left.metric, &right.metric, 1e-13);
    }
}
