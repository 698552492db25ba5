//! Several numbers side by side. The sines and cosines of four angles by `wide` are code that `f64` alone goes through,
//! which the proofs therefore do not see.

use crate::common::{any_model, config, numbers};
use aghf::dynamics::{Data, RneaWeightedHessian, crba, rnea, rnea_weighted_hessian};
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, Lanes, Scalar};
use nalgebra::DMatrix;
use proptest::prelude::*;

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn lanes_divide_each_by_its_own(a in prop::array::uniform4(-3.0..3.0_f64),
        b in prop::array::uniform4(0.1..3.0_f64)) {
        let alone: [f64; 4] = std::array::from_fn(|i| a[i] / b[i]);
        prop_assert_eq!((Lanes(a) / Lanes(b)).0, alone);
        let mut assigned = Lanes(a);
        assigned /= Lanes(b);
        prop_assert_eq!(assigned.0, alone);
    }
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
    let packed: Vec<Lanes<f64, W>> = (0..3 * n).map(|i| Lanes(std::array::from_fn(|lane| states[lane][i]))).collect();
    let out = dynamics(model, [&packed[..n], &packed[n..2 * n], &packed[2 * n..]]);
    (0..W).map(|lane| out.iter().map(|x| x.0[lane]).collect()).collect()
}

proptest! {
    #![proptest_config(config(48))]

    /// To one unit in the last place of an angle within a turn or so. What is left of a large angle suffers from
    /// cancellation, and is as good as one is. An angle beyond what the fast path is for has the bits that it has
    /// alone, and changes none of the others'.
    #[test]
    fn the_fast_paths_agree_with_the_generic_code_in_sines(angles in prop::collection::vec(angle(), 1..10),
        far in beyond(), place in 0..9_usize) {
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
