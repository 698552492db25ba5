//! The running cost plus the barriers of the rows.

use super::barrier::{Barrier, Term};
use super::equality::Equalities;
use super::near::Near;
use super::row::{Kind, kinds};
use super::terms::Terms;
use super::trial::Trial;
use crate::constraint::{Constraint, Constraints, Side, Weights};
use crate::error::Result;
use crate::model::Model;
use crate::relax::transcription::{Attributes, Grid, Rows, alone};
use crate::relax::tuning::RESERVE;
use crate::relax::{
    ControlDerivatives, ControlEffort, CostWithControl, Point, PointCost, PointDerivatives, Points,
    PointsDerivatives,
};
use crate::scalar::{LANES, Wide};
use std::ops::Range;

/// The running cost $l_0$ and the [`Barrier`] of each row at each point,
///
/// $$ l = l_0 + \sum_j \psi(h_j + m_j) . $$
///
/// A row $h_j$ is a row of the constraints divided by its [scale](Constraint::row_scales), or the excess of a torque
/// over its limit divided by the limit. The margin $m_j \ge 0$ is the amount by which the row is larger near a point
/// than at it. Multipliers $z_j$ belong to a point, so that the integral over time turns them into densities, which do
/// not depend on the number of points.
///
/// The barrier of a clearance fades out at the distance `F`: with $x = -h / F$, the term
/// $\mu ((x - 1) - \tfrac12 (x - 1)^2)$ is added for $0 \le x \le 1$, its tangent at $x = 0$ for $x < 0$, and the
/// barrier is constant for $x \ge 1$.
///
/// The gradient is that of `l`. Rows relaxed by $r$ add the push $\sum_j c_j r_j \nabla h_j$, which removes the
/// relaxation. The Hessian is the primal-dual one: $z$ replaces $\psi'$ as the weight of the second derivatives of the
/// rows, and $c_j = 1 / (s_j / z_j + t_j / (\nu - z_j))$ replaces $\psi''$ as the weight of the products of their
/// gradients, with $s$ and $t$ of [`Barrier`].
#[derive(Clone, Debug)]
pub struct BarrierCost<'a, K, P = ControlEffort<'a, f64, f64>> {
    pub(in crate::relax) rows: Rows<'a, K, P>,
    /// The barrier of all rows.
    pub barrier: Barrier,
    /// The duals of equalities.
    pub equalities: Equalities,
    /// The multipliers $z$, row by row for each point.
    pub multipliers: Vec<f64>,
    /// The margins $m$, in the same order.
    pub margins: Vec<f64>,
    /// The relaxations $r$, in the same order.
    pub relaxations: Vec<f64>,
    pub(super) trial: Trial,
    /// True during a trial of a step.
    pub(super) trying: bool,
    /// The kind of each row at each point.
    pub(super) kinds: Vec<Kind>,
    /// The rows with their margins at the last evaluation.
    pub(in crate::relax) h: Vec<f64>,
    /// The rows at each point whose term is not constant.
    pub(super) near: Near,
    /// The integral of $l_0$ at the last evaluation.
    pub(in crate::relax) cost: f64,
    /// Weights of the points of a segment.
    pub(super) weights: Vec<f64>,
    /// Weights of the gradients, of their products and of the second derivatives of the rows of the state, side by
    /// side; zero except during use.
    slopes: Vec<Wide<f64>>,
    curvatures: Vec<Wide<f64>>,
    weighted: Vec<Wide<f64>>,
}

impl<'a, K: Constraint> BarrierCost<'a, K> {
    /// The control effort with barriers at a single point.
    ///
    /// # Errors
    /// The torque limits are not one per joint, or one is negative or not finite.
    pub fn at_a_point(
        model: &'a Model,
        constraints: &'a Constraints<K>,
        barrier: Barrier,
    ) -> Result<Self> {
        let rows = Rows::new(model, constraints, ControlEffort::new(model))?;
        let kinds = rows
            .of()
            .equalities
            .iter()
            .map(|row| Kind::of(*row))
            .collect();
        Ok(Self::of(rows, barrier, kinds, vec![1.0]))
    }
}

impl<'a, K: Constraint, P: CostWithControl> BarrierCost<'a, K, P> {
    /// The cost of these rows on a grid, with the multipliers of zero rows.
    pub(super) fn new(rows: Rows<'a, K, P>, barrier: Barrier, grid: &Grid<f64>) -> Self {
        let weights = grid.weights.clone();
        let kinds = kinds(&rows.of().equalities, &grid.collocated, grid.segments);
        Self::of(rows, barrier, kinds, weights)
    }

    fn of(rows: Rows<'a, K, P>, barrier: Barrier, kinds: Vec<Kind>, weights: Vec<f64>) -> Self {
        let zeros = vec![Wide::splat(0.0); rows.constraints.state.dim()];
        let all = vec![0.0; kinds.len()];
        let of_kind = |kind: &Kind| {
            if *kind == Kind::Inequality {
                RESERVE
            } else {
                0.0
            }
        };
        let margins = kinds.iter().map(of_kind).collect();
        let count = rows.count();
        let passive = rows.ids.iter().map(|row| rows.constraints.is_passive(*row));
        let points = kinds.len() / count.max(1);
        Self {
            equalities: Equalities::new(passive.collect(), points),
            near: Near::new(count, points),
            rows,
            barrier,
            multipliers: all.clone(),
            margins,
            kinds,
            relaxations: all.clone(),
            trial: Trial::default(),
            trying: false,
            h: all,
            cost: 0.0,
            weights,
            slopes: zeros.clone(),
            curvatures: zeros.clone(),
            weighted: zeros,
        }
    }

    /// The largest equality at a collocated point, in its unit.
    pub(super) fn largest_equality(&self) -> f64 {
        let count = self.rows.count();
        let rows = self.h.iter().zip(&self.kinds).enumerate();
        let held = rows.filter(|(_, (_, kind))| **kind == Kind::Equality);
        held.fold(0.0, |most, (at, (h, _))| {
            most.max(h.abs() * self.rows.of().units[at % count])
        })
    }

    /// The largest relaxation.
    pub(super) fn largest_relaxation(&self) -> f64 {
        self.relaxations.iter().copied().fold(0.0, f64::max)
    }

    /// Resets the multipliers to $\psi'$ of the rows.
    pub(super) fn reset_multipliers(&mut self) {
        self.multipliers.fill(0.0);
        for (at, row) in self.near.places() {
            self.multipliers[at] = self.multiplier(at, row);
        }
    }

    /// $\psi'$ of a row.
    pub(super) fn multiplier(&self, at: usize, row: usize) -> f64 {
        let term = self.terms().at(at, row, self.h[at]);
        term.map_or(0.0, |term| term.multiplier())
    }

    /// Changes the barrier; the multipliers change as little as possible.
    pub(super) fn set_barrier(&mut self, barrier: Barrier) {
        self.barrier = barrier;
        for (at, row) in self.near.places() {
            let (z, term) = (self.multipliers[at], self.terms().at(at, row, self.h[at]));
            self.multipliers[at] = term.map_or(0.0, |term| term.safeguarded(z));
        }
    }

    /// Updates the duals of the equalities; see [`Equalities::update`].
    pub(super) fn update_duals(&mut self, feasible: f64, density: f64) {
        let (h, kinds, units) = (&self.h, &self.kinds, &self.rows.of().units);
        self.equalities.update(h, kinds, units, (feasible, density));
        self.set_barrier(self.barrier);
    }

    /// The mean number of rows with a term per point, at least one.
    pub(super) fn mean_count(&self) -> f64 {
        (self.near.places().count() as f64 / self.near.points().max(1) as f64).max(1.0)
    }

    /// The builder of the row terms.
    pub(super) fn terms(&self) -> Terms<'_> {
        Terms {
            barrier: self.barrier,
            equalities: &self.equalities,
            kinds: &self.kinds,
            floors: &self.rows.of().floors,
        }
    }

    /// The positions of the rows at `points`. The first point resets the largest values of the unlisted rows.
    fn begin_points(&mut self, points: Points<'_, f64>) -> Range<usize> {
        if points.first == 0 {
            self.rows.unlisted_highest = f64::NEG_INFINITY;
        }
        let count = self.rows.count();
        points.first * count..(points.first + points.count()) * count
    }

    /// Adds the barriers of the rows at `points` to the running cost, and sums both.
    fn add_barriers(&mut self, points: Points<'_, f64>, costs: &mut [f64]) {
        if points.first == 0 {
            self.cost = 0.0;
        }
        let (count, barrier) = (self.rows.count(), self.barrier);
        let faded = self.terms().faded();
        for (g, cost) in costs.iter_mut().enumerate() {
            let (point, weight) = (points.first + g, self.weights[g]);
            self.cost += weight * *cost;
            if count == 0 {
                continue;
            }
            let own = point * count..(point + 1) * count;
            for (h, margin) in self.h[own.clone()]
                .iter_mut()
                .zip(&self.margins[own.clone()])
            {
                *h += margin;
            }
            if self.trying {
                self.trial.relaxations[own.clone()].fill(0.0);
            }
            self.list_near(point);
            let mut product = 1.0_f64;
            for row in self.near.at(point) {
                let at = own.start + row;
                if self.kinds[at] == Kind::Inequality {
                    self.h[at] = if self.trying {
                        let h = self.trial.row(at, self.h[at]);
                        self.trial.price += weight * barrier.nu * self.trial.relaxations[at];
                        h
                    } else {
                        self.h[at] - self.relaxations[at]
                    };
                }
                let Some(term) = self.terms().at(at, *row, self.h[at]) else {
                    continue;
                };
                let (value, of_logarithm) = term.value();
                *cost += value;
                if let Term::Fading(..) = term {
                    // So that it has faded to nothing.
                    *cost -= faded;
                }
                product *= of_logarithm;
                // Long before it could leave the range of numbers.
                if !(1e-150..1e150).contains(&product) {
                    *cost -= barrier.mu * product.ln();
                    product = 1.0;
                }
            }
            *cost -= barrier.mu * product.ln();
        }
    }
}

impl<K: Constraint, P: CostWithControl> PointCost<f64> for BarrierCost<'_, K, P> {
    fn value(&mut self, point: Point<'_, f64>) -> Result<f64> {
        let states = point.states();
        let mut cost = [0.0];
        self.values(point.points(&states), &mut cost)?;
        Ok(cost[0])
    }

    fn time_rate(&mut self, point: Point<'_, f64>) -> Result<f64> {
        self.rows.cost.time_rate(point)
    }

    fn values(&mut self, points: Points<'_, f64>, costs: &mut [f64]) -> Result<()> {
        let own = self.begin_points(points);
        self.rows.at(points, &mut self.h[own], costs)?;
        self.add_barriers(points, costs);
        if self.rows.unlisted_highest > 0.0 {
            // A step into something that was too far away to be listed.
            costs.fill(f64::INFINITY);
        }
        Ok(())
    }

    fn derivatives(
        &mut self,
        point: Point<'_, f64>,
        out: &mut PointDerivatives<f64>,
    ) -> Result<f64> {
        alone(point, out, |points, all| self.all_derivatives(points, all))
    }

    fn all_derivatives(
        &mut self,
        points: Points<'_, f64>,
        out: &mut PointsDerivatives<f64>,
    ) -> Result<()> {
        let Constraints { torque, .. } = self.rows.constraints;
        let (states, count) = (self.rows.states, self.rows.count());
        let (multipliers, relaxations) = (&self.multipliers, &self.relaxations);
        let (rows, margins) = (&mut self.h, &self.margins);
        let (cost, Attributes { scales, floors, .. }) = self.rows.cost_and_attributes();
        let terms = Terms {
            barrier: self.barrier,
            equalities: &self.equalities,
            kinds: &self.kinds,
            floors,
        };
        let mut add = |index: usize, u: &[f64], out: &mut ControlDerivatives<f64>| {
            let own = index * count + states..;
            for (at, ((i, limit, side), scale)) in own.zip(torque.rows().zip(&scales[states..])) {
                let slope = if side == Some(Side::Lower) {
                    -scale
                } else {
                    *scale
                };
                rows[at] = slope * u[i] - scale * limit;
                let (r, z) = (relaxations[at], multipliers[at]);
                let h = rows[at] + margins[at] - r;
                if let Some(term) = terms.at(at, at % count, h) {
                    let c = term.curvature(z);
                    out.gradient[i] += slope * (term.slope() + c * r);
                    out.curvature_weights[i] += slope * z;
                    out.hessian[i] += slope * slope * c;
                }
            }
            torque.dim() > 0
        };
        cost.all_derivatives_with(points, out, &mut add)?;
        let own = self.begin_points(points);
        self.rows.of_state(points, &mut self.h[own])?;
        self.add_barriers(points, &mut out.costs);
        if !self.slopes.is_empty() {
            for start in (0..points.count()).step_by(LANES) {
                self.add_state(points, start, out)?;
            }
        }
        Ok(())
    }
}

impl<K: Constraint, P: CostWithControl> BarrierCost<'_, K, P> {
    /// Adds the derivatives of the barriers of the state rows at the points from `start` on, side by side.
    fn add_state(
        &mut self,
        points: Points<'_, f64>,
        start: usize,
        out: &mut PointsDerivatives<f64>,
    ) -> Result<()> {
        let n = points.states.nrows();
        let found = LANES.min(points.count() - start);
        let (states, count) = (self.rows.states, self.rows.count());
        // Where there are fewer points than lanes the last one is in those that are left.
        let point = |lane: usize| points.first + start + lane.min(found - 1);
        for lane in 0..LANES {
            for row in self.near.of_state(point(lane), states) {
                let at = point(lane) * count + row;
                if let Some(term) = self.terms().at(at, row, self.h[at]) {
                    let (scale, z) = (self.rows.of().scales[row], self.multipliers[at]);
                    let (id, weight) = (self.rows.ids[row], term.weight(z));
                    let c = term.curvature(z);
                    let push = c * self.relaxations[at];
                    self.slopes[id].0[lane] = (term.slope() + push) * scale;
                    self.curvatures[id].0[lane] = c * scale * scale;
                    self.weighted[id].0[lane] = weight * scale;
                }
            }
        }
        let gradient = Weights {
            first_order: &self.slopes,
            gauss_newton: None,
        };
        let pull = self.rows.weighted_derivatives(points, start, gradient)?;
        for (i, slope) in pull.gradient().iter().enumerate() {
            for lane in 0..found {
                out.gradients[(i % n, 3 * (start + lane) + i / n)] += slope.0[lane];
            }
        }
        let hessian = Weights {
            first_order: &self.weighted,
            gauss_newton: Some(&self.curvatures),
        };
        let pull = self.rows.weighted_derivatives(points, start, hessian)?;
        out.hessians.add_wide(start, pull.hessian());
        for lane in 0..LANES {
            for row in self.near.of_state(point(lane), states) {
                for weights in [&mut self.slopes, &mut self.curvatures, &mut self.weighted] {
                    weights[self.rows.ids[row]].0[lane] = 0.0;
                }
            }
        }
        Ok(())
    }
}
