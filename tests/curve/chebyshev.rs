//! Nodes, derivatives, interpolation and quadrature.

use crate::common::{config, numbers};
use aghf::curve::{Chebyshev, Curve};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

pub const HORIZON: f64 = 3.0;

pub fn chebyshev(p: usize) -> Chebyshev {
    Chebyshev::new(p, HORIZON).expect("valid")
}

/// A smooth function that is no polynomial, with its first two derivatives.
fn smooth(t: f64) -> [f64; 3] {
    let (value, inner) = ((2.0 * t).sin().exp(), 2.0 * (2.0 * t).cos());
    [value, value * inner, value * (inner * inner - 4.0 * (2.0 * t).sin())]
}

/// Largest errors of `D`, `D^2`, interpolation and quadrature on `smooth`, relative to the sizes there.
fn errors(p: usize) -> [f64; 4] {
    let c = chebyshev(p);
    let at = |order: usize| DVector::from_iterator(p + 1, c.times().iter().map(|t| smooth(*t)[order]));
    let mut weights = DVector::zeros(p + 1);
    let interpolation = (0..500).fold(0.0_f64, |worst, i| {
        let t = HORIZON * f64::from(i) / 499.0;
        c.interpolation(t, &mut weights);
        worst.max((weights.dot(&at(0)) - smooth(t)[0]).abs())
    });
    // The integral by far more nodes than any degree here needs.
    let fine = chebyshev(Chebyshev::MAX_DEGREE);
    let integral: f64 = fine.weights().iter().zip(fine.times()).map(|(w, t)| w * smooth(*t)[0]).sum();
    [
        (c.d() * at(0) - at(1)).amax() / at(1).amax(),
        (c.d2() * at(0) - at(2)).amax() / at(2).amax(),
        interpolation,
        (c.weights().dot(&at(0)) - integral).abs(),
    ]
}

#[test]
fn errors_fall_exponentially_with_the_degree() {
    let ladder: Vec<_> = [10, 20, 30, 40, 60].into_iter().map(errors).collect();
    println!("{ladder:?}");
    for kind in 0..4 {
        for step in ladder.windows(2).take(3) {
            assert!(step[1][kind] < 0.1 * step[0][kind] + 1e-11, "kind {kind}: {ladder:?}");
        }
        // Rounding grows with p^4 in D^2 and p^2 in D.
        let rounding = [1e-11, 1e-9, 1e-13, 1e-13][kind];
        assert!(ladder[4][kind] < rounding, "kind {kind}: {ladder:?}");
    }
}

#[test]
fn nodes_are_the_papers_in_reverse() {
    let p = 7;
    let c = Chebyshev::new(p, 2.0).expect("valid");
    for (i, t) in c.times().iter().enumerate() {
        let paper = (std::f64::consts::PI * (p - i) as f64 / p as f64).cos();
        assert!((t - 1.0 - paper).abs() < 1e-15);
    }
    assert_eq!((c.times()[0], c.times()[p]), (0.0, 2.0));
}

#[test]
fn the_second_matrix_is_the_square_of_the_first() {
    for p in [2, 3, 8, 15] {
        let c = chebyshev(p);
        assert_close!(c.d2(), &(c.d() * c.d()), 1e-12);
    }
}

#[test]
fn quadrature_is_exact_for_polynomials_of_its_degree() {
    for p in 2..12 {
        let c = chebyshev(p);
        for degree in 0..=i32::try_from(p).expect("small") {
            let sum: f64 = c.weights().iter().zip(c.times()).map(|(w, t)| w * t.powi(degree)).sum();
            let exact = HORIZON.powi(degree + 1) / f64::from(degree + 1);
            assert!((sum - exact).abs() < 1e-12 * exact, "p {p}, degree {degree}: {sum} {exact}");
        }
    }
}

#[test]
fn bad_settings_are_errors() {
    for (p, horizon, element) in [(1, 1.0, "degree:"), (5, 0.0, "horizon"), (5, f64::NAN, "horizon")] {
        let error = Chebyshev::new(p, horizon).expect_err("bad");
        assert!(error.to_string().contains(element), "{error}");
    }
    let error = Curve::new(chebyshev(4), DMatrix::zeros(2, 4)).expect_err("a column is missing");
    assert!(error.to_string().contains("expected 5 entries, found 4"), "{error}");
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn polynomials_are_reproduced(p in 2..14_usize, values in numbers(14), t in 0.0..HORIZON) {
        let c = chebyshev(p);
        let polynomial = |t: f64| values[..=p.min(13)].iter().rev().fold(0.0, |sum, c| sum * (t / HORIZON) + c);
        let mut x = DMatrix::zeros(2, c.degree() + 1);
        for (i, t) in c.times().iter().enumerate() {
            x.column_mut(i).fill(polynomial(*t));
        }
        let curve = Curve::new(c, x).expect("valid");
        let (x, xdot) = curve.at(t);
        prop_assert!((x[0] - polynomial(t)).abs() < 1e-11);
        let step = 1e-5;
        let difference = (polynomial(t + step) - polynomial(t - step)) / (2.0 * step);
        prop_assert!((xdot[1] - difference).abs() < 1e-6, "{} {difference}", xdot[1]);
    }
}
