//! The gradients of equalities at single points.

use super::grid::add_gradient;
use super::horizons::stretch;
use super::place::scale;
use super::{Objective, Rows};
use crate::constraint::{Constraint, Weights};
use crate::cost::{ChainRule, CostWithControl, Point, PointCost};
use crate::error::Result;
use crate::scalar::{LANES, Wide};
use nalgebra::{DMatrix, DVector};

impl<K: Constraint, P: CostWithControl> Rows<'_, K, P> {
    /// The gradients in $(q, v, a)$ of each equality at points, given $q, v, a$ there, one column each, with
    /// derivatives in the same order: `N` by `3 M` each.
    pub fn equality_gradients(&mut self, states: &DMatrix<f64>) -> Result<Vec<DMatrix<f64>>> {
        let held = (0..self.count()).filter(|row| self.attributes.equalities[*row]);
        let held: Vec<_> = held.collect();
        let of_row = |row: usize| match row.checked_sub(self.states()) {
            None => self.gradients_of_state(row, states),
            Some(torque) => self.gradients_of_torque(torque, states),
        };
        held.into_iter().map(of_row).collect()
    }

    /// Those of a row of the state, side by side.
    fn gradients_of_state(&mut self, row: usize, states: &DMatrix<f64>) -> Result<DMatrix<f64>> {
        let (n, columns) = states.shape();
        let mut weights = vec![Wide::splat(0.0); self.states()];
        weights[row] = Wide::splat(self.attributes.scales[row]);
        let weights = Weights { first_order: &weights[..], gauss_newton: None };
        let mut out = DMatrix::zeros(n, columns);
        for start in (0..columns / 3).step_by(LANES) {
            let found = Wide::gather(states.as_slice(), start, &mut self.z);
            let rows = (&self.constraints.state, None);
            let of = self.evaluator.weighted_derivatives_at(&self.z[..2 * n], rows, weights)?;
            for (i, slope) in of.gradient().iter().enumerate() {
                for lane in 0..found {
                    out[(i % n, 3 * (start + lane) + i / n)] = slope.0[lane];
                }
            }
        }
        Ok(out)
    }

    /// Those of the torque of a passive joint.
    fn gradients_of_torque(&mut self, row: usize, states: &DMatrix<f64>) -> Result<DMatrix<f64>> {
        let (n, columns) = states.shape();
        let mut by_y = DVector::zeros(4 * n);
        if let Some((joint, ..)) = self.constraints.torque.rows().nth(row) {
            by_y[3 * n + joint] = self.attributes.scales[self.states() + row];
        }
        let mut rule = ChainRule::new(self.model);
        let (mut gradient, mut out) = (DVector::zeros(3 * n), DMatrix::zeros(n, columns));
        for (z, to) in states.as_slice().chunks_exact(3 * n).zip(out.as_mut_slice().chunks_exact_mut(3 * n)) {
            rule.linearise(Point { index: 0, phase: 0, time: 0.0, q: &z[..n], v: &z[n..2 * n], a: &z[2 * n..] })?;
            rule.gradient(&by_y, &mut gradient);
            to.copy_from_slice(gradient.as_slice());
        }
        Ok(out)
    }
}

impl<P: PointCost<f64>> Objective<'_, f64, P> {
    /// Calls `each` for each equality at each [collocated](super::Grid::collocated) point, point by point, with the
    /// index of its segment, its gradient in the unknown coefficients, and its derivative in the horizon of the part of
    /// the segment. With the cost and $q, v, a$ at the collocated points of a segment, one column each, `at_points`
    /// computes the derivatives of each equality in these, in the same order: `N` by `3 M` each.
    ///
    /// # Errors
    /// Those of `at_points`.
    pub fn equality_gradients(
        &mut self,
        coefficients: &DMatrix<f64>,
        at_points: impl Fn(&mut P, &DMatrix<f64>) -> Result<Vec<DMatrix<f64>>>,
        each: &mut dyn FnMut(usize, &DVector<f64>, f64),
    ) -> Result<()> {
        let points = (0..self.grid().points()).filter(|g| self.grid().collocated[*g]);
        let points: Vec<_> = points.collect();
        if points.is_empty() {
            return Ok(());
        }
        let columns: Vec<_> = points.iter().flat_map(|g| 3 * g..3 * g + 3).collect();
        let mut gradient = DVector::zeros(self.grid().free.len() * self.dof());
        for e in 0..self.grid().segments {
            self.place(coefficients, e);
            let states = self.states.select_columns(&columns);
            let all = at_points(self.cost_mut(), &states)?;
            for (k, g) in points.iter().enumerate() {
                for of in &all {
                    gradient.fill(0.0);
                    let at = [&states, of].map(|of| of.columns(3 * k, 3).into_owned());
                    let by_horizon = self.add_gradient_at((e, *g), &at, &mut gradient);
                    each(e, &gradient, by_horizon);
                }
            }
        }
        Ok(())
    }

    /// Adds the gradient of a function of $q, v, a$ at point `g` of segment `e`, given those and its derivatives in
    /// them, to that in the unknown coefficients. Returns its derivative in the horizon of the part: with coefficients
    /// that change at rates $\dot c$ it is that of $z^x = T^{-x} \phi^x c$,
    /// $z_T^x = T^{-x} \phi^x \dot c - \tfrac x T z^x$.
    fn add_gradient_at(
        &self,
        (e, g): (usize, usize),
        [state, derivatives]: &[DMatrix<f64>; 2],
        out: &mut DVector<f64>,
    ) -> f64 {
        let grid = self.grid();
        let part = self.horizons.part(e, grid.segments);
        let horizon = self.horizons.parts()[part];
        let mut by_points = derivatives.clone();
        scale(&mut by_points, horizon);
        let mut gradient = by_points * grid.table.columns(3 * g, 3).transpose();
        let own = self.rates.as_ref().map(|[rates, _]| rates.columns(grid.first(e), gradient.ncols()));
        let moved = own.map_or(0.0, |rates| gradient.dot(&rates));
        let slower = derivatives.column(1).dot(&state.column(1)) + 2.0 * derivatives.column(2).dot(&state.column(2));
        stretch(&mut gradient, grid.shared, self.horizons.stretch(part));
        add_gradient(grid, &gradient, e, out);
        moved - slower / horizon
    }
}
