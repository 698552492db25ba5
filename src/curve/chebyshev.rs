//! Chebyshev nodes, differentiation matrices, interpolation and quadrature.

use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// The Chebyshev-Gauss-Lobatto nodes of degree `p` on the horizon `[0, T]`, with their matrices.
///
/// Node `i` is at $t_i = \tfrac T2 (1 - \cos(\pi i / p))$, `i = 0..p`: numbered by increasing time, so that node 0 is
/// the start. The paper's $t_i = \cos(\pi i / p)$ on `[-1, 1]` decreases; its node `i` is node `p - i` here.
#[derive(Clone, Debug)]
pub struct Chebyshev {
    horizon: f64,
    times: Vec<f64>,
    d: DMatrix<f64>,
    d2: DMatrix<f64>,
    weights: DVector<f64>,
}

impl Chebyshev {
    /// The largest degree. The matrices of the flow exceed the memory far below it.
    pub const MAX_DEGREE: usize = 200;

    /// Checks a degree; the error gives the reason.
    pub fn check_degree(p: usize) -> std::result::Result<(), String> {
        if (2..=Self::MAX_DEGREE).contains(&p) {
            return Ok(());
        }
        let largest = Self::MAX_DEGREE;
        Err(format!("it is {p} and must be at least 2 and at most {largest}"))
    }

    /// Computes the nodes of degree `p` on `[0, horizon]`, in s, and their matrices. Cost O(p^2).
    ///
    /// # Errors
    /// `p` is below 2, so that there is no interior node, or above [`MAX_DEGREE`](Self::MAX_DEGREE), or the
    /// horizon is not positive and finite.
    pub fn new(p: usize, horizon: f64) -> Result<Self> {
        Self::check_degree(p).map_err(|condition| Error::input("settings", "degree", condition))?;
        if !(horizon.is_finite() && horizon > 0.0) {
            let condition = format!("it is {horizon} and must be a positive time");
            return Err(Error::input("settings", "horizon", condition));
        }
        let d = differentiation(p);
        let d2 = second_differentiation(p, &d);
        let scale = 2.0 / horizon;
        Ok(Self {
            horizon,
            // 1 - cos is 2 sin^2 of the half angle, which loses no digits near the start.
            times: (0..=p).map(|i| horizon * (PI * i as f64 / (2 * p) as f64).sin().powi(2)).collect(),
            d: d * scale,
            d2: d2 * scale.powi(2),
            weights: clenshaw_curtis(p) / scale,
        })
    }

    /// The degree `p`: there are `p + 1` nodes.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.times.len() - 1
    }

    /// The horizon `T`, in s.
    #[must_use]
    pub fn horizon(&self) -> f64 {
        self.horizon
    }

    /// The nodes, in s, from 0 to `T`.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The matrix `D`, `p + 1` by `p + 1`, which maps values at the nodes to derivatives in time at the nodes.
    #[must_use]
    pub fn d(&self) -> &DMatrix<f64> {
        &self.d
    }

    /// The matrix `D^2`, which maps values to second derivatives.
    #[must_use]
    pub fn d2(&self) -> &DMatrix<f64> {
        &self.d2
    }

    /// The weights of Clenshaw-Curtis quadrature over `[0, T]`; exact for polynomials of degree `p`.
    #[must_use]
    pub fn weights(&self) -> &DVector<f64> {
        &self.weights
    }

    /// The coefficients $c_k$ of the polynomials $\sum_k c_k T_k(2 t / T - 1)$ with these values at the nodes: one row
    /// per polynomial, one column per node and per degree. Cost O(p^2) per row.
    pub(crate) fn coefficients(&self, values: &DMatrix<f64>) -> DMatrix<f64> {
        let p = self.degree();
        // Discrete orthogonality of the polynomials at the nodes s_i = -cos(pi i / p), with weight one half at both
        // ends.
        let half = |i: usize| if i == 0 || i == p { 0.5 } else { 1.0 };
        let transform = DMatrix::from_fn(p + 1, p + 1, |i, k| {
            let angle = PI * ((i * k) % (2 * p)) as f64 / p as f64;
            alternating(k) * angle.cos() * half(i) * half(k) * 2.0 / p as f64
        });
        values * transform
    }

    /// The values at the nodes of the polynomials with these coefficients: the inverse of
    /// [`Curve::coefficients`](super::Curve::coefficients) on a segment. One row per polynomial, one column per degree
    /// and per node. Cost O(p^2) per row.
    #[must_use]
    pub fn values(&self, coefficients: &DMatrix<f64>) -> DMatrix<f64> {
        let p = self.degree();
        let polynomials =
            DMatrix::from_fn(p + 1, p + 1, |k, i| alternating(k) * (PI * ((i * k) % (2 * p)) as f64 / p as f64).cos());
        coefficients * polynomials
    }

    /// Computes the weights of the values at the nodes in the interpolating polynomial at time `t` into `out`.
    ///
    /// This is the second barycentric formula (Berrut and Trefethen, "Barycentric Lagrange interpolation", 2004), which
    /// is stable for any `t` in the horizon. Cost O(p).
    pub fn interpolation(&self, t: f64, out: &mut DVector<f64>) {
        if let Some(node) = self.times.iter().position(|node| *node == t) {
            out.fill(0.0);
            out[node] = 1.0;
            return;
        }
        let p = self.degree();
        for (i, node) in self.times.iter().enumerate() {
            let end = if i == 0 || i == p { 0.5 } else { 1.0 };
            out[i] = alternating(i) * end / (t - node);
        }
        let sum = out.sum();
        *out /= sum;
    }
}

/// $(-1)^i$.
fn alternating(i: usize) -> f64 {
    if i.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// `x_i - x_j` for the nodes on `[-1, 1]` as a product, which avoids cancellation.
fn difference(p: usize, i: usize, j: usize) -> f64 {
    let angle = |k: f64| (PI * k / (2 * p) as f64).sin();
    2.0 * angle((i + j) as f64) * angle(i as f64 - j as f64)
}

/// `D` on `[-1, 1]`; the diagonal is such that the derivative of a constant is zero (Baltensperger and Trummer, 2003).
fn differentiation(p: usize) -> DMatrix<f64> {
    let end = |i| if i == 0 || i == p { 2.0 } else { 1.0 };
    let mut d = DMatrix::from_fn(p + 1, p + 1, |i, j| {
        if i == j { 0.0 } else { end(i) / end(j) * alternating(i + j) / difference(p, i, j) }
    });
    fill_diagonal_by_negative_sum(&mut d);
    d
}

/// `D^2` on `[-1, 1]` from `D`, without the loss of accuracy of a matrix product (Welfert, 1997).
fn second_differentiation(p: usize, d: &DMatrix<f64>) -> DMatrix<f64> {
    let mut d2 = DMatrix::from_fn(p + 1, p + 1, |i, j| {
        if i == j { 0.0 } else { 2.0 * d[(i, j)] * (d[(i, i)] - 1.0 / difference(p, i, j)) }
    });
    fill_diagonal_by_negative_sum(&mut d2);
    d2
}

/// Sets the empty diagonal of a matrix so that its rows sum to zero.
fn fill_diagonal_by_negative_sum(matrix: &mut DMatrix<f64>) {
    for i in 0..matrix.nrows() {
        matrix[(i, i)] = -matrix.row(i).sum();
    }
}

/// The weights of Clenshaw-Curtis quadrature on `[-1, 1]` (Trefethen, *Spectral Methods in MATLAB*, 2000, chapter 12).
fn clenshaw_curtis(p: usize) -> DVector<f64> {
    DVector::from_fn(p + 1, |i, _| {
        let theta = PI * i as f64 / p as f64;
        let series: f64 = (1..=p / 2)
            .map(|k| {
                let half = if 2 * k == p { 1.0 } else { 2.0 };
                half * (2.0 * k as f64 * theta).cos() / (4.0 * (k * k) as f64 - 1.0)
            })
            .sum();
        let end = if i == 0 || i == p { 1.0 } else { 2.0 };
        end * (1.0 - series) / p as f64
    })
}
