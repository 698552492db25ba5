//! The derivatives of an integral over a horizon that is an unknown.

use super::objective::scale;
use super::{Grid, place};
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

/// A curve whose horizon is an unknown.
pub(super) struct Moving<'g, S: Scalar> {
    pub grid: &'g Grid<S>,
    pub horizon: S,
    /// The rates of the coefficients in the horizon, `N` by the number of functions.
    pub rates: &'g DMatrix<S>,
}

impl<S: Scalar> Moving<'_, S> {
    /// Adds the derivatives of the integral over segment `e` in the horizon; returns the mixed derivatives in
    /// $(q, q', q'')$ at the points, `N` by `3 M`, with their weights.
    ///
    /// With $z^x = T^{-x} \phi^x c$ and coefficients that change at the rates $\dot c$,
    ///
    /// $$ z_T^x = T^{-x} \phi^x \dot c - \tfrac x T z^x, \qquad
    ///    z_{TT}^x = -\tfrac x T (T^{-x} \phi^x \dot c + z_T^x) + \tfrac{x}{T^2} z^x, $$
    ///
    /// The part of a cost that depends on time itself is added by the caller, to the first derivative alone.
    ///
    /// $$ \frac{\partial}{\partial T} T l = l + T l_z z_T, \qquad
    ///    \frac{\partial^2}{\partial T^2} T l = 2\\, l_z z_T + T (z_T^T l_{zz} z_T + l_z z_{TT}), \qquad
    ///    \frac{\partial^2}{\partial T\\, \partial (\phi^x c)} T l = T^{-x} ((1 - x)\\, l_z^x + T (l_{zz} z_T)^x) . $$
    pub fn integrate(
        &self,
        e: usize,
        points: Points<'_, S>,
        at: &PointsDerivatives<S>,
        out: &mut HorizonDerivatives<S>,
    ) -> DMatrix<S> {
        let Self {
            grid,
            horizon,
            rates,
        } = *self;
        let n = rates.nrows();
        let mut moved = DMatrix::zeros(n, grid.table.ncols());
        place(rates, grid.first(e), &grid.table, &mut moved);
        scale(&mut moved, horizon);
        let mut mixed = DMatrix::zeros(n, moved.ncols());
        let power = |x: usize| S::from_f64(x as f64);
        let [mut first, mut second, mut bent] = [(); 3].map(|()| DVector::zeros(3 * n));
        for (g, weight) in grid.weights.iter().enumerate() {
            let gradient = &at.gradients.as_slice()[3 * g * n..(3 * g + 3) * n];
            let state = &points.states.as_slice()[3 * g * n..(3 * g + 3) * n];
            let moved = &moved.as_slice()[3 * g * n..(3 * g + 3) * n];
            for i in 0..3 * n {
                let rate = power(i / n) / horizon;
                first[i] = moved[i] - rate * state[i];
                second[i] = rate * (state[i] / horizon - moved[i] - first[i]);
            }
            at.hessians.product(g, &first, &mut bent);
            let dot = |x: &DVector<S>| {
                x.iter()
                    .zip(gradient)
                    .fold(S::zero(), |sum, (a, b)| sum + *a * *b)
            };
            let slope = dot(&first);
            out.first += *weight * (at.costs[g] + horizon * slope);
            let two = S::from_f64(2.0);
            out.second += *weight * (two * slope + horizon * (first.dot(&bent) + dot(&second)));
            for i in 0..3 * n {
                let own = (S::one() - power(i / n)) * gradient[i] + horizon * bent[i];
                mixed[(i % n, 3 * g + i / n)] = *weight * own;
            }
        }
        scale(&mut mixed, horizon);
        mixed
    }

    /// Does the same for the part of a cost in the jerk $z = T^{-3} \phi^{(3)} c$, with the first and second derivatives
    /// in it in `at`. The cost itself is part of [`integrate`](Self::integrate).
    pub fn integrate_jerk(
        &self,
        e: usize,
        jerks: &DMatrix<S>,
        at: &PointsDerivatives<S>,
        out: &mut HorizonDerivatives<S>,
    ) -> DMatrix<S> {
        let Self {
            grid,
            horizon,
            rates,
        } = *self;
        let (n, [two, three]) = (rates.nrows(), [2.0, 3.0].map(S::from_f64));
        let scale = S::one() / (horizon * horizon * horizon);
        let mut moved = DMatrix::zeros(n, grid.points());
        place(rates, grid.first(e), &grid.thirds[0], &mut moved);
        moved *= scale;
        let mut mixed = DMatrix::zeros(n, grid.points());
        let [slopes, curvatures] = &at.by_jerk;
        for (g, weight) in grid.weights.iter().enumerate() {
            for i in 0..n {
                let (slope, bend, jerk) = (slopes[(i, g)], curvatures[(i, g)], jerks[(i, g)]);
                let first = moved[(i, g)] - three / horizon * jerk;
                let second = three / horizon * (jerk / horizon - moved[(i, g)] - first);
                out.first += *weight * horizon * slope * first;
                let squares = slope * second + bend * first * first;
                out.second += *weight * (two * slope * first + horizon * squares);
                mixed[(i, g)] = *weight * scale * (horizon * bend * first - two * slope);
            }
        }
        mixed
    }
}
