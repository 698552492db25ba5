//! The integral of a running cost over one segment.

use super::grid::add_gradient;
use super::horizon::{Moved, Moving};
use super::horizons::{slopes_alone, stretch};
use super::place::{rate, scale};
use super::{Derivatives, Grid, Horizons};
use crate::cost::{PointCost, Points, PointsDerivatives};
use crate::error::Result;
use crate::linalg::multiply;
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

/// Segment `e` in its part of the horizon, with the curve at its points.
pub(super) struct Segment<'a, S: Scalar> {
    grid: &'a Grid<S>,
    horizons: &'a Horizons<S>,
    e: usize,
    curve: Points<'a, S>,
    part: usize,
    /// The factor from the time of the grid to time.
    pub horizon: S,
    /// The factor of the slopes, if parts have their own.
    pub factor: Option<S>,
}

impl<'a, S: Scalar> Segment<'a, S> {
    pub fn new(grid: &'a Grid<S>, horizons: &'a Horizons<S>, e: usize, curve: Points<'a, S>) -> Self {
        let part = horizons.part(e, grid.segments);
        Self { grid, horizons, e, curve, part, horizon: horizons.parts()[part], factor: horizons.stretch(part) }
    }

    /// Adds the derivatives in the horizon of the part, with coefficients that change at these rates, see [`Moving`].
    pub fn in_horizon(
        &self,
        rates: &DMatrix<S>,
        at_points: &PointsDerivatives<S>,
        moved: &mut [Moved<S>],
        gradient: &mut DMatrix<S>,
        out: &mut Derivatives<S>,
    ) {
        let (grid, horizon) = (self.grid, self.horizon);
        let moving = Moving { grid, horizon, rates };
        let own = &mut out.horizons[self.part];
        let Some((moved, moved_higher)) = moved.split_first_mut() else {
            return;
        };
        let mixed = moving.integrate(self.e, self.curve, at_points, moved, own);
        multiply(mixed, &grid.transposed, gradient);
        self.add(gradient, &mut own.mixed);
        for ((k, rates), moved) in self.curve.higher.iter().enumerate().zip(moved_higher) {
            let mixed = moving.integrate_higher((self.e, 3 + k), rates, &at_points.higher[k], moved, own);
            multiply(mixed, &grid.higher[k].transposed, gradient);
            self.add(gradient, &mut own.mixed);
        }
    }

    /// Adds the derivatives in the horizons of this part and those before it of a cost that depends on time itself.
    pub fn in_time(&self, cost: &mut impl PointCost<S>, out: &mut Derivatives<S>) -> Result<()> {
        let begin = self.horizons.begin(self.part);
        for (g, weight) in self.grid.weights.iter().enumerate() {
            let late = *weight * cost.time_rate(self.curve.point(g))?;
            out.horizons[self.part].first += late * (self.curve.times[g] - begin);
            for earlier in &mut out.horizons[..self.part] {
                earlier.first += late * self.horizon * self.horizons.share();
            }
        }
        Ok(())
    }

    /// Multiplies the gradients at the points by their weights and the powers of the horizon, and tabulates the second
    /// derivatives in each higher order by pairs of functions.
    pub fn weigh(&self, at_points: &mut PointsDerivatives<S>, squares: &mut [DMatrix<S>]) {
        for (g, weight) in self.grid.weights.iter().enumerate() {
            let mut gradients = at_points.gradients.columns_mut(3 * g, 3);
            gradients *= *weight * self.horizon;
        }
        scale(&mut at_points.gradients, self.horizon);
        let all = self.grid.higher.iter().zip(&mut at_points.higher).zip(squares);
        for (k, ((of, by_rates), squares)) in all.enumerate() {
            of.weigh(self.grid, (self.horizon, rate(self.horizon, 3 + k)), by_rates, squares);
        }
    }

    /// Adds the gradient, from gradients at the points that are [weighed](Self::weigh); with a free horizon also its
    /// product with the second derivatives of the coefficients in it, and in parts the mixed derivatives of their
    /// factors of the slopes.
    pub fn gradient(
        &self,
        second_rates: Option<&DMatrix<S>>,
        at_points: &PointsDerivatives<S>,
        gradient: &mut DMatrix<S>,
        out: &mut Derivatives<S>,
    ) {
        let grid = self.grid;
        let higher = at_points.higher.iter().zip(&grid.higher).map(|(of, higher)| (&of[0], &higher.transposed));
        let of_states = [(&at_points.gradients, &grid.transposed)];
        for (by_points, table) in of_states.into_iter().chain(higher) {
            multiply(by_points, table, gradient);
            if let Some(second) = second_rates {
                let own = second.columns(grid.first(self.e), gradient.ncols());
                out.horizons[self.part].second += gradient.dot(&own);
            }
            if let (Some(reference), true) = (self.horizons.reference(), second_rates.is_some()) {
                let by_factor = slopes_alone(gradient, grid.shared, reference);
                let mixed = &mut out.horizons[self.part].mixed;
                add_gradient(grid, &by_factor, self.e, mixed);
            }
            self.add(gradient, &mut out.gradient);
        }
    }

    /// Adds derivatives in the stretched coefficients of this segment, one column per function, to those of the curve.
    fn add(&self, gradient: &mut DMatrix<S>, out: &mut DVector<S>) {
        stretch(gradient, self.grid.shared, self.factor);
        add_gradient(self.grid, gradient, self.e, out);
    }
}
