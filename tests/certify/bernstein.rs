//! Bounds on polynomials contain their values, and are reached.

use crate::common::config;
use aghf::certify::{Bernstein, Polynomial, Range};
use proptest::prelude::*;

fn value(c: &[f64], s: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * s + c)
}

fn polynomial(coefficients: Vec<f64>, radius: f64) -> Polynomial {
    Polynomial { coefficients, radius }
}

proptest! {
    #![proptest_config(config(256))]

    #[test]
    fn ranges_contain_the_values(c in prop::collection::vec(-2.0..2.0_f64, 1..18), radius in 0.0..0.1_f64) {
        let found = Bernstein::new(c.len() - 1).range(&polynomial(c.clone(), radius), 1e-9);
        let Range { lower, upper, least_at_most, most_at_least, places } = found;
        let samples: Vec<f64> = (0..=1000).map(|k| value(&c, -1.0 + 0.002 * f64::from(k))).collect();
        let (least, most) = samples.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
        prop_assert!(lower <= least - radius && most + radius <= upper);
        // The values that are said to be taken are, up to the bound on the error, where it is said.
        prop_assert!((value(&c, places[0]) + radius - least_at_most).abs() < 1e-9);
        prop_assert!((value(&c, places[1]) - radius - most_at_least).abs() < 1e-9);
        // Within the accuracy of them: between samples there may be more.
        prop_assert!(upper <= most + radius + 1e-3 && lower >= least - radius - 1e-3);
    }
}

/// Chebyshev polynomials take both bounds several times.
#[test]
fn bounds_are_as_close_as_asked() {
    // T_6, and T_6 with a top that only halves can tell from its surroundings.
    let c = vec![-1.0, 0.0, 18.0, 0.0, -48.0, 0.0, 32.0];
    let found = Bernstein::new(9).range(&polynomial(c, 0.0), 1e-10);
    assert!(found.upper >= 1.0 && found.upper < 1.0 + 1e-8, "{found:?}");
    assert!(found.lower <= -1.0 && found.lower > -1.0 - 1e-8, "{found:?}");
}

#[test]
fn what_is_not_known_has_no_bounds() {
    for (c, radius) in [(vec![0.0, f64::NAN], 0.0), (vec![1.0], f64::NAN), (vec![1.0], f64::INFINITY)] {
        let found = Bernstein::new(3).range(&polynomial(c, radius), 1e-3);
        let is_known = found.upper < f64::MAX || found.lower > f64::MIN;
        assert!(!is_known, "{found:?}");
    }
}
