//! Legendre polynomials and the quadrature that goes with them.

use std::f64::consts::PI;

/// The Legendre polynomials $P_0, \dots, P_n$ at `x`, where `out` has `n + 1` entries, by their three-term recurrence.
pub(crate) fn legendre(x: f64, out: &mut [f64]) {
    for k in 0..out.len() {
        out[k] = match k {
            0 => 1.0,
            1 => x,
            _ => {
                let k_ = k as f64;
                ((2.0 * k_ - 1.0) * x * out[k - 1] - (k_ - 1.0) * out[k - 2]) / k_
            }
        };
    }
}

/// The `m` nodes, ascending, and weights of Gauss-Legendre quadrature on `[-1, 1]`: exact for polynomials of degree
/// `2 m - 1`. Newton's method from the asymptotic zeros (Press et al., *Numerical Recipes*, 4.6). Cost O(m^2).
#[must_use]
pub fn gauss_legendre(m: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut nodes, mut weights) = (vec![0.0; m], vec![0.0; m]);
    let mut values = vec![0.0; m + 1];
    for i in 0..m.div_ceil(2) {
        let mut x = (PI * (i as f64 + 0.75) / (m as f64 + 0.5)).cos();
        let mut slope = 1.0;
        // Quadratic convergence: from two digits to all of them in four steps; one more does no harm.
        for _ in 0..5 {
            legendre(x, &mut values);
            slope = m as f64 * (x * values[m] - values[m - 1]) / (x * x - 1.0);
            x -= values[m] / slope;
        }
        let weight = 2.0 / ((1.0 - x * x) * slope * slope);
        (nodes[i], nodes[m - 1 - i]) = (-x, x);
        (weights[i], weights[m - 1 - i]) = (weight, weight);
    }
    if m % 2 == 1 {
        nodes[m / 2] = 0.0;
    }
    (nodes, weights)
}
