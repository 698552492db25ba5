//! Continuous piecewise polynomials in the state at quadrature points.

use crate::curve::{Chebyshev, Curve, gauss_legendre, legendre};
use crate::error::Result;
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::OnceLock;

/// The functions of a curve $x(t)$, continuous and a polynomial of one degree on each of several equal segments, at
/// Gauss-Legendre points, the same number on each segment.
///
/// Segment `e` has the `degree + 1` functions from `e degree` on: a hat function at its beginning, `degree - 1`
/// bubbles, whose slopes are Legendre polynomials of norm one, and a hat function at its end, which is the first
/// function of the next. The coefficient of a hat function is the state there.
#[derive(Clone, Debug)]
pub struct StateGrid<S: Scalar> {
    pub(super) segments: usize,
    /// The number of points at the end of each segment at which only equalities are enforced.
    collocated: usize,
    /// Times of the points, s, segment by segment.
    pub(super) times: Vec<S>,
    /// Weights of the points of a segment.
    pub(super) weights: Vec<S>,
    /// Values at the points of a segment, then slopes in time: one row per function, `2 M` columns.
    pub(super) table: DMatrix<S>,
    /// Pairs of functions of a segment, the first not before the second.
    pub(super) pairs: Vec<(usize, usize)>,
    /// Weighted products of a value or slope of the first and one of the second function of each pair: `4 M` by pairs,
    /// value and value, value and slope, slope and value, slope and slope.
    products: OnceLock<DMatrix<S>>,
}

impl StateGrid<f64> {
    /// Tabulates `segments` polynomials of degree `degree` on `[0, horizon]`, with `points` points each.
    #[must_use]
    pub fn new(segments: usize, degree: usize, points: usize, horizon: f64) -> Self {
        Self::collocated(segments, degree, points, 0, horizon)
    }

    /// Adds `collocated` Gauss-Legendre points per segment, which follow the others and are not part of the quadrature:
    /// equalities can be enforced there. With as many Gauss points as a segment has functions of its own, `degree - 1`,
    /// the residual between the points is orthogonal to polynomials (to all of lower degree if it is one of degree
    /// `degree - 1`; `proofs/weak_form.md`), and so has almost no effect on the motion.
    #[must_use]
    pub fn collocated(
        segments: usize,
        degree: usize,
        points: usize,
        collocated: usize,
        horizon: f64,
    ) -> Self {
        let (mut nodes, mut weights) = gauss_legendre(points);
        if collocated > 0 {
            let (more, their_weights) = gauss_legendre(collocated);
            nodes.extend(more);
            weights.extend(their_weights);
        }
        let points = nodes.len();
        let half = 0.5 * horizon / segments as f64;
        let mut table = DMatrix::zeros(degree + 1, 2 * points);
        for (g, s) in nodes.iter().enumerate() {
            let [values, slopes] = functions(degree, *s);
            table.set_column(g, &values);
            table.set_column(points + g, &(slopes / half));
        }
        let segment = 0..segments;
        let time = |e: usize, s: f64| half * ((2 * e + 1) as f64 + s);
        let times = segment.flat_map(|e| nodes.iter().map(move |s| time(e, *s)));
        let weights = weights.iter().map(|w| w * half).collect();
        Self {
            collocated,
            ..Self::from_table(segments, times.collect(), weights, table)
        }
    }

    /// The end of the last segment, s.
    #[must_use]
    pub fn horizon(&self) -> f64 {
        let quadrature = &self.weights[..self.quadrature_points()];
        quadrature.iter().sum::<f64>() * self.segments as f64
    }

    /// The coefficients of a curve, `2 N` by [`count`](Self::count): exact if it has this degree and its breakpoints
    /// are among those of the grid; otherwise equal to it at the breakpoints, and between them the best approximation
    /// of its rate.
    #[must_use]
    pub fn fit(&self, curve: &Curve) -> DMatrix<f64> {
        let (degree, horizon) = (self.degree(), curve.horizon());
        let half = 0.5 * horizon / self.segments as f64;
        let mut coefficients = DMatrix::zeros(curve.x().nrows(), self.count());
        let (nodes, weights) = gauss_legendre(degree.max(curve.chebyshev().degree()) + 1);
        for e in 0..=self.segments {
            let (x, _) = curve.at(horizon * e as f64 / self.segments as f64);
            coefficients.set_column(e * degree, &x);
        }
        for (s, weight) in nodes.iter().zip(weights) {
            let [_, slopes] = functions(degree, *s);
            for e in 0..self.segments {
                let (_, xdot) = curve.at(half * ((2 * e + 1) as f64 + s));
                for k in 1..degree {
                    let by = weight * half * slopes[k];
                    coefficients.column_mut(e * degree + k).axpy(by, &xdot, 1.0);
                }
            }
        }
        coefficients
    }

    /// The curve with these coefficients.
    ///
    /// # Errors
    /// The degree is out of range for Chebyshev nodes.
    pub fn curve(&self, coefficients: &DMatrix<f64>, horizon: f64) -> Result<Curve> {
        let degree = self.degree();
        let nodes = Chebyshev::new(degree, 2.0)?;
        let mut x = DMatrix::zeros(coefficients.nrows(), self.segments * (degree + 1));
        for (i, time) in nodes.times().iter().enumerate() {
            let [values, _] = functions(degree, time - 1.0);
            for e in 0..self.segments {
                let own = coefficients.columns(e * degree, degree + 1);
                let state = match i {
                    0 => own.column(0).into_owned(),
                    _ if i == degree => own.column(degree).into_owned(),
                    _ => own * &values,
                };
                x.set_column(e * (degree + 1) + i, &state);
            }
        }
        Curve::piecewise(horizon, self.segments, x)
    }
}

impl<S: Scalar> StateGrid<S> {
    /// A grid of arbitrary functions: the identities of the assembly hold for any. `table` has values, then slopes.
    pub(crate) fn from_table(
        segments: usize,
        times: Vec<S>,
        weights: Vec<S>,
        table: DMatrix<S>,
    ) -> Self {
        let functions = table.nrows();
        let pairs: Vec<_> = (0..functions)
            .flat_map(|b| (b..functions).map(move |a| (a, b)))
            .collect();
        Self {
            segments,
            collocated: 0,
            times,
            weights,
            table,
            pairs,
            products: OnceLock::new(),
        }
    }

    /// The weighted products of functions, which only derivatives need.
    pub(super) fn products(&self) -> &DMatrix<S> {
        let (points, table, pairs) = (self.points(), &self.table, &self.pairs);
        self.products.get_or_init(|| {
            DMatrix::from_fn(4 * points, pairs.len(), |row, pair| {
                let (kind, g, (a, b)) = (row / points, row % points, pairs[pair]);
                let first = table[(a, kind / 2 * points + g)];
                self.weights[g] * first * table[(b, kind % 2 * points + g)]
            })
        })
    }

    /// The number of segments.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.segments
    }

    /// The times of all points, s, segment by segment.
    #[must_use]
    pub fn times(&self) -> &[S] {
        &self.times
    }

    /// The slip $\dot x_{P1} - x_{P2}$ of the curve with these coefficients at the points of segment `e`, one column
    /// each.
    ///
    /// # Panics
    /// The segment does not exist, or the coefficients have the wrong size.
    #[must_use]
    pub fn slips(&self, coefficients: &DMatrix<S>, e: usize) -> DMatrix<S> {
        let n = coefficients.nrows() / 2;
        let own = coefficients.columns(e * self.degree(), self.degree() + 1);
        let (values, slopes) = self
            .table
            .columns_range_pair(..self.points(), self.points()..);
        own.rows(0, n) * slopes - own.rows(n, n) * values
    }

    /// The degree of each segment.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.table.nrows() - 1
    }

    /// The number of points per segment, `M`.
    #[must_use]
    pub fn points(&self) -> usize {
        self.weights.len()
    }

    /// The number of quadrature points per segment.
    #[must_use]
    pub fn quadrature_points(&self) -> usize {
        self.points() - self.collocated
    }

    /// Returns true if only equalities are enforced at a point, counted along time.
    #[must_use]
    pub fn is_collocated(&self, point: usize) -> bool {
        point % self.points() >= self.quadrature_points()
    }

    /// The number of functions, those of the boundary conditions included.
    #[must_use]
    pub fn count(&self) -> usize {
        self.segments * self.degree() + 1
    }

    /// The functions with unknown coefficients: all but the hat functions at both ends.
    #[must_use]
    pub fn free(&self) -> Range<usize> {
        1..self.count() - 1
    }

    /// The unknown functions of a segment that come after its first: a block of the Hessian.
    pub(super) fn block(&self, e: usize) -> Range<usize> {
        let first = e * self.degree();
        first + 1..(first + self.degree() + 1).min(self.free().end)
    }
}

/// The functions of a segment at `s` in `[-1, 1]`, and their derivatives in `s`.
fn functions(degree: usize, s: f64) -> [DVector<f64>; 2] {
    let mut p = vec![0.0; degree + 1];
    legendre(s, &mut p);
    let [mut values, mut slopes] = [(); 2].map(|()| DVector::zeros(degree + 1));
    (values[0], slopes[0]) = (0.5 - 0.5 * s, -0.5);
    (values[degree], slopes[degree]) = (0.5 + 0.5 * s, 0.5);
    for k in 1..degree {
        let twice = (2 * k + 1) as f64;
        let norm = (0.5 * twice).sqrt();
        values[k] = norm * (p[k + 1] - p[k - 1]) / twice;
        slopes[k] = norm * p[k];
    }
    [values, slopes]
}
