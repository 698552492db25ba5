//! The running cost with the barriers of the rows.

use super::barrier::{Barrier, Term};
use super::equality::Equalities;
use super::row::{Kind, Trial, kinds};
use crate::constraint::{Constraint, Constraints, Side, Weights};
use crate::error::Result;
use crate::model::Model;
use crate::relax::transcription::{Grid, LANES, Rows, Wide, alone};
use crate::relax::tuning::{FAR, RESERVE, TO_THE_WALL};
use crate::relax::{
    ControlDerivatives, ControlEffort, CostWithControl, Point, PointCost, PointDerivatives, Points,
    PointsDerivatives,
};

/// The running cost $l_0$ and the [`Barrier`] of each row at each point,
///
/// $$ l = l_0 + \sum_j \psi(h_j + m_j) . $$
///
/// A row $h_j$ is a row of the constraints divided by its [scale](Constraint::row_scales), or a torque above its limit divided by the
/// limit. The margins $m_j \ge 0$ say how much more a row is near a point than at it. Multipliers $z_j$ belong to a point, so that the
/// integral over time makes densities of them, which do not depend on the number of points.
///
/// The gradient is that of `l`, and where rows are relaxed by $r$ it has the push $\sum_j c_j r_j \nabla h_j$ besides, which takes that back. The
/// Hessian is the primal-dual one: $z$ weighs the second derivatives of the rows in place of $\psi'$, and
/// $c_j = 1 / (s_j / z_j + t_j / (\nu - z_j))$ the products of their gradients in place of $\psi''$, with $s$ and $t$ of [`Barrier`].
#[derive(Clone, Debug)]
pub struct BarrierCost<'a, K, P = ControlEffort<'a, f64, f64>> {
    pub(in crate::relax) rows: Rows<'a, K, P>,
    /// The barrier of all rows.
    pub barrier: Barrier,
    /// The duals of equalities.
    pub equalities: Equalities,
    /// $z$, row by row for each point.
    pub multipliers: Vec<f64>,
    /// $m$, likewise.
    pub margins: Vec<f64>,
    /// $r$, likewise: by how much a row is relaxed.
    pub relaxations: Vec<f64>,
    trial: Trial,
    /// True while a step is being tried.
    trying: bool,
    /// The kind of each row at each point.
    pub(super) kinds: Vec<Kind>,
    /// The rows with their margins where the cost was evaluated last.
    pub(in crate::relax) h: Vec<f64>,
    /// The integral of $l_0$ there.
    pub(in crate::relax) cost: f64,
    /// Weights of the points of a segment.
    weights: Vec<f64>,
    /// Weights of the gradients, of their products and of the second derivatives of the rows of the state, side by side.
    slopes: Vec<Wide<f64>>,
    curvatures: Vec<Wide<f64>>,
    weighted: Vec<Wide<f64>>,
}

impl<'a, K: Constraint> BarrierCost<'a, K> {
    /// That of the control effort at a single point.
    ///
    /// # Errors
    /// The torque limits are those of another robot.
    pub fn at_a_point(
        model: &'a Model,
        constraints: &'a Constraints<K>,
        barrier: Barrier,
    ) -> Result<Self> {
        let rows = Rows::new(model, constraints, ControlEffort::new(model))?;
        let kinds = rows.equalities.iter().map(|row| Kind::of(*row)).collect();
        Ok(Self::of(rows, barrier, kinds, vec![1.0]))
    }
}

impl<'a, K: Constraint, P: CostWithControl> BarrierCost<'a, K, P> {
    /// That of rows on a grid, with the multipliers of the barrier of nothing.
    pub(super) fn new(rows: Rows<'a, K, P>, barrier: Barrier, grid: &Grid<f64>) -> Self {
        let weights = grid.weights.clone();
        let kinds = kinds(&rows.equalities, &grid.collocated, grid.segments);
        Self::of(rows, barrier, kinds, weights)
    }

    fn of(rows: Rows<'a, K, P>, barrier: Barrier, kinds: Vec<Kind>, weights: Vec<f64>) -> Self {
        let zeros = vec![Wide::splat(0.0); rows.count()];
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
        let passive = (0..count).map(|row| rows.constraints.is_passive(row));
        Self {
            equalities: Equalities::new(passive.collect(), kinds.len() / count.max(1)),
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

    /// Begins to try a step: the rows are those before it.
    pub(super) fn begin(&mut self) {
        let trial = &mut self.trial;
        trial.before.clone_from(&self.h);
        trial.whole.clear();
        trial.whole.resize(self.h.len(), f64::INFINITY);
        trial.relaxations.clone_from(&self.relaxations);
        self.trying = true;
        self.try_share(1.0);
    }

    /// After the cost was evaluated at the end of the whole step: the share of it that leaves every row inside that was
    /// inside before.
    pub(super) fn end_of_whole(&mut self) -> f64 {
        let mut share = 1.0_f64;
        self.trial.whole.clone_from(&self.h);
        for ((h, before), kind) in self.h.iter().zip(&self.trial.before).zip(&self.kinds) {
            if *kind == Kind::Inequality && *before < 0.0 && *h > (1.0 - TO_THE_WALL) * before {
                share = share.min(TO_THE_WALL * before / (before - h));
            }
        }
        share
    }

    /// Tries a share of the step.
    pub(super) fn try_share(&mut self, share: f64) {
        (self.trial.share, self.trial.price) = (share, 0.0);
    }

    /// The price of the relaxations of the trial.
    pub(super) fn trial_price(&self) -> f64 {
        self.trial.price
    }

    /// Takes the trial for the iterate, with the multipliers that the whole of the step predicts as far as the rows where it ended
    /// allow.
    pub(super) fn accept(&mut self) {
        for (at, row) in self.places() {
            let (before, whole) = (self.trial.before[at], self.trial.whole[at]);
            self.multipliers[at] =
                match (self.term(at, row, before), self.term(at, row, self.h[at])) {
                    (Some(from), Some(to)) => {
                        let curvature = from.curvature(self.multipliers[at]);
                        to.safeguarded(from.multiplier() + curvature * (whole - before))
                    }
                    (None, Some(to)) => to.multiplier(),
                    (_, None) => 0.0,
                };
        }
        let trial = &self.trial;
        self.relaxations.copy_from_slice(&trial.relaxations);
        self.trying = false;
    }

    /// Gives the trial up.
    pub(super) fn reject(&mut self) {
        self.trying = false;
    }

    /// The largest equality where it is asked for, in its unit.
    pub(super) fn largest_equality(&self) -> f64 {
        let count = self.rows.count();
        let rows = self.h.iter().zip(&self.kinds).enumerate();
        let held = rows.filter(|(_, (_, kind))| **kind == Kind::Equality);
        held.fold(0.0, |most, (at, (h, _))| {
            most.max(h.abs() * self.rows.units[at % count])
        })
    }

    /// The largest relaxation.
    pub(super) fn largest_relaxation(&self) -> f64 {
        self.relaxations.iter().copied().fold(0.0, f64::max)
    }

    /// The price of the relaxations, the part of it that the barriers get back, and the work of the push along the step that is tried.
    pub(super) fn price_of_relaxations(&self) -> [f64; 3] {
        let (count, trial, mut sums) = (self.rows.count(), &self.trial, [0.0; 3]);
        for (at, row) in self.places() {
            let r = &self.relaxations[at];
            if *r > 0.0 {
                let w = self.weights[at / count % self.weights.len()];
                let before = trial.before[at];
                let Some(term) = self.term(at, row, before) else {
                    continue;
                };
                // What the row itself changed by.
                let change = trial.whole[at] - before - r;
                sums[0] += w * self.barrier.nu * r;
                sums[1] += w * term.multiplier() * r;
                sums[2] += w * term.curvature(self.multipliers[at]) * r * change;
            }
        }
        sums
    }

    /// Takes the multipliers that the rows ask for.
    pub(super) fn reset_multipliers(&mut self) {
        for (at, row) in self.places() {
            let term = self.term(at, row, self.h[at]);
            self.multipliers[at] = term.map_or(0.0, |term| term.multiplier());
        }
    }

    /// Changes the barrier; multipliers stay as near as they may.
    pub(super) fn set_barrier(&mut self, barrier: Barrier) {
        self.barrier = barrier;
        for (at, row) in self.places() {
            let (z, term) = (self.multipliers[at], self.term(at, row, self.h[at]));
            self.multipliers[at] = term.map_or(0.0, |term| term.safeguarded(z));
        }
    }

    /// Takes the duals that the equalities ask for; see [`Equalities::update`].
    pub(super) fn update_duals(&mut self, feasible: f64, density: f64) {
        let (h, kinds, units) = (&self.h, &self.kinds, &self.rows.units);
        self.equalities.update(h, kinds, units, (feasible, density));
        self.set_barrier(self.barrier);
    }

    /// The places of all rows at all points, each with the number of its row.
    fn places(&self) -> impl Iterator<Item = (usize, usize)> + use<K, P> {
        let count = self.rows.count();
        (0..self.h.len() / count.max(1))
            .flat_map(move |g| (0..count).map(move |row| (g * count + row, row)))
    }

    /// The term of row `row` at `at` for the value `h`; nothing where none is asked for, or it is constant.
    #[inline]
    fn term(&self, at: usize, row: usize, h: f64) -> Option<Term> {
        if h < self.rows.floors[row] {
            return None;
        }
        term(self.barrier, &self.equalities, self.kinds[at], at, h)
    }

    /// The barrier of a row where it is constant.
    fn far_value(&self) -> f64 {
        let (value, of_logarithm) = Term::Barrier(self.barrier.split(-FAR)).value();
        value - self.barrier.mu * of_logarithm.ln()
    }

    /// Adds up the running cost, and the barriers of the rows at `points` to it.
    fn add_barriers(&mut self, points: Points<'_, f64>, costs: &mut [f64]) {
        if points.first == 0 {
            self.cost = 0.0;
        }
        let (count, far_value) = (self.rows.count(), self.far_value());
        for (g, cost) in costs.iter_mut().enumerate() {
            self.cost += self.weights[g] * *cost;
            let first = (points.first + g) * count;
            let (barrier, mut product, mut far) = (self.barrier, 1.0_f64, 0);
            for row in 0..count {
                let at = first + row;
                let raw = self.h[at] + self.margins[at];
                if raw < self.rows.floors[row] {
                    self.h[at] = raw;
                    far += usize::from(self.kinds[at] == Kind::Inequality);
                    if self.trying {
                        self.trial.relaxations[at] = 0.0;
                    }
                    continue;
                }
                let h = if self.kinds[at] != Kind::Inequality {
                    raw
                } else if self.trying {
                    let h = self.trial.row(at, raw);
                    self.trial.price += self.weights[g] * barrier.nu * self.trial.relaxations[at];
                    h
                } else {
                    raw - self.relaxations[at]
                };
                self.h[at] = h;
                if h < self.rows.floors[row] {
                    far += 1;
                } else if let Some(term) = self.term(at, row, h) {
                    let (value, of_logarithm) = term.value();
                    *cost += value;
                    product *= of_logarithm;
                    // Long before it could leave the range of numbers.
                    if !(1e-150..1e150).contains(&product) {
                        *cost -= barrier.mu * product.ln();
                        product = 1.0;
                    }
                }
            }
            *cost += far as f64 * far_value - barrier.mu * product.ln();
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
        let count = self.rows.count();
        let own = points.first * count..(points.first + points.count()) * count;
        self.rows.at(points, &mut self.h[own], costs)?;
        self.add_barriers(points, costs);
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
        let Constraints { state, torque } = self.rows.constraints;
        let (states, count, barrier) = (state.dim(), self.rows.count(), self.barrier);
        let (multipliers, relaxations) = (&self.multipliers, &self.relaxations);
        let (rows, margins, kinds) = (&mut self.h, &self.margins, &self.kinds);
        let equalities = &self.equalities;
        let Rows { cost, scales, .. } = &mut self.rows;
        let mut add = |index: usize, u: &[f64], out: &mut ControlDerivatives<f64>| {
            let own = index * count + states..;
            for (at, ((i, limit, side), scale)) in own.zip(torque.rows().zip(&scales[states..])) {
                let slope = if side == Some(Side::Lower) {
                    -scale
                } else {
                    *scale
                };
                rows[at] = slope * u[i] - scale * limit;
                let (r, z, kind) = (relaxations[at], multipliers[at], kinds[at]);
                let h = rows[at] + margins[at] - r;
                if let Some(term) = term(barrier, equalities, kind, at, h) {
                    let c = term.curvature(z);
                    out.gradient[i] += slope * (term.multiplier() + c * r);
                    out.curvature_weights[i] += slope * z;
                    out.hessian[i] += slope * slope * c;
                }
            }
            torque.dim() > 0
        };
        cost.all_derivatives_with(points, out, &mut add)?;
        let own = points.first * count..(points.first + points.count()) * count;
        self.rows.of_state(points, &mut self.h[own])?;
        self.add_barriers(points, &mut out.costs);
        if states > 0 {
            for start in (0..points.count()).step_by(LANES) {
                self.add_state(points, start, out)?;
            }
        }
        Ok(())
    }
}

impl<K: Constraint, P: CostWithControl> BarrierCost<'_, K, P> {
    /// Adds the derivatives that the barriers of the rows of the state have at the points from `start` on, side by side.
    fn add_state(
        &mut self,
        points: Points<'_, f64>,
        start: usize,
        out: &mut PointsDerivatives<f64>,
    ) -> Result<()> {
        let n = points.states.nrows();
        let found = LANES.min(points.count() - start);
        let (states, count) = (self.rows.constraints.state.dim(), self.rows.count());
        for j in 0..states {
            let scale = self.rows.scales[j];
            for lane in 0..LANES {
                let at = (points.first + start + lane.min(found - 1)) * count + j;
                let z = self.multipliers[at];
                let term = self.term(at, j, self.h[at]);
                let (multiplier, c, z) = term.map_or((0.0, 0.0, 0.0), |term| {
                    (term.multiplier(), term.curvature(z), z)
                });
                let push = c * self.relaxations[at];
                self.slopes[j].0[lane] = (multiplier + push) * scale;
                self.curvatures[j].0[lane] = c * scale * scale;
                self.weighted[j].0[lane] = z * scale;
            }
        }
        let gradient = Weights {
            first_order: &self.slopes[..states],
            gauss_newton: None,
        };
        let pull = self.rows.weighted_derivatives(points, start, gradient)?;
        for (i, slope) in pull.gradient().iter().enumerate() {
            for lane in 0..found {
                out.gradients[(i % n, 3 * (start + lane) + i / n)] += slope.0[lane];
            }
        }
        let hessian = Weights {
            first_order: &self.weighted[..states],
            gauss_newton: Some(&self.curvatures[..states]),
        };
        let pull = self.rows.weighted_derivatives(points, start, hessian)?;
        out.hessians.add_wide(start, pull.hessian());
        Ok(())
    }
}

/// The term of row `at`, which is of a kind, for the value `h`.
fn term(barrier: Barrier, equalities: &Equalities, kind: Kind, at: usize, h: f64) -> Option<Term> {
    match kind {
        Kind::Inequality => Some(Term::Barrier(barrier.split(h))),
        Kind::Equality => Some(equalities.term(at, h)),
        Kind::Idle => None,
    }
}
