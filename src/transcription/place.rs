//! A curve in a basis at the points of a segment.

use super::Grid;
use crate::cost::Points;
use crate::linalg::multiply;
use crate::scalar::Scalar;
use nalgebra::DMatrix;

/// Divides the columns of first derivatives by the horizon, and those of second ones by its square.
pub(crate) fn scale<S: Scalar>(states: &mut DMatrix<S>, horizon: S) {
    let rate = S::one() / horizon;
    for (column, mut values) in states.column_iter_mut().enumerate() {
        match column % 3 {
            0 => (),
            1 => values *= rate,
            _ => values *= rate * rate,
        }
    }
}

/// The factor of derivatives of an order from the time of the grid to time.
pub(crate) fn rate<S: Scalar>(horizon: S, order: usize) -> S {
    S::one() / (1..order).fold(horizon, |power, _| power * horizon)
}

/// Computes the curve of the functions from `first` on by `table`.
pub(crate) fn place<S: Scalar>(coefficients: &DMatrix<S>, first: usize, table: &DMatrix<S>, states: &mut DMatrix<S>) {
    if coefficients.ncols() == table.nrows() {
        // One segment has all functions.
        multiply(coefficients, table, states);
        return;
    }
    let own = coefficients.columns(first, table.nrows()).into_owned();
    multiply(&own, table, states);
}

/// The input of the running cost at the points of segment `e`, which is in `phase`.
pub(crate) fn points<'a, S: Scalar>(
    grid: &'a Grid<S>,
    times: &'a [S],
    (states, higher): (&'a DMatrix<S>, &'a [DMatrix<S>]),
    e: usize,
    phase: usize,
) -> Points<'a, S> {
    let first = e * grid.points();
    Points { first, phase, times: &times[first..first + grid.points()], states, higher }
}
