//! The horizon of a motion, or those of its parts.

use super::Grid;
use super::place::place;
use crate::linalg::multiply;
use crate::scalar::Scalar;
use nalgebra::DMatrix;

/// The horizon of a motion, or those of parts whose lengths differ.
///
/// Each of `K` parts has a share $1 / K$ of normalised time $\tau$, and in part `k` time passes at the rate
/// $T_k = K d_k$ with its length $d_k$; the horizon $T$ is their mean. So that velocities are continuous from one part
/// to the next, the coefficient of a slope is that in the time of a reference $T_0$: in part `k` it is multiplied by
/// $T_k / T_0$.
#[derive(Clone, Debug, PartialEq)]
pub struct Horizons<S> {
    parts: Vec<S>,
    /// $T_0$; `None` with a single horizon, in whose time slopes are.
    reference: Option<S>,
}

impl<S: Scalar> Horizons<S> {
    /// One horizon `T`.
    #[must_use]
    pub fn one(horizon: S) -> Self {
        Self { parts: vec![horizon], reference: None }
    }

    /// The horizons $T_k$ of parts, and the reference $T_0$.
    #[must_use]
    pub fn of_parts(parts: Vec<S>, reference: S) -> Self {
        Self { parts, reference: Some(reference) }
    }

    /// The horizons of all parts.
    #[must_use]
    pub fn parts(&self) -> &[S] {
        &self.parts
    }

    /// Takes over other horizons in the memory of these.
    pub(crate) fn assign(&mut self, from: &Self) {
        self.parts.clone_from(&from.parts);
        self.reference = from.reference;
    }

    /// Changes the horizon of a part.
    pub(crate) fn set(&mut self, part: usize, horizon: S) {
        self.parts[part] = horizon;
    }

    /// The reference $T_0$ of slopes; `None` with a single horizon.
    pub(crate) fn reference(&self) -> Option<S> {
        self.reference
    }

    /// The whole horizon `T`.
    #[must_use]
    pub fn whole(&self) -> S {
        match &self.parts[..] {
            [one] => *one,
            all => all.iter().fold(S::zero(), |sum, part| sum + *part) * self.share(),
        }
    }

    /// The share $1 / K$ of a part.
    pub(crate) fn share(&self) -> S {
        S::one() / S::from_f64(self.parts.len() as f64)
    }

    /// The part of one of several segments.
    pub(crate) fn part(&self, segment: usize, segments: usize) -> usize {
        segment * self.parts.len() / segments
    }

    /// The time at which a part begins.
    pub(crate) fn begin(&self, part: usize) -> S {
        let before = self.parts[..part].iter();
        before.fold(S::zero(), |sum, part| sum + *part) * self.share()
    }

    /// The time at a normalised time in a part.
    pub(crate) fn time(&self, part: usize, normalised: S) -> S {
        let own = match part {
            0 => normalised,
            _ => normalised - S::from_f64(part as f64) * self.share(),
        };
        self.begin(part) + self.parts[part] * own
    }

    /// The factor of slopes in a part; `None` with a single horizon.
    pub(crate) fn stretch(&self, part: usize) -> Option<S> {
        self.reference.map(|reference| self.parts[part] / reference)
    }
}

impl Horizons<f64> {
    /// The normalised time at a time in s; `None` if that is outside the motion.
    pub(crate) fn normalised(&self, time: f64) -> Option<f64> {
        (0..self.parts.len()).find_map(|part| {
            let own = (time - self.begin(part)) / self.parts[part];
            let of_part = (0.0..=self.share()).contains(&own);
            of_part.then(|| part as f64 * self.share() + own)
        })
    }
}

/// The two functions of a segment with unit slopes at its ends, among this number of them.
pub(super) fn slopes(functions: usize, shared: usize) -> [usize; 2] {
    [shared - 2, functions - 2]
}

/// Multiplies the columns of the slopes of a segment, one column per function, by the factor of its part, if there is
/// one.
pub(super) fn stretch<S: Scalar>(columns: &mut DMatrix<S>, shared: usize, factor: Option<S>) {
    if let Some(factor) = factor {
        for slope in slopes(columns.ncols(), shared) {
            let mut column = columns.column_mut(slope);
            column *= factor;
        }
    }
}

/// The functions of a segment at a time, one column each, in a part: with their factors, and their derivatives in the
/// horizon of the part.
pub(crate) fn functions_in_part(
    functions: &DMatrix<f64>,
    shared: usize,
    (horizon, reference): (f64, f64),
) -> [DMatrix<f64>; 2] {
    let mut stretched = functions.clone();
    stretch(&mut stretched, shared, Some(horizon / reference));
    [stretched, slopes_alone(functions, shared, reference)]
}

/// Computes the curve of the functions from `first` on by `table`, in a part with this factor of slopes.
pub(crate) fn place_in<S: Scalar>(
    coefficients: &DMatrix<S>,
    first: usize,
    table: &DMatrix<S>,
    (shared, factor): (usize, Option<S>),
    states: &mut DMatrix<S>,
) {
    if factor.is_none() {
        place(coefficients, first, table, states);
        return;
    }
    let mut own = coefficients.columns(first, table.nrows()).into_owned();
    stretch(&mut own, shared, factor);
    multiply(&own, table, states);
}

/// Computes the rates of the coefficients in the horizons of parts: those of the slopes, $c / T_0$.
pub(super) fn rates_of_slopes<S: Scalar>(
    coefficients: &DMatrix<S>,
    grid: &Grid<S>,
    reference: S,
    rates: &mut DMatrix<S>,
) {
    let between = grid.table.nrows() - grid.shared;
    for slope in (grid.shared - 2..coefficients.ncols()).step_by(between) {
        rates.set_column(slope, &(coefficients.column(slope) / reference));
    }
}

/// The derivatives in the horizon of a part of the factors of the slopes of a segment, times `gradient`, the
/// derivatives in its stretched coefficients, one column per function.
pub(super) fn slopes_alone<S: Scalar>(gradient: &DMatrix<S>, shared: usize, reference: S) -> DMatrix<S> {
    let mut own = DMatrix::zeros(gradient.nrows(), gradient.ncols());
    for slope in slopes(gradient.ncols(), shared) {
        own.set_column(slope, &(gradient.column(slope) / reference));
    }
    own
}
