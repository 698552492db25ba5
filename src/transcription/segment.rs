//! The integral of a running cost over one segment.

use super::grid::{add_gradient, jerk_products};
use super::horizon::{Moved, Moving};
use super::horizons::{slopes_alone, stretch};
use super::place::scale;
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
        [moved, moved_jerks]: &mut [Moved<S>; 2],
        gradient: &mut DMatrix<S>,
        out: &mut Derivatives<S>,
    ) {
        let (grid, horizon) = (self.grid, self.horizon);
        let moving = Moving { grid, horizon, rates };
        let own = &mut out.horizons[self.part];
        let mixed = moving.integrate(self.e, self.curve, at_points, moved, own);
        multiply(mixed, &grid.transposed, gradient);
        self.add(gradient, &mut own.mixed);
        if let Some(jerks) = self.curve.jerks {
            let mixed = moving.integrate_jerk(self.e, jerks, at_points, moved_jerks, own);
            multiply(mixed, &grid.thirds[1], gradient);
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
    /// derivatives in the jerk by pairs of functions.
    pub fn weigh(&self, at_points: &mut PointsDerivatives<S>, squares: &mut DMatrix<S>) {
        for (g, weight) in self.grid.weights.iter().enumerate() {
            let mut gradients = at_points.gradients.columns_mut(3 * g, 3);
            gradients *= *weight * self.horizon;
        }
        scale(&mut at_points.gradients, self.horizon);
        if self.curve.jerks.is_some() {
            jerk_products(self.grid, self.horizon, &mut at_points.by_jerk, squares);
        }
    }

    /// Adds the gradient, from gradients at the points that are [weighed](Self::weigh), and with a free horizon in
    /// parts the mixed derivatives of their factors of the slopes.
    pub fn gradient(
        &self,
        is_free: bool,
        at_points: &PointsDerivatives<S>,
        gradient: &mut DMatrix<S>,
        out: &mut Derivatives<S>,
    ) {
        let grid = self.grid;
        let of_jerk = self.curve.jerks.is_some();
        let of_jerk = of_jerk.then_some((&at_points.by_jerk[0], &grid.thirds[1]));
        let of_states = [(&at_points.gradients, &grid.transposed)];
        for (by_points, table) in of_states.into_iter().chain(of_jerk) {
            multiply(by_points, table, gradient);
            if let (Some(reference), true) = (self.horizons.reference(), is_free) {
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
