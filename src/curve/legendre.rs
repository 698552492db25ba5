//! Legendre polynomials and their quadratures.

use std::f64::consts::PI;

/// Computes the Legendre polynomials $P_0, \dots, P_n$ at `x` into `out`, `n + 1` entries, by their three-term
/// recurrence.
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

/// Computes the `m` nodes, ascending, and the weights of Gauss-Legendre quadrature on `[-1, 1]`: exact for polynomials
/// of degree `2 m - 1`. Newton's method from the asymptotic zeros (Press et al., *Numerical Recipes*, 4.6). Cost
/// O(m^2).
#[must_use]
pub fn gauss_legendre(m: usize) -> (Vec<f64>, Vec<f64>) {
    let half = m.div_ceil(2);
    let zero = |i| (PI * (i as f64 + 0.75) / (m as f64 + 0.5)).cos();
    let mut x: Vec<f64> = (0..half).map(zero).collect();
    let mut slopes = vec![1.0; half];
    // Quadratic convergence: four steps from two correct digits to all of them, and one in reserve.
    for _ in 0..5 {
        // P_{k - 1} and P_k, at all nodes at once, because the division for each k dominates the time.
        let (mut below, mut here) = (vec![1.0; half], x.clone());
        for k in 2..=m {
            let share = 1.0 - 1.0 / k as f64;
            for i in 0..half {
                let next = (1.0 + share) * x[i] * here[i] - share * below[i];
                (below[i], here[i]) = (here[i], next);
            }
        }
        for i in 0..half {
            slopes[i] = m as f64 * (x[i] * here[i] - below[i]) / (x[i] * x[i] - 1.0);
            x[i] -= here[i] / slopes[i];
        }
    }
    let (mut nodes, mut weights) = (vec![0.0; m], vec![0.0; m]);
    for (i, (x, slope)) in x.into_iter().zip(slopes).enumerate() {
        let weight = 2.0 / ((1.0 - x * x) * slope * slope);
        (nodes[i], nodes[m - 1 - i]) = (-x, x);
        (weights[i], weights[m - 1 - i]) = (weight, weight);
    }
    if m % 2 == 1 {
        nodes[m / 2] = 0.0;
    }
    (nodes, weights)
}

/// Computes the `m` nodes, at least two, ascending with both ends, and the weights of Gauss-Lobatto quadrature on
/// `[-1, 1]`: exact for polynomials of degree `2 m - 3`. Newton's method from the extrema of the Chebyshev polynomial.
/// Cost O(m^2).
#[must_use]
pub fn gauss_lobatto(m: usize) -> (Vec<f64>, Vec<f64>) {
    let n = m - 1;
    let mut values = vec![0.0; m];
    let mut rule = |i: usize| {
        let mut x = -(PI * i as f64 / n as f64).cos();
        // Quadratic convergence, but for the ends, where the step vanishes.
        for _ in 0..8 {
            legendre(x, &mut values);
            x -= (x * values[n] - values[n - 1]) / (m as f64 * values[n]);
        }
        legendre(x, &mut values);
        (x, 2.0 / ((n * m) as f64 * values[n] * values[n]))
    };
    (0..m).map(&mut rule).unzip()
}
