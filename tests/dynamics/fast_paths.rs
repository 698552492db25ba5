//! The code that only `f64` uses, which the proofs therefore do not cover: products of matrices by `faer`, and sines
//! and cosines of four angles by `wide`. Both paths must agree with the generic code.

use crate::common::{any_model, config, numbers};
use aghf::dynamics::{Data, RneaWeightedHessian, crba, rnea, rnea_weighted_hessian};
use aghf::linalg::multiply;
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, Lanes, Scalar};
use nalgebra::DMatrix;
use proptest::prelude::*;

/// Two matrices of compatible shapes up to 400, with some zero entries.
fn factors() -> impl Strategy<Value = [DMatrix<f64>; 2]> {
    (1..400_usize, 1..400_usize, 1..400_usize, any::<u64>()).prop_map(|(m, k, n, seed)| {
        let entry = |i: usize, j: usize, f: f64| {
            let angle = f * (i + 1) as f64 + (seed % 1000) as f64 * (j + 1) as f64;
            if (i + j).is_multiple_of(11) {
                0.0
            } else {
                angle.sin() * 10.0_f64.powi((i * j % 7) as i32 - 3)
            }
        };
        let a = DMatrix::from_fn(m, k, |i, j| entry(i, j, 0.7));
        let b = DMatrix::from_fn(k, n, |i, j| entry(i, j, 1.3));
        [a, b]
    })
}

/// Angles of all sizes in the range of the fast path.
fn angle() -> impl Strategy<Value = f64> {
    let sized = (-300.0..9.0_f64, -1.0..1.0_f64).prop_map(|(e, sign)| sign * 10.0_f64.powf(e));
    prop_oneof![-7.0..7.0_f64, -1e9..1e9_f64, sized]
}

/// Angles beyond that range, half of them only just, and non-finite numbers.
fn beyond() -> impl Strategy<Value = f64> {
    let exponent = prop_oneof![9.0..12.0_f64, 9.0..308.0_f64];
    let sign = prop::sample::select(vec![-1.0, 1.0]);
    let sized = (exponent, sign).prop_map(|(e, sign): (f64, f64)| sign * 10.0_f64.powf(e));
    let none = vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    prop_oneof![4 => sized, 1 => prop::sample::select(none)]
}

/// Torques, the mass matrix and the weighted second derivatives of inverse dynamics, concatenated; the acceleration
/// serves as the weight.
fn dynamics<S: AlgebraOver<f64>>(model: &Model, [q, v, a]: [&[S]; 3]) -> Vec<S> {
    let n = model.dof();
    let data = &mut Data::new(model);
    let (mut tau, mut h) = (vec![S::zero(); n], DMatrix::zeros(n, n));
    let mut second = RneaWeightedHessian::new(n);
    rnea(model, data, q, v, a, &mut tau).expect("lengths agree");
    crba(model, data, q, &mut h).expect("lengths agree");
    rnea_weighted_hessian(model, data, q, v, a, a, &mut second).expect("lengths agree");
    let RneaWeightedHessian { qq, qv, vv, qa } = &second;
    let matrices = [&h, qq, qv, vv, qa].into_iter().flatten();
    tau.iter().chain(matrices).copied().collect()
}

/// A model and `q, v, a` in each of four lanes.
fn model_and_lanes() -> impl Strategy<Value = (Model, Vec<Vec<f64>>)> {
    any_model().prop_flat_map(|model| {
        let n = model.dof();
        (Just(model), prop::collection::vec(numbers(3 * n), 4))
    })
}

/// The dynamics evaluated in SIMD lanes, lane by lane.
fn in_lanes<const W: usize>(model: &Model, states: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = model.dof();
    let packed: Vec<Lanes<f64, W>> = (0..3 * n)
        .map(|i| Lanes(std::array::from_fn(|lane| states[lane][i])))
        .collect();
    let out = dynamics(model, [&packed[..n], &packed[n..2 * n], &packed[2 * n..]]);
    (0..W)
        .map(|lane| out.iter().map(|x| x.0[lane]).collect())
        .collect()
}

proptest! {
    #![proptest_config(config(48))]

    /// The error of a sum of `k` products in any order is at most `k` half units of rounding of the sum of their
    /// magnitudes, so two such sums differ by at most twice that. Previous contents of the result have no effect.
    #[test]
    fn the_fast_paths_agree_with_the_generic_code_in_products([a, b] in factors()) {
        let shape = (a.nrows(), b.ncols());
        let mut fast = DMatrix::from_element(shape.0, shape.1, f64::NAN);
        multiply(&a, &b, &mut fast);
        let generic = |m: &DMatrix<f64>| m.map(|x| Lanes([x]));
        let mut slow = DMatrix::from_element(shape.0, shape.1, Lanes([1.0]));
        multiply(&generic(&a), &generic(&b), &mut slow);
        let mut size = DMatrix::zeros(shape.0, shape.1);
        multiply(&generic(&a.abs()), &generic(&b.abs()), &mut size);
        let units = f64::EPSILON * (a.ncols() + 1) as f64;
        for ((fast, slow), size) in fast.iter().zip(&slow).zip(&size) {
            let error = (fast - slow.0[0]).abs();
            prop_assert!(error <= units * size.0[0], "{shape:?} {} {error:e}", a.ncols());
        }
    }

    /// Within one unit in the last place up to about one turn; cancellation in the reduction of larger angles allows
    /// the error of one unit at magnitude one. An angle beyond the range of the fast path has the same bits as alone,
    /// and does not change the others.
    #[test]
    fn the_fast_paths_agree_with_the_generic_code_in_sines(angles in prop::collection::vec(angle(), 1..10), far in beyond(), place in 0..9_usize) {
        let bits = |(s, c): &(f64, f64)| (s.to_bits(), c.to_bits());
        let mut fast = vec![(0.0, 0.0); angles.len()];
        f64::sin_cos_of_several(&angles, &mut fast);
        for (angle, fast) in angles.iter().zip(&fast) {
            let slow = angle.sin_cos();
            for (fast, slow) in [(fast.0, slow.0), (fast.1, slow.1)] {
                let bound = if angle.abs() < 7.0 { slow.abs() } else { 2.0 };
                prop_assert!((fast - slow).abs() <= f64::EPSILON * bound, "{angle:e} {fast:e} {slow:e}");
            }
        }
        let mut with_far = angles.clone();
        let place = place % angles.len();
        with_far[place] = far;
        fast[place] = far.sin_cos();
        let mut found = vec![(0.0, 0.0); angles.len()];
        f64::sin_cos_of_several(&with_far, &mut found);
        prop_assert_eq!(found.iter().map(bits).collect::<Vec<_>>(), fast.iter().map(bits).collect::<Vec<_>>());

        let first = |k: usize| with_far[k.min(angles.len() - 1)];
        let (sin, cos) = Scalar::sin_cos(Lanes::<f64, 4>(std::array::from_fn(first)));
        for k in 0..4.min(angles.len()) {
            prop_assert_eq!(bits(&(sin.0[k], cos.0[k])), bits(&fast[k]));
        }
    }

    /// Each lane has the same bits as a separate evaluation.
    #[test]
    fn the_fast_paths_agree_with_the_generic_code_in_the_dynamics((model, states) in model_and_lanes()) {
        let n = model.dof();
        let alone: Vec<_> = (states.iter())
            .map(|x| dynamics(&model, [&x[..n], &x[n..2 * n], &x[2 * n..]]))
            .collect();
        prop_assert_eq!(&in_lanes::<2>(&model, &states), &alone[..2]);
        prop_assert_eq!(&in_lanes::<4>(&model, &states), &alone);
    }
}
