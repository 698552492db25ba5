//! What is asked of a motion besides little effort, as an augmented Lagrangian.

use super::cost::{LANES, Wide};
use super::effort::alone;
use super::scan::Peak;
use super::{
    ControlEffort, CostWithControl, Grid, Point, PointCost, PointDerivatives, Points,
    PointsDerivatives,
};
use crate::constraint::{Constraint, Constraints, Evaluator, Weights};
use crate::error::Result;
use crate::model::Model;

/// How far the rows are kept on the safe side, relative to their scale, so that rounding does not put the end outside.
const RESERVE: f64 = 2e-7;

/// The rows of constraints at single points, in their own units and relative to their scales.
#[derive(Clone, Debug)]
pub(super) struct Rows<'a, K, P> {
    pub constraints: &'a Constraints<K>,
    /// The running cost.
    pub cost: P,
    u: Vec<f64>,
    evaluator: Evaluator<'a, f64, Wide<f64>>,
    /// $[q; v; a]$ and the rows of the state at the points that are side by side.
    z: Vec<Wide<f64>>,
    wide: Vec<Wide<f64>>,
    /// For one point alone.
    single: Evaluator<'a, f64, f64>,
    /// What a row is multiplied with: it is then of the order of 0.1 where it is badly violated.
    scales: Vec<f64>,
    /// One of the multiplied row in rad, rad/s, m, N m or N.
    pub units: Vec<f64>,
}

impl<'a, K: Constraint, P: CostWithControl> Rows<'a, K, P> {
    pub fn new(model: &'a Model, constraints: &'a Constraints<K>, cost: P) -> Result<Self> {
        let Constraints { state, torque } = constraints;
        if torque.dim() > 0 {
            torque.check(model)?;
        }
        let mut slopes = vec![1.0; state.dim()];
        state.row_scales(&mut slopes);
        let limits = torque.0.iter().flatten().flat_map(|limit| [*limit; 2]);
        let units = slopes.iter().map(|_| 1.0).chain(limits.clone());
        Ok(Self {
            constraints,
            cost,
            u: vec![0.0; model.dof()],
            evaluator: Evaluator::new(model),
            z: vec![Wide::splat(0.0); 3 * model.dof()],
            wide: vec![Wide::splat(0.0); state.dim()],
            single: Evaluator::new(model),
            units: units.collect(),
            scales: slopes.into_iter().chain(limits).map(f64::recip).collect(),
        })
    }

    pub fn count(&self) -> usize {
        self.scales.len()
    }

    /// All rows at all points into `h`, row by row for each point, and the running cost there into `costs`.
    pub fn at(&mut self, points: Points<'_, f64>, h: &mut [f64], costs: &mut [f64]) -> Result<()> {
        self.of_state(points, h)?;
        let Constraints { state, torque } = self.constraints;
        if torque.dim() == 0 {
            return self.cost.values(points, costs);
        }
        let (states, count) = (state.dim(), self.count());
        for (g, h) in h.chunks_exact_mut(count).enumerate() {
            let h = &mut h[states..];
            costs[g] = self.cost.value_with_control(points.point(g), &mut self.u)?;
            torque.value(&self.u, h)?;
            for (h, scale) in h.iter_mut().zip(&self.scales[states..]) {
                *h *= scale;
            }
        }
        Ok(())
    }

    /// The same without the running cost, which is not computed where only the state has constraints.
    pub fn of_all(&mut self, points: Points<'_, f64>, h: &mut [f64]) -> Result<()> {
        if self.constraints.torque.dim() > 0 {
            self.at(points, h, &mut vec![0.0; points.count()])
        } else {
            self.of_state(points, h)
        }
    }

    /// The rows of the state alone; those of the control are left as they are.
    pub fn of_state(&mut self, points: Points<'_, f64>, h: &mut [f64]) -> Result<()> {
        let (states, count) = (self.constraints.state.dim(), self.count());
        let own = 2 * points.states.nrows();
        for start in (0..points.count()).step_by(LANES) {
            let found = points.gather(start, &mut self.z);
            let placed = self.evaluator.at(&self.z[..own])?;
            placed.value(&self.constraints.state, &mut self.wide)?;
            for lane in 0..found {
                let first = (start + lane) * count;
                let h = &mut h[first..first + states];
                for ((h, wide), scale) in h.iter_mut().zip(&self.wide).zip(&self.scales) {
                    *h = wide.0[lane] * scale;
                }
            }
        }
        Ok(())
    }
}

/// A running cost $l_0$, the effort unless it is another, and for the rows $h_j \le 0$ at each point with multipliers $\lambda_j$ of their own,
///
/// $$ l = l_0 + \frac{1}{2 \rho} \sum_j \max(0, \lambda_j + \rho (h_j + m_j))^2 . $$
///
/// This is the augmented Lagrangian of Powell, Hestenes and Rockafellar (Nocedal and Wright, *Numerical Optimization*, 17.4) less the
/// $\lambda_j^2 / 2 \rho$, which do not depend on the curve. A row $h_j$ is a row of the constraints divided by its
/// [scale](Constraint::row_scales), or a torque above its limit divided by the limit. The margins $m_j \ge 0$ say how much more a row is near a point than at it.
#[derive(Clone, Debug)]
pub struct Augmented<'a, K, P = ControlEffort<'a, f64, f64>> {
    pub(super) rows: Rows<'a, K, P>,
    /// $\rho$.
    pub rho: f64,
    /// $\lambda$, row by row for each point.
    pub multipliers: Vec<f64>,
    /// $m$, likewise.
    pub margins: Vec<f64>,
    /// Rows at the points of a segment.
    h: Vec<f64>,
    w: Vec<f64>,
    c: Vec<f64>,
}

impl<'a, K: Constraint> Augmented<'a, K> {
    /// That of the effort, without multipliers at so many points.
    ///
    /// # Errors
    /// The torque limits are those of another robot.
    pub fn new(
        model: &'a Model,
        constraints: &'a Constraints<K>,
        rho: f64,
        points: usize,
    ) -> Result<Self> {
        let rows = Rows::new(model, constraints, ControlEffort::new(model))?;
        Ok(Self::of(rows, rho, points))
    }
}

impl<'a, K: Constraint, P: CostWithControl> Augmented<'a, K, P> {
    /// That of rows that are there already, without multipliers.
    pub(super) fn of(rows: Rows<'a, K, P>, rho: f64, points: usize) -> Self {
        let zeros = vec![0.0; rows.count()];
        let all = vec![0.0; rows.count() * points];
        Self {
            rows,
            rho,
            multipliers: all.clone(),
            margins: all,
            h: Vec::new(),
            w: zeros.clone(),
            c: zeros,
        }
    }

    /// What row `row` of `h` pulls with: the multiplier that it would get at point `index`.
    pub(super) fn pull(&self, index: usize, row: usize, h: f64) -> f64 {
        let at = index * self.rows.count() + row;
        (self.multipliers[at] + self.rho * (h + self.margins[at])).max(0.0)
    }
}

impl<K: Constraint, P: CostWithControl> Augmented<'_, K, P> {
    /// The margins that make the rows at the points of its segment beside a peak as high as the peak.
    pub(super) fn set_margins(&mut self, grid: &Grid<f64>, peaks: &[Peak], h: &[f64]) {
        let count = self.rows.count();
        self.margins.fill(RESERVE);
        for peak in peaks {
            let after = grid.times.partition_point(|t| *t < peak.time);
            let own = peak.segment * grid.points()..(peak.segment + 1) * grid.points();
            for g in [after.wrapping_sub(1), after] {
                if own.contains(&g) {
                    let at = g * count + peak.row;
                    self.margins[at] = self.margins[at].max(RESERVE + peak.height - h[at]);
                }
            }
        }
    }

    /// New margins and multipliers; says how far the latter moved, in units of the rows.
    pub(super) fn update(&mut self, grid: &Grid<f64>, peaks: &[Peak], h: &[f64]) -> f64 {
        self.set_margins(grid, peaks, h);
        let (count, mut moved) = (self.rows.count(), 0.0_f64);
        for (at, h) in h.iter().enumerate() {
            let pull = self.pull(at / count, at % count, *h);
            let by = (pull - self.multipliers[at]).abs() / self.rho;
            moved = moved.max(by * self.rows.units[at % count]);
            self.multipliers[at] = pull;
        }
        moved
    }
}

impl<K: Constraint, P: CostWithControl> PointCost<f64> for Augmented<'_, K, P> {
    fn value(&mut self, point: Point<'_, f64>) -> Result<f64> {
        let states = point.states();
        let mut cost = [0.0];
        self.values(point.points(&states), &mut cost)?;
        Ok(cost[0])
    }

    fn values(&mut self, points: Points<'_, f64>, costs: &mut [f64]) -> Result<()> {
        let mut h = std::mem::take(&mut self.h);
        h.resize(points.count() * self.rows.count(), 0.0);
        let known = self.rows.at(points, &mut h, costs);
        for (g, (h, cost)) in h
            .chunks_exact(self.rows.count().max(1))
            .zip(costs)
            .enumerate()
        {
            let pulls = h.iter().enumerate();
            let pulls = pulls.map(|(j, h)| self.pull(points.first + g, j, *h));
            *cost += pulls.map(|w| w * w).sum::<f64>() / (2.0 * self.rho);
        }
        self.h = h;
        known
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
        let (states, count, rho) = (state.dim(), self.rows.count(), self.rho);
        let (multipliers, margins) = (&self.multipliers, &self.margins);
        let mut charged = vec![0.0; points.count()];
        let mut charge = |index: usize, u: &[f64], first: &mut [f64], second: &mut [f64]| {
            let own = index * count + states..(index + 1) * count;
            let (multipliers, margins) = (&multipliers[own.clone()], &margins[own]);
            let limited = torque.0.iter().enumerate();
            let limited = limited.filter_map(|(i, limit)| limit.map(|limit| (i, limit)));
            let mut stiff = false;
            for (k, (i, limit)) in limited.enumerate() {
                for (j, sign) in [(2 * k, 1.0), (2 * k + 1, -1.0)] {
                    let h = (sign * u[i] - limit) / limit + margins[j];
                    let w = multipliers[j] + rho * h;
                    if w > 0.0 {
                        charged[index - points.first] += w * w;
                        first[i] += sign * w / limit;
                        second[i] += rho / (limit * limit);
                        stiff = true;
                    }
                }
            }
            stiff
        };
        let cost = &mut self.rows.cost;
        cost.derivatives_with(points, out, &mut charge)?;
        let mut h = std::mem::take(&mut self.h);
        h.resize(points.count() * count, 0.0);
        self.rows.of_state(points, &mut h)?;
        for (g, charged) in charged.iter_mut().enumerate() {
            let own = &h[g * count..g * count + states];
            *charged += self.add_state(points.point(g), own, g, out)?;
            out.costs[g] += *charged / (2.0 * rho);
        }
        self.h = h;
        Ok(())
    }
}

impl<K: Constraint, P: CostWithControl> Augmented<'_, K, P> {
    /// Adds the derivatives that the rows of the state have at point `g`; says what the squares of their pulls are together.
    fn add_state(
        &mut self,
        point: Point<'_, f64>,
        h: &[f64],
        g: usize,
        out: &mut PointsDerivatives<f64>,
    ) -> Result<f64> {
        let (n, state, states) = (point.q.len(), &self.rows.constraints.state, h.len());
        let mut charged = 0.0;
        for j in 0..states {
            let (w, scale) = (self.pull(point.index, j, h[j]), self.rows.scales[j]);
            charged += w * w;
            self.w[j] = w * scale;
            self.c[j] = if w > 0.0 {
                self.rho * scale * scale
            } else {
                0.0
            };
        }
        if charged > 0.0 {
            let weights = Weights {
                first_order: &self.w[..states],
                gauss_newton: Some(&self.c[..states]),
            };
            let x = [point.q, point.v].concat();
            let mut placed = self.rows.single.at(&x)?;
            let pull = placed.weighted_derivatives(state, weights)?;
            for (x, part) in [(0, 0), (1, n)] {
                let mut gradient = out.gradients.column_mut(3 * g + x);
                gradient += pull.gradient().rows(part, n);
            }
            out.hessians.add(g, pull.hessian());
        }
        Ok(charged)
    }
}
