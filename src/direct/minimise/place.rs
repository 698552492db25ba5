//! A curve at one normalised time, and derivatives there in the unknowns.

use super::point_rows::PointDerivatives;
use crate::curve::Basis;
use crate::linalg::BlockTridiagonal;
use crate::transcription::{Grid, Horizons, functions_in_part};
use nalgebra::{DMatrix, DVector};

/// A curve at one normalised time.
pub(super) struct Place {
    /// The segment, and value and first three derivatives of its functions, one column each.
    pub segment: usize,
    pub functions: DMatrix<f64>,
    /// The derivatives of the functions in the horizon of a part, if slopes have factors.
    pub in_part: Option<DMatrix<f64>>,
    /// The configuration and its first three derivatives, one column each.
    pub q: DMatrix<f64>,
    /// The horizon in whose time the slopes are, s.
    pub horizon: f64,
}

impl Place {
    /// The curve of these coefficients at a normalised time in `[0, 1]`.
    pub fn new(basis: &Basis, coefficients: &DMatrix<f64>, time: f64, horizons: &Horizons<f64>) -> Self {
        let (segment, mut functions) = basis.functions_at(time);
        let own = coefficients.columns(basis.first(segment), functions.ncols());
        let horizon = horizons.parts()[horizons.part(segment, basis.segments())];
        let in_part = horizons.reference().map(|reference| {
            let shared = basis.continuity().order();
            let [stretched, rates] = functions_in_part(&functions, shared, (horizon, reference));
            functions = stretched;
            rates
        });
        let q = own * functions.transpose();
        Self { segment, functions, in_part, q, horizon }
    }

    /// Adds `factor` times the derivatives in the unknown coefficients of a function of $q$ and $q'$, or, with `d` one,
    /// those of its derivative in time where the functions themselves change.
    pub(super) fn scatter(&self, grid: &Grid<f64>, of: &DVector<f64>, d: usize, factor: f64, out: &mut [f64]) {
        self.scatter_functions(grid, (&self.functions, d), of, factor, out);
    }

    /// Does the same with other functions.
    pub(super) fn scatter_functions(
        &self,
        grid: &Grid<f64>,
        (functions, d): (&DMatrix<f64>, usize),
        of: &DVector<f64>,
        factor: f64,
        out: &mut [f64],
    ) {
        let n = of.len() / 2;
        for (m, unknown) in self.unknowns(grid) {
            let [value, slope] = [d, d + 1].map(|d| factor * functions[(d, m)]);
            for (i, out) in out[unknown * n..(unknown + 1) * n].iter_mut().enumerate() {
                *out += value * of[i] + slope * of[n + i];
            }
        }
    }

    /// Adds `factor` times the Hessian in the unknown coefficients.
    pub(super) fn add_hessian(
        &self,
        grid: &Grid<f64>,
        of: &PointDerivatives,
        factor: f64,
        out: &mut BlockTridiagonal<f64>,
    ) {
        let n = of.gradient.len() / 2;
        for (a, b) in grid.pairs.iter().copied() {
            if let Some(mut target) = grid.block_mut(self.segment, (a, b), n, out) {
                for (x, y) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let product = factor * self.functions[(x, a)] * self.functions[(y, b)];
                    // Half of the functions of a breakpoint vanish there.
                    if product != 0.0 {
                        let own = of.hessian.view((x * n, y * n), (n, n));
                        target.zip_apply(&own, |to, own| *to += product * own);
                    }
                }
            }
        }
    }

    /// The functions of the segment with unknown coefficients, each with its unknown.
    fn unknowns(&self, grid: &Grid<f64>) -> impl Iterator<Item = (usize, usize)> {
        let first = grid.first(self.segment);
        let functions = 0..self.functions.ncols();
        functions.filter_map(move |m| Some((m, grid.unknown[first + m]?)))
    }
}

/// Two neighbouring columns, one below the other.
pub(super) fn pair(of: &DMatrix<f64>, first: usize) -> DVector<f64> {
    DVector::from_column_slice(of.columns(first, 2).into_owned().as_slice())
}

/// The derivatives in the horizon of configuration and slope at a time in s.
///
/// The normalised time is $\tau = t / T$ and the velocity $q' / T$, where $q'$ is the slope in normalised time. A longer
/// horizon moves the time by $-\tau / T$, and acts on the velocity as a change of the slope by $-q' / T$ does.
pub(super) struct InHorizon {
    pub first: DVector<f64>,
    second: DVector<f64>,
    /// $\tau / T$ and $T$.
    late: f64,
    horizon: f64,
}

impl InHorizon {
    /// The derivatives at a place with configuration and slopes `q`; `rates` are those of coefficients that depend on
    /// the horizon.
    pub fn new(place: &Place, rates: &DMatrix<f64>, time_s: f64) -> Self {
        let (q, n, horizon) = (&place.q, place.q.nrows(), place.horizon);
        let late = time_s / (horizon * horizon);
        let moved = pair(rates, 0) - pair(q, 1) * late;
        let mut first = moved.clone();
        let slope = place.q.column(1) / horizon;
        let mut of_slope = first.rows_mut(n, n);
        of_slope -= &slope;
        let mut second =
            pair(q, 2) * (late * late) + pair(q, 1) * (2.0 * late / horizon) - pair(rates, 1) * (2.0 * late);
        let mut of_slope = second.rows_mut(n, n);
        of_slope += (slope - moved.rows(n, n)) * (2.0 / horizon);
        Self { first, second, late, horizon }
    }

    /// Adds the second derivatives of rows with these multipliers, `factor` times: in the horizon and each coefficient
    /// to `column`, and in the horizon alone, which is returned.
    pub fn add_second(
        &self,
        (place, grid): (&Place, &Grid<f64>),
        multipliers: &DVector<f64>,
        factor: f64,
        column: &mut [f64],
    ) -> f64 {
        place.scatter(grid, multipliers, 1, -factor * self.late, column);
        let mut of_slope = multipliers.clone();
        of_slope.rows_mut(0, place.q.nrows()).fill(0.0);
        place.scatter(grid, &of_slope, 0, -factor / self.horizon, column);
        factor * multipliers.dot(&self.second)
    }
}
