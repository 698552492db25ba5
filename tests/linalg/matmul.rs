//! Products of matrices by `faer`, which `f64` alone goes through and the proofs therefore do not see.

use crate::common::config;
use aghf::linalg::multiply;
use aghf::scalar::Lanes;
use nalgebra::DMatrix;
use proptest::prelude::*;

/// Two matrices whose product exists, of any shapes up to 400, with zeros among the entries.
fn factors() -> impl Strategy<Value = [DMatrix<f64>; 2]> {
    (1..400_usize, 1..400_usize, 1..400_usize, any::<u64>()).prop_map(|(m, k, n, seed)| {
        let entry = |i: usize, j: usize, f: f64| {
            let angle = f * (i + 1) as f64 + (seed % 1000) as f64 * (j + 1) as f64;
            if (i + j).is_multiple_of(11) { 0.0 } else { angle.sin() * 10.0_f64.powi((i * j % 7) as i32 - 3) }
        };
        let a = DMatrix::from_fn(m, k, |i, j| entry(i, j, 0.7));
        let b = DMatrix::from_fn(k, n, |i, j| entry(i, j, 1.3));
        [a, b]
    })
}

proptest! {
    #![proptest_config(config(48))]

    /// A sum of `k` products is off by at most `k` half units of rounding of the sum of their sizes, in whatever order,
    /// so two such sums differ by at most twice that. What was in the result before has no part in it.
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
}
