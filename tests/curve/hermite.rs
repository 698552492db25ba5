//! Hermite polynomials. The file is compiled here, because its functions are not public.

#[allow(unreachable_pub)]
#[path = "../../src/curve/hermite.rs"]
mod source;

use source::{hermite, legendre_slope};

/// Each polynomial has one unit derivative at one end, and the next derivatives are the slopes of those before.
#[test]
fn one_unit_derivative_each() {
    for k in [2, 3] {
        for index in 0..2 * k {
            let ends = [-1.0, 1.0].map(|s| hermite(k, index, s));
            for (end, (derivative, values)) in ends.into_iter().enumerate() {
                for (d, value) in values.into_iter().enumerate().take(k) {
                    let own = end == index / k && d == derivative;
                    assert!((value - f64::from(u8::from(own))).abs() < 1e-15);
                }
            }
            let slopes = |s: f64| {
                let [(_, before), (_, after)] = [-1e-4, 1e-4].map(|h| hermite(k, index, s + h));
                [0, 1, 2].map(|d| (after[d] - before[d]) / 2e-4)
            };
            let (_, values) = hermite(k, index, 0.3);
            for (slope, next) in slopes(0.3).into_iter().zip(&values[1..]) {
                assert!((slope - next).abs() < 1e-6, "{k} {index}: {slope} {next}");
            }
        }
    }
}

#[test]
fn slopes_of_legendre_polynomials() {
    let s = 0.4_f64;
    let p = [1.0, s, 1.5 * s * s - 0.5];
    let exact = [0.0, 1.0, 3.0 * s, 1.5 * (5.0 * s * s - 1.0)];
    for (j, exact) in exact.into_iter().enumerate() {
        assert!((legendre_slope(&p, j) - exact).abs() < 1e-15);
    }
}
