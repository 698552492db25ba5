//! The block of the rows at single times.

use super::place::{InHorizon, Place, pair};
use super::point_rows::{PointDerivatives, PointRows};
use super::unknowns::Unknowns;
use super::windows::Window;
use crate::constraint::AnyConstraint;
use crate::direct::Waypoint;
use crate::error::Result;
use crate::linalg::BlockTridiagonal;
use crate::model::Model;
use crate::nlp::{Equality, Iterate, Kkt, Row};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// An unknown of the border, with derivatives in it.
type Moving = (usize, DVector<f64>);

/// The rows of waypoints, of a goal, of windows and beside ends at a bound, with their margins. They follow those of
/// the points of the quadrature.
pub(super) struct PointBlock<'g> {
    /// The rows at each time; those of waypoints and of a goal come first.
    pub rows: Vec<PointRows<'g>>,
    pub windows: Vec<Window>,
    /// The index of the first row among all.
    first: usize,
    pub margins: Vec<f64>,
    /// The factor of the weights: the horizon at the beginning. With the current one the penalty of a goal would vanish
    /// with the horizon, and a search could shrink to a motion that goes nowhere in no time.
    pub measure: f64,
}

impl<'g> PointBlock<'g> {
    /// No rows; `first` is the number of those before.
    pub fn new(first: usize, measure: f64) -> Self {
        Self { rows: Vec::new(), windows: Vec::new(), first, margins: Vec::new(), measure }
    }

    /// Adds the rows at one time, given the index of the first of them among all, without margins; returns their index.
    pub fn push(&mut self, rows: impl FnOnce(usize) -> PointRows<'g>) -> usize {
        let rows = rows(self.range().end);
        self.margins.resize(self.margins.len() + rows.h.len(), 0.0);
        self.rows.push(rows);
        self.rows.len() - 1
    }

    /// Adds the rows of waypoints and of a goal.
    pub fn add_goal_and_waypoints(
        &mut self,
        model: &'g Model,
        waypoints: &'g [Waypoint],
        goal: Option<&'g [AnyConstraint]>,
    ) {
        for waypoint in waypoints {
            self.push(|first| PointRows::of_waypoint(model, waypoint, first));
        }
        if let Some(goal) = goal {
            self.push(|first| PointRows::of_goal(model, goal, first));
        }
    }

    /// The indices of the rows among all.
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.margins.len()
    }

    /// The indices of the inequalities among all rows.
    pub fn inequalities(&self) -> impl Iterator<Item = usize> {
        let held = self.rows.iter().flat_map(|rows| &rows.equalities);
        let rows = self.range().zip(held);
        rows.filter_map(|(at, held)| (!held).then_some(at))
    }

    /// The indices of the equalities among all rows.
    fn held(&self) -> impl Iterator<Item = usize> {
        let held = self.rows.iter().flat_map(|rows| &rows.equalities);
        self.range().zip(held).filter_map(|(at, held)| held.then_some(at))
    }

    /// The equalities.
    pub fn equalities(&self) -> impl Iterator<Item = Equality> {
        self.held().map(|at| Equality::new(Row::new(at, 1.0)))
    }

    /// The values of the rows with their margins.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        let values = self.rows.iter().flat_map(|rows| &rows.h);
        values.zip(&self.margins).map(|(h, margin)| h + margin)
    }

    /// The value of the row of this index among all, without its margin.
    pub fn value(&self, at: usize) -> f64 {
        let after = self.rows.partition_point(|rows| rows.first <= at);
        let rows = &self.rows[after - 1];
        rows.h[at - rows.first]
    }

    /// The margin of the row of this index among all.
    pub fn margin_mut(&mut self, at: usize) -> &mut f64 {
        &mut self.margins[at - self.first]
    }

    /// Sets the margins of inequalities against rounding.
    pub fn reserve(&mut self, reserve: f64) {
        let held = self.rows.iter().flat_map(|rows| &rows.equalities);
        for (margin, _) in self.margins.iter_mut().zip(held).filter(|(_, held)| !**held) {
            *margin = reserve;
        }
    }

    /// The largest violation, in its unit.
    pub fn violation(&self) -> f64 {
        self.rows.iter().map(PointRows::violation).fold(0.0, f64::max)
    }

    /// The place of the rows on a curve: at their own time, that of a waypoint, or the end for a goal.
    fn place(&self, point: usize, unknowns: &Unknowns, coefficients: &DMatrix<f64>) -> Place {
        let rows = &self.rows[point];
        let of_motion = |time: f64| (time / unknowns.horizons.whole()).min(1.0);
        let time = rows.time.or(rows.time_s.map(of_motion));
        let time = time.or(unknowns.times.get(point).copied());
        Place::new(&unknowns.basis, coefficients, time.unwrap_or(1.0), &unknowns.horizons)
    }

    /// Evaluates all rows.
    pub fn evaluate(&mut self, unknowns: &Unknowns) -> Result<()> {
        for point in 0..self.rows.len() {
            let place = self.place(point, unknowns, &unknowns.coefficients);
            self.rows[point].evaluate(&place)?;
        }
        Ok(())
    }

    /// The places of all points, with the derivatives of their weighted rows.
    fn derivatives(&mut self, unknowns: &Unknowns, iterate: &Iterate) -> Result<Vec<(Place, PointDerivatives)>> {
        self.evaluate(unknowns)?;
        let mut all = Vec::new();
        for point in 0..self.rows.len() {
            let own = self.rows[point].range();
            let value = |at: usize| self.rows[point].h[at - own.start] + self.margins[at - self.first];
            let held = iterate.equalities.iter().filter(|of| own.contains(&of.row.at));
            let held = held.map(|of| (of.row, of.term(value(of.row.at))));
            let near = iterate.working.iter().filter(|of| own.contains(&of.row.at));
            let near = near.map(|of| (of.row, iterate.term(of, value(of.row.at))));
            let terms = held.chain(near);
            let terms: Vec<_> = terms.map(|(row, term)| (row.at, term.times(row.weight))).collect();
            let place = self.place(point, unknowns, &unknowns.coefficients);
            let of = self.rows[point].derivatives(terms.into_iter())?;
            all.push((place, of));
        }
        Ok(all)
    }

    /// Adds the derivatives of the weighted rows to gradient and condensed matrix.
    pub fn add_derivatives(&mut self, unknowns: &Unknowns, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        let (grid, measure) = (&unknowns.grid, self.measure);
        for (point, (place, of)) in self.derivatives(unknowns, iterate)?.into_iter().enumerate() {
            place.add_hessian(grid, &of, measure, &mut out.hessian.matrix);
            place.scatter(grid, &of.gradient, 0, measure, out.gradient.as_mut_slice());
            self.add_border(point, unknowns, (&place, &of), out);
        }
        Ok(())
    }

    /// Adds the second derivatives in the coefficients alone, with the current horizon as the factor of the weights.
    pub fn add_hessian(
        &mut self,
        unknowns: &Unknowns,
        iterate: &Iterate,
        out: &mut BlockTridiagonal<f64>,
    ) -> Result<()> {
        for (place, of) in self.derivatives(unknowns, iterate)? {
            place.add_hessian(&unknowns.grid, &of, unknowns.horizons.whole(), out);
        }
        Ok(())
    }

    /// The derivatives of a place in the horizon, through the coefficients and the slopes that depend on it.
    fn rates(&self, point: usize, unknowns: &Unknowns, place: &Place) -> DMatrix<f64> {
        match &place.in_part {
            None => self.place(point, unknowns, &unknowns.rates[0]).q,
            Some(in_part) => {
                let first = unknowns.grid.first(place.segment);
                let own = unknowns.coefficients.columns(first, in_part.ncols());
                own * in_part.transpose()
            }
        }
    }

    /// The unknowns of the border on which the rows of a point depend, the horizon and the time of a waypoint, with the
    /// derivatives of configuration and slope in them.
    fn moving(&self, point: usize, unknowns: &Unknowns, place: &Place, rates: &DMatrix<f64>) -> [Option<Moving>; 2] {
        let part = unknowns.horizons.part(place.segment, unknowns.grid.segments);
        let mut parts = unknowns.free.parts.iter();
        let horizon = parts.position(|(of, _)| *of == part);
        let by_horizon = || match self.rows[point].time_s {
            Some(time) => InHorizon::new(place, rates, time).first,
            None => pair(rates, 0),
        };
        let in_time = unknowns.unknown_time(point).map(|k| (k, pair(&place.q, 1)));
        [horizon.map(|k| (k, by_horizon())), in_time]
    }

    /// Calls a function for each equality, in the order of their rows, with its segment and its gradient in all unknown
    /// coefficients and the border.
    pub fn equality_gradients(
        &mut self,
        unknowns: &Unknowns,
        each: &mut dyn FnMut(usize, &DVector<f64>),
    ) -> Result<()> {
        if self.held().next().is_none() {
            return Ok(());
        }
        let grid = &unknowns.grid;
        let own = grid.free.len() * unknowns.coefficients.nrows();
        let mut gradient = DVector::zeros(own + unknowns.border());
        for point in 0..self.rows.len() {
            let place = self.place(point, unknowns, &unknowns.coefficients);
            let rates = self.rates(point, unknowns, &place);
            let own_rows = self.rows[point].range();
            let held: Vec<_> = self.held().filter(|row| own_rows.contains(row)).collect();
            for row in held {
                let of = self.rows[point].gradient(row)?;
                gradient.fill(0.0);
                place.scatter(grid, &of, 0, 1.0, gradient.as_mut_slice());
                for (k, by) in self.moving(point, unknowns, &place, &rates).iter().flatten() {
                    gradient[own + k] = of.dot(by);
                }
                each(place.segment, &gradient);
            }
        }
        Ok(())
    }

    /// Adds the derivatives of the rows of a point in the unknowns of the border.
    ///
    /// The configuration $q = \sum_m \phi_m(\tau) c_m$ and its slope are bilinear in functions and coefficients: their
    /// second derivatives in a coefficient and the time are $\phi_m'$ and $\phi_m''$. The horizon moves the coefficients
    /// of the boundary velocities, with its square those of given accelerations; that of a part moves its slopes.
    fn add_border(&self, point: usize, unknowns: &Unknowns, (place, of): (&Place, &PointDerivatives), out: &mut Kkt) {
        let (grid, measure) = (&unknowns.grid, self.measure);
        let own = out.gradient.len() - unknowns.border();
        let rates = self.rates(point, unknowns, place);
        let at_time = self.rows[point].time_s.map(|time| InHorizon::new(place, &rates, time));
        let [in_horizon, in_time] = self.moving(point, unknowns, place, &rates);
        let Kkt { gradient, hessian, .. } = out;
        for (k, by) in in_horizon.iter().chain(&in_time) {
            gradient[own + k] += measure * of.gradient.dot(by);
            let bent = &of.hessian * by;
            let mut column = hessian.border.column_mut(*k);
            place.scatter(grid, &bent, 0, measure, column.as_mut_slice());
            for (j, by) in in_horizon.iter().chain(&in_time) {
                hessian.corner[(*k, *j)] += measure * bent.dot(by);
            }
        }
        if let Some((k, _)) = &in_time {
            let k = *k;
            let mut column = hessian.border.column_mut(k);
            place.scatter(grid, &of.of_multipliers, 1, measure, column.as_mut_slice());
            hessian.corner[(k, k)] += measure * of.of_multipliers.dot(&pair(&place.q, 2));
        }
        if let Some((k, _)) = in_horizon {
            if let Some(at) = &at_time {
                let mut column = hessian.border.column_mut(k);
                let column = column.as_mut_slice();
                hessian.corner[(k, k)] += at.add_second((place, grid), &of.of_multipliers, measure, column);
            }
            if unknowns.horizons.reference().is_none() {
                let second = self.place(point, unknowns, &unknowns.rates[1]).q;
                hessian.corner[(k, k)] += measure * of.of_multipliers.dot(&pair(&second, 0));
            }
            if let Some(in_part) = &place.in_part {
                let mut column = hessian.border.column_mut(k);
                place.scatter_functions(grid, (in_part, 0), &of.of_multipliers, measure, column.as_mut_slice());
            }
            if let Some((j, _)) = in_time {
                let late = pair(&rates, 1);
                let both = measure * of.of_multipliers.dot(&late);
                hessian.corner[(k, j)] += both;
                hessian.corner[(j, k)] += both;
            }
        }
    }
}
