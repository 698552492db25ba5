//! Polynomials and power laws fitted to measured points.

use nalgebra::{DMatrix, DVector};

/// Fits a polynomial of `degree` to the points `(x, y)` by least squares; the constant term comes first. `None` if
/// there are too few different `x`.
#[must_use]
pub fn polynomial(points: &[(f64, f64)], degree: usize) -> Option<Vec<f64>> {
    // In units of the largest x the powers have comparable sizes.
    let unit = points.iter().fold(0.0_f64, |m, (x, _)| m.max(x.abs()));
    if unit == 0.0 || points.len() <= degree {
        return None;
    }
    let power = |i: usize, j: usize| (points[i].0 / unit).powi(j as i32);
    let powers = DMatrix::from_fn(points.len(), degree + 1, power);
    let values = DVector::from_iterator(points.len(), points.iter().map(|(_, y)| *y));
    let svd = powers.svd(true, true);
    let negligible = f64::EPSILON * svd.singular_values.max() * points.len() as f64;
    if svd.rank(negligible) <= degree {
        return None;
    }
    let scaled = svd.solve(&values, negligible).ok()?;
    let coefficients = scaled.iter().enumerate();
    Some(coefficients.map(|(j, c)| c / unit.powi(j as i32)).collect())
}

/// Evaluates the polynomial with these coefficients at `x`.
#[must_use]
pub fn value(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Fits the power law $c\\, x^e$ to the points by least squares in the logarithms; returns `c` and `e`. `None` if a
/// point is not positive or all have the same `x`.
#[must_use]
pub fn power_law(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    if points.iter().any(|(x, y)| !(*x > 0.0 && *y > 0.0)) {
        return None;
    }
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let line = polynomial(&logs, 1)?;
    Some((line[0].exp(), line[1]))
}
