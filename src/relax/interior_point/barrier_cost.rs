//! The running cost with the barriers of the rows.

use super::barrier::Barrier;
use crate::constraint::{Constraint, Constraints, Side, Weights};
use crate::error::Result;
use crate::model::Model;
use crate::relax::transcription::{Grid, LANES, Peak, Rows, Wide, alone};
use crate::relax::tuning::{RESERVE, ROOM, SMALLEST_RELAXATION, TO_THE_WALL};
use crate::relax::{
    ControlDerivatives, ControlEffort, CostWithControl, Point, PointCost, PointDerivatives, Points,
    PointsDerivatives,
};

/// A share of a step from one iterate to another.
///
/// Slacks are iterates of their own: along a step they change evenly, from what they were to what the rows leave after the whole of it.
/// Where a row leaves less than that at the end of the share, the difference is its relaxation; where it leaves more that is taken.
#[derive(Clone, Debug, Default)]
struct Trial {
    /// The rows before the step, and after the whole of it.
    before: Vec<f64>,
    whole: Vec<f64>,
    share: f64,
    /// The relaxations that the share leads to, and what they cost at the price of an excess.
    relaxations: Vec<f64>,
    price: f64,
}

/// What a row at a point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Inequality,
    Equality,
    /// An equality where none is asked for: a polynomial can keep it at no more points of a segment than it has free coefficients.
    Idle,
}

/// What the rows are at all points, with as many `collocated` points of each segment as equalities hold at.
fn kinds(equalities: &[bool], points: usize, per_segment: usize, collocated: usize) -> Vec<Kind> {
    let collocated = collocated.clamp(1, per_segment);
    let chosen = (0..collocated).map(|k| (2 * k + 1) * per_segment / (2 * collocated));
    let chosen: Vec<usize> = chosen.collect();
    let at_point = |g: usize| {
        let holds = chosen.contains(&(g % per_segment));
        equalities
            .iter()
            .map(move |equality| match (equality, holds) {
                (false, _) => Kind::Inequality,
                (true, true) => Kind::Equality,
                (true, false) => Kind::Idle,
            })
    };
    (0..points).flat_map(at_point).collect()
}

impl Trial {
    /// A row less its relaxation, of what it is with its margin.
    fn row(&mut self, at: usize, raw: f64) -> f64 {
        let before = self.before[at];
        let even = before + self.share * (self.whole[at] - before);
        let h = if before < 0.0 && even < 0.0 {
            raw.min(even.max(0.01 * before))
        } else {
            raw
        };
        let relaxation = raw - h;
        self.relaxations[at] = if relaxation < SMALLEST_RELAXATION {
            0.0
        } else {
            relaxation
        };
        raw - self.relaxations[at]
    }
}

/// The running cost $l_0$ and the [`Barrier`] of each row at each point,
///
/// $$ l = l_0 + \sum_j \psi(h_j + m_j) . $$
///
/// A row $h_j$ is a row of the constraints divided by its [scale](Constraint::row_scales), or a torque above its limit divided by the
/// limit. The margins $m_j \ge 0$ say how much more a row is near a point than at it. Multipliers $z_j$ belong to a point, so that the
/// integral over time makes densities of them, which do not depend on the number of points.
///
/// The gradient is that of `l`. The Hessian is the primal-dual one: $z$ weighs the second derivatives of the rows in place of
/// $\psi'$, and [`Barrier::curvature`] the products of their gradients in place of $\psi''$.
#[derive(Clone, Debug)]
pub struct BarrierCost<'a, K, P = ControlEffort<'a, f64, f64>> {
    pub(in crate::relax) rows: Rows<'a, K, P>,
    /// The barrier of all rows.
    pub barrier: Barrier,
    /// $z$, row by row for each point.
    pub multipliers: Vec<f64>,
    /// $m$, likewise.
    pub margins: Vec<f64>,
    /// $r$, likewise: by how much a row is relaxed.
    pub relaxations: Vec<f64>,
    /// A step that is being tried.
    trial: Option<Trial>,
    /// What each row at each point is.
    kinds: Vec<Kind>,
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
    own_costs: Vec<f64>,
    /// A number for each row at each point.
    scratch: Vec<f64>,
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
        Ok(Self::of(rows, barrier, 1, vec![1.0], 1))
    }
}

impl<'a, K: Constraint, P: CostWithControl> BarrierCost<'a, K, P> {
    /// That of rows on a grid, with the multipliers of the barrier of nothing.
    pub(super) fn new(rows: Rows<'a, K, P>, barrier: Barrier, grid: &Grid<f64>) -> Self {
        let weights = grid.weights.clone();
        Self::of(rows, barrier, grid.times.len(), weights, grid.bubbles())
    }

    fn of(
        rows: Rows<'a, K, P>,
        barrier: Barrier,
        points: usize,
        weights: Vec<f64>,
        collocated: usize,
    ) -> Self {
        let zeros = vec![Wide::splat(0.0); rows.count()];
        let all = vec![0.0; rows.count() * points];
        let kinds = kinds(&rows.equalities, points, weights.len(), collocated);
        let of_kind = |kind: &Kind| {
            if *kind == Kind::Inequality {
                RESERVE
            } else {
                0.0
            }
        };
        let margins = kinds.iter().map(of_kind).collect();
        Self {
            rows,
            barrier,
            multipliers: all.clone(),
            scratch: all.clone(),
            margins,
            kinds,
            relaxations: all.clone(),
            trial: None,
            h: all,
            cost: 0.0,
            weights,
            slopes: zeros.clone(),
            curvatures: zeros.clone(),
            weighted: zeros,
            own_costs: Vec::new(),
        }
    }

    /// Margins from a look between the points.
    ///
    /// On the way they make the rows at the points of its segment beside a peak as high as the peak. At the `end` they only grow, by twice
    /// what a peak is too high, so that this comes to an end. No row is nearer to its bound than before: what a margin
    /// takes is a relaxation, which the next steps take back.
    pub(super) fn set_margins(&mut self, grid: &Grid<f64>, peaks: &[Peak], end: bool) {
        let count = self.rows.count();
        for at in 0..self.h.len() {
            // Slacks for now, and margins that are found again.
            self.scratch[at] = -self.h[at];
            self.h[at] += self.relaxations[at] - self.margins[at];
            if !end && self.kinds[at] == Kind::Inequality {
                self.margins[at] = RESERVE;
            }
        }
        for peak in peaks {
            let after = grid.times.partition_point(|t| *t < peak.time);
            let own = peak.segment * grid.points()..(peak.segment + 1) * grid.points();
            for g in [after.wrapping_sub(1), after] {
                if own.contains(&g) {
                    let at = g * count + peak.row;
                    if end {
                        if peak.height > 0.0 {
                            self.margins[at] += 2.0 * peak.height + RESERVE;
                        }
                    } else {
                        let beside = RESERVE + peak.height - self.h[at];
                        self.margins[at] = self.margins[at].max(beside);
                    }
                }
            }
        }
        for at in 0..self.h.len() {
            let h = self.h[at] + self.margins[at];
            if self.kinds[at] != Kind::Inequality {
                self.h[at] = h;
                continue;
            }
            let room = self.scratch[at].clamp(0.0, ROOM);
            self.relaxations[at] = (h + room).max(0.0);
            self.h[at] = h - self.relaxations[at];
        }
    }

    /// Relaxes all rows so that each has so much room, or as much as goes with its multiplier if that is less.
    pub(super) fn relax(&mut self, room: f64) {
        for at in 0..self.h.len() {
            if self.kinds[at] != Kind::Inequality {
                continue;
            }
            let central = self.barrier.mu / self.multipliers[at].max(f64::MIN_POSITIVE);
            let more = (self.h[at] + room.min(central)).max(0.0);
            self.relaxations[at] += more;
            self.h[at] -= more;
        }
    }

    /// Begins to try a step: the rows are those before it.
    pub(super) fn begin(&mut self) {
        let mut trial = self.trial.take().unwrap_or_default();
        trial.before.clone_from(&self.h);
        trial.whole.clear();
        trial.whole.resize(self.h.len(), f64::INFINITY);
        trial.relaxations.clone_from(&self.relaxations);
        trial.share = 1.0;
        trial.price = 0.0;
        self.trial = Some(trial);
    }

    /// After the cost was evaluated at the end of the whole step: the share of it that leaves every row inside that was
    /// inside before.
    pub(super) fn end_of_whole(&mut self) -> f64 {
        let mut share = 1.0_f64;
        if let Some(trial) = &mut self.trial {
            trial.whole.clone_from(&self.h);
            for ((h, before), kind) in self.h.iter().zip(&trial.before).zip(&self.kinds) {
                if *kind == Kind::Inequality && *before < 0.0 && *h > (1.0 - TO_THE_WALL) * before {
                    share = share.min(TO_THE_WALL * before / (before - h));
                }
            }
        }
        share
    }

    /// Tries a share of the step.
    pub(super) fn try_share(&mut self, share: f64) {
        if let Some(trial) = &mut self.trial {
            (trial.share, trial.price) = (share, 0.0);
        }
    }

    /// What the relaxations of the trial cost.
    pub(super) fn trial_price(&self) -> f64 {
        self.trial.as_ref().map_or(0.0, |trial| trial.price)
    }

    /// Takes the trial for the iterate, with the multipliers that the whole of the step predicts as far as the rows where it ended
    /// allow.
    pub(super) fn accept(&mut self) {
        let Some(trial) = self.trial.take() else {
            return;
        };
        let barrier = self.barrier;
        let rows = trial.before.iter().zip(&trial.whole).zip(&self.h);
        let rows = rows.zip(&self.kinds);
        for (z, (((before, whole), h), kind)) in self.multipliers.iter_mut().zip(rows) {
            let slope = barrier.curvature(*before, *z, *kind);
            let predicted = barrier.multiplier(*before, *kind) + slope * (whole - before);
            *z = barrier.safeguarded(predicted, *h, *kind);
        }
        self.relaxations.copy_from_slice(&trial.relaxations);
    }

    /// Gives the trial up.
    pub(super) fn reject(&mut self) {
        self.trial = None;
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

    /// What the relaxations cost at the price of an excess, what of it the barriers get back, and the work of the push along the step.
    pub(super) fn price_of_relaxations(&self) -> [f64; 3] {
        let (count, mut sums) = (self.rows.count(), [0.0; 3]);
        let Some(trial) = &self.trial else {
            return sums;
        };
        for (at, r) in self.relaxations.iter().enumerate() {
            if *r > 0.0 {
                let w = self.weights[at / count % self.weights.len()];
                let before = trial.before[at];
                let c = self
                    .barrier
                    .curvature(before, self.multipliers[at], self.kinds[at]);
                // What the row itself changed by.
                let change = trial.whole[at] - before - r;
                sums[0] += w * self.barrier.nu * r;
                sums[1] += w * self.barrier.multiplier(before, self.kinds[at]) * r;
                sums[2] += w * c * r * change;
            }
        }
        sums
    }

    /// Takes the multipliers that the rows ask for.
    pub(super) fn reset_multipliers(&mut self) {
        for (at, h) in self.h.iter().enumerate() {
            self.multipliers[at] = self.barrier.multiplier(*h, self.kinds[at]);
        }
    }

    /// Changes the barrier; multipliers stay as near as they may.
    pub(super) fn set_barrier(&mut self, barrier: Barrier) {
        self.barrier = barrier;
        for (at, h) in self.h.iter().enumerate() {
            let z = self.multipliers[at];
            self.multipliers[at] = self.barrier.safeguarded(z, *h, self.kinds[at]);
        }
    }

    /// Adds up the running cost, and the barriers of the rows at `points` to it.
    fn add_barriers(&mut self, points: Points<'_, f64>, costs: &mut [f64]) {
        if points.first == 0 {
            self.cost = 0.0;
        }
        let count = self.rows.count();
        for (g, cost) in costs.iter_mut().enumerate() {
            self.cost += self.weights[g] * *cost;
            let first = (points.first + g) * count;
            let own = first..first + count;
            let barrier = self.barrier;
            for at in own {
                let raw = self.h[at] + self.margins[at];
                let h = match &mut self.trial {
                    _ if self.kinds[at] != Kind::Inequality => raw,
                    None => raw - self.relaxations[at],
                    Some(trial) => {
                        let h = trial.row(at, raw);
                        trial.price += self.weights[g] * barrier.nu * trial.relaxations[at];
                        h
                    }
                };
                self.h[at] = h;
                *cost += barrier.value(h, self.kinds[at]);
            }
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
        alone(self, point, out)
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
        let scales = self.rows.scales.clone();
        let mut term = |index: usize, u: &[f64], term: &mut ControlDerivatives<f64>| {
            let mut at = index * count + states;
            for ((i, limit, side), scale) in torque.rows().zip(&scales[states..]) {
                let slope = if side == Some(Side::Lower) {
                    -scale
                } else {
                    *scale
                };
                rows[at] = slope * u[i] - scale * limit;
                let (r, z, kind) = (relaxations[at], multipliers[at], kinds[at]);
                let h = rows[at] + margins[at] - r;
                let c = barrier.curvature(h, z, kind);
                term.gradient[i] += slope * (barrier.multiplier(h, kind) + c * r);
                term.curvature_weights[i] += slope * z;
                term.hessian[i] += slope * slope * c;
                at += 1;
            }
            torque.dim() > 0
        };
        self.rows.cost.derivatives_with(points, out, &mut term)?;
        let own = points.first * count..(points.first + points.count()) * count;
        self.rows.of_state(points, &mut self.h[own])?;
        let mut costs = std::mem::take(&mut self.own_costs);
        costs.clone_from(&out.costs);
        self.add_barriers(points, &mut costs);
        out.costs.copy_from_slice(&costs);
        self.own_costs = costs;
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
        let barrier = self.barrier;
        for j in 0..states {
            let scale = self.rows.scales[j];
            for lane in 0..LANES {
                let at = (points.first + start + lane.min(found - 1)) * count + j;
                let (h, z, kind) = (self.h[at], self.multipliers[at], self.kinds[at]);
                let c = barrier.curvature(h, z, kind);
                let push = c * self.relaxations[at];
                self.slopes[j].0[lane] = (barrier.multiplier(h, kind) + push) * scale;
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
        out.hessians.add(start, pull.hessian());
        Ok(())
    }
}
