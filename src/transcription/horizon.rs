//! The derivatives of an integral over a horizon that is an unknown.

use super::Grid;
use super::place::{place, rate, scale};
use crate::cost::{Points, PointsDerivatives};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

/// Derivatives in the horizon; zero while it is fixed.
#[derive(Clone, Debug)]
pub struct HorizonDerivatives<S: Scalar> {
    /// The first derivative.
    pub first: S,
    /// The second derivative.
    pub second: S,
    /// The mixed derivatives with the unknown coefficients.
    pub mixed: DVector<S>,
}

impl<S: Scalar> HorizonDerivatives<S> {
    /// Zeros for this number of unknown coefficients.
    pub(super) fn zeros(unknowns: usize) -> Self {
        Self { first: S::zero(), second: S::zero(), mixed: DVector::zeros(unknowns) }
    }
}

/// A curve whose horizon is an unknown.
pub(super) struct Moving<'g, S: Scalar> {
    pub grid: &'g Grid<S>,
    pub horizon: S,
    /// The rates of the coefficients in the horizon, `N` by the number of functions.
    pub rates: &'g DMatrix<S>,
}

/// Memory of the derivatives in the horizon.
pub(super) struct Moved<S: Scalar> {
    /// The rates of the derivatives of the curve, and the mixed derivatives.
    rates: DMatrix<S>,
    mixed: DMatrix<S>,
    /// $z_T$, $z_{TT}$ and $l_{zz} z_T$ at a point.
    at_point: [DVector<S>; 3],
}

impl<S: Scalar> Default for Moved<S> {
    fn default() -> Self {
        let [rates, mixed] = [(); 2].map(|()| DMatrix::zeros(0, 0));
        Self { rates, mixed, at_point: [(); 3].map(|()| DVector::zeros(0)) }
    }
}

impl<S: Scalar> Moved<S> {
    /// Memory for `n` joints and this number of columns.
    fn resize(&mut self, n: usize, columns: usize) {
        if self.mixed.shape() != (n, columns) {
            self.rates = DMatrix::zeros(n, columns);
            self.mixed = DMatrix::zeros(n, columns);
            self.at_point = [(); 3].map(|()| DVector::zeros(3 * n));
        }
    }
}

impl<S: Scalar> Moving<'_, S> {
    /// Adds the derivatives of the integral over segment `e` in the horizon; returns the mixed derivatives in
    /// $(q, q', q'')$ at the points, `N` by `3 M`, with their weights.
    ///
    /// With $z^x = T^{-x} \phi^x c$ and coefficients that change at constant rates $\dot c$ (the segment adds the
    /// product of $\ddot c$ and the gradient),
    ///
    /// $$ z_T^x = T^{-x} \phi^x \dot c - \tfrac x T z^x, \qquad
    ///    z_{TT}^x = -\tfrac x T (T^{-x} \phi^x \dot c + z_T^x) + \tfrac{x}{T^2} z^x, $$
    ///
    /// The part of a cost that depends on time itself is added by the caller, to the first derivative alone.
    ///
    /// $$ \frac{\partial}{\partial T} T l = l + T l_z z_T, \qquad
    ///    \frac{\partial^2}{\partial T^2} T l = 2\\, l_z z_T + T (z_T^T l_{zz} z_T + l_z z_{TT}), \qquad
    ///    \frac{\partial^2}{\partial T\\, \partial (\phi^x c)} T l = T^{-x} ((1 - x)\\, l_z^x + T (l_{zz} z_T)^x) . $$
    pub fn integrate<'m>(
        &self,
        e: usize,
        points: Points<'_, S>,
        at: &PointsDerivatives<S>,
        memory: &'m mut Moved<S>,
        out: &mut HorizonDerivatives<S>,
    ) -> &'m DMatrix<S> {
        let Self { grid, horizon, rates } = *self;
        let n = rates.nrows();
        memory.resize(n, grid.table.ncols());
        let Moved { rates: moved, mixed, at_point: [first, second, bent] } = memory;
        place(rates, grid.first(e), &grid.table, moved);
        scale(moved, horizon);
        let power = |x: usize| S::from_f64(x as f64);
        for (g, weight) in grid.weights.iter().enumerate() {
            let gradient = &at.gradients.as_slice()[3 * g * n..(3 * g + 3) * n];
            let state = &points.states.as_slice()[3 * g * n..(3 * g + 3) * n];
            let moved = &moved.as_slice()[3 * g * n..(3 * g + 3) * n];
            for i in 0..3 * n {
                let rate = power(i / n) / horizon;
                first[i] = moved[i] - rate * state[i];
                second[i] = rate * (state[i] / horizon - moved[i] - first[i]);
            }
            at.hessians.product(g, first, bent);
            let dot = |x: &DVector<S>| x.iter().zip(gradient).fold(S::zero(), |sum, (a, b)| sum + *a * *b);
            let slope = dot(first);
            out.first += *weight * (at.costs[g] + horizon * slope);
            let two = S::from_f64(2.0);
            out.second += *weight * (two * slope + horizon * (first.dot(bent) + dot(second)));
            for i in 0..3 * n {
                let own = (S::one() - power(i / n)) * gradient[i] + horizon * bent[i];
                mixed[(i % n, 3 * g + i / n)] = *weight * own;
            }
        }
        scale(mixed, horizon);
        mixed
    }

    /// Does the same for the part of a cost in the derivative of a higher order, $z = T^{-x} \phi^{(x)} c$, with the
    /// first and second derivatives in it in `at`. The cost itself is part of [`integrate`](Self::integrate).
    pub fn integrate_higher<'m>(
        &self,
        (e, order): (usize, usize),
        values: &DMatrix<S>,
        [slopes, curvatures]: &[DMatrix<S>; 2],
        memory: &'m mut Moved<S>,
        out: &mut HorizonDerivatives<S>,
    ) -> &'m DMatrix<S> {
        let Self { grid, horizon, rates } = *self;
        let (n, power, scale) = (rates.nrows(), S::from_f64(order as f64), rate(horizon, order));
        let [one, two] = [1.0, 2.0].map(S::from_f64);
        memory.resize(n, grid.points());
        let Moved { rates: moved, mixed, .. } = memory;
        place(rates, grid.first(e), &grid.higher[order - 3].table, moved);
        *moved *= scale;
        for (g, weight) in grid.weights.iter().enumerate() {
            for i in 0..n {
                let (slope, bend, value) = (slopes[(i, g)], curvatures[(i, g)], values[(i, g)]);
                let first = moved[(i, g)] - power / horizon * value;
                let second = power / horizon * (value / horizon - moved[(i, g)] - first);
                out.first += *weight * horizon * slope * first;
                let squares = slope * second + bend * first * first;
                out.second += *weight * (two * slope * first + horizon * squares);
                mixed[(i, g)] = *weight * scale * (horizon * bend * first - (power - one) * slope);
            }
        }
        mixed
    }
}
