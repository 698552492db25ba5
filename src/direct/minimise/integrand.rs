//! The running cost with the weighted rows of constraints.

use super::foot_terms::FootTerms;
use super::stage_terms::StageTerms;
use crate::constraint::{Constraint, Side, Weights};
use crate::cost::alone;
use crate::cost::{ControlDerivatives, CostWithControl, Point, PointCost, PointDerivatives, Points, PointsDerivatives};
use crate::error::Result;
use crate::nlp::Term;
use crate::scalar::{LANES, Wide};
use crate::transcription::Rows;

/// The running cost $l$, and the weighted rows $h_j$ whose weights are those of the condensed equations of the
/// interior-point method ([`Term`]): the gradient is $l_z + \sum_j \sigma_j \nabla h_j$ and the Hessian
/// $l_{zz} + \sum_j \lambda_j \nabla^2 h_j + c_j \nabla h_j \nabla h_j^T$.
///
/// A row $h_j$ is a row of the constraints divided by its [scale](Constraint::row_scales), or the excess of a torque
/// over its limit divided by the limit.
#[derive(Clone, Debug)]
pub(crate) struct Integrand<'a, K, P> {
    pub rows: Rows<'a, K, P>,
    /// The values of all rows at the last evaluation, row by row for each point.
    pub h: Vec<f64>,
    /// The terms of the rows in the working set, by row for each point.
    pub terms: Vec<Vec<(usize, Term)>>,
    /// The joint and the slope of each row of the torque.
    torques: Vec<(usize, f64)>,
    /// Weights of the gradients, of their products and of the second derivatives of the rows of the state, side by
    /// side; zero except during use.
    slopes: Vec<Wide<f64>>,
    curvatures: Vec<Wide<f64>>,
    multipliers: Vec<Wide<f64>>,
    /// The derivatives of the rows of a standing foot, if there is one: of that of each phase.
    feet: Vec<FootTerms>,
    /// The derivatives of the rows in $(t, q, v, a, u)$, if there are any.
    stage: Option<StageTerms<'a>>,
}

impl<'a, K: Constraint, P: CostWithControl> Integrand<'a, K, P> {
    /// The integrand at this number of points, without terms of rows.
    pub fn new(rows: Rows<'a, K, P>, points: usize) -> Self {
        let states = rows.states();
        let zeros = vec![Wide::splat(0.0); states];
        let torque = rows.constraints.torque.rows();
        let torques = torque.zip(&rows.attributes().scales[states..]);
        let torques = torques.map(|((joint, _, side), scale)| match side {
            Some(Side::Lower) => (joint, -scale),
            _ => (joint, *scale),
        });
        let stage = &rows.constraints.stage;
        let scales = &rows.attributes().scales;
        let cutoffs = rows.attributes().cutoffs.iter();
        let cutoffs = cutoffs.map(|cutoff| if cutoff.is_finite() { -cutoff } else { 0.0 });
        let cutoffs: Vec<_> = cutoffs.collect();
        let feet = (0..rows.cost.phases()).filter_map(|phase| rows.standing(phase));
        let feet = feet.map(|foot| FootTerms::new(foot, scales)).collect();
        let stage = (!stage.custom.is_empty()).then(|| StageTerms::new(rows.model));
        Self {
            feet,
            stage,
            torques: torques.collect(),
            // Rows at their cutoffs are not written.
            h: cutoffs.repeat(points),
            terms: vec![Vec::new(); points],
            rows,
            slopes: zeros.clone(),
            curvatures: zeros.clone(),
            multipliers: zeros,
        }
    }

    /// Puts the rows that may be near with their margins at the beginning of `h` and truncates that; other entries are
    /// of earlier evaluations.
    pub fn with_margins(&self, margins: &[f64], h: &mut Vec<f64>) {
        let count = self.rows.count();
        h.resize(margins.len(), f64::NEG_INFINITY);
        for (g, h) in h.chunks_exact_mut(count.max(1)).enumerate() {
            let own = g * count..(g + 1) * count;
            let (values, margins) = (&self.h[own.clone()], &margins[own]);
            let (listed, others) = self.rows.near_at(g);
            for row in listed.iter().copied() {
                h[row] = values[row] + margins[row];
            }
            // In a loop of its own, so that they are added side by side.
            for row in others {
                h[row] = values[row] + margins[row];
            }
        }
    }

    /// Adds the derivatives of the rows of the state at the points from `start` on, side by side.
    fn add_state(&mut self, points: Points<'_, f64>, start: usize, out: &mut PointsDerivatives<f64>) -> Result<()> {
        let n = points.states.nrows();
        let found = LANES.min(points.count() - start);
        let states = self.rows.states();
        let mut any = false;
        for lane in 0..found {
            for (row, term) in &self.terms[points.first + start + lane] {
                if *row < states && self.rows.is_kept(*row, points.phase) {
                    let scale = self.rows.attributes().scales[*row];
                    self.slopes[*row].0[lane] = term.slope * scale;
                    self.curvatures[*row].0[lane] = term.curvature * scale * scale;
                    self.multipliers[*row].0[lane] = term.multiplier * scale;
                    any = true;
                }
            }
        }
        if !any {
            return Ok(());
        }
        let gradient = Weights { first_order: &self.slopes, gauss_newton: None };
        let sum = self.rows.weighted_derivatives(points, start, gradient)?;
        for (i, slope) in sum.gradient().iter().enumerate() {
            for lane in 0..found {
                out.gradients[(i % n, 3 * (start + lane) + i / n)] += slope.0[lane];
            }
        }
        let hessian = Weights { first_order: &self.multipliers, gauss_newton: Some(&self.curvatures) };
        let sum = self.rows.weighted_derivatives(points, start, hessian)?;
        out.hessians.add_wide(start, sum.hessian());
        for lane in 0..found {
            for (row, _) in &self.terms[points.first + start + lane] {
                if *row < states {
                    for weights in [&mut self.slopes, &mut self.curvatures, &mut self.multipliers] {
                        weights[*row].0[lane] = 0.0;
                    }
                }
            }
        }
        Ok(())
    }
}

impl<K: Constraint, P: CostWithControl> Integrand<'_, K, P> {
    /// Adds the derivatives of the limits of rates.
    fn add_rates(&self, points: Points<'_, f64>, out: &mut PointsDerivatives<f64>) {
        let first = self.rows.constraints.first_of_stage();
        for g in 0..points.count() {
            for (row, term) in &self.terms[points.first + g] {
                let row = row.checked_sub(first);
                let Some(rate) = row.and_then(|row| self.rows.constraints.stage.rates.get(row)) else {
                    continue;
                };
                let (slope, i) = (rate.side.sign() / rate.limit, rate.joint);
                let curvature = term.curvature * slope * slope;
                match rate.order.checked_sub(3) {
                    Some(higher) => {
                        let [slopes, curvatures] = &mut out.higher[higher];
                        slopes[(i, g)] += term.slope * slope;
                        curvatures[(i, g)] += curvature;
                    }
                    None => {
                        out.gradients[(i, 3 * g + 2)] += term.slope * slope;
                        out.hessians.add_acceleration(g, i, curvature);
                    }
                }
            }
        }
    }
}

impl<K: Constraint, P: CostWithControl> PointCost<f64> for Integrand<'_, K, P> {
    fn value(&mut self, point: Point<'_, f64>) -> Result<f64> {
        let states = point.states();
        let mut cost = [0.0];
        self.values(point.points(&states), &mut cost)?;
        Ok(cost[0])
    }

    fn time_rate(&mut self, point: Point<'_, f64>) -> Result<f64> {
        let of_rows = match &mut self.stage {
            Some(stage) => stage.time_rate(point, &self.rows.constraints, &self.terms[point.index])?,
            None => 0.0,
        };
        Ok(of_rows + self.rows.cost.time_rate(point)?)
    }

    fn order(&self) -> usize {
        self.rows.order()
    }

    fn phases(&self) -> usize {
        self.rows.cost.phases()
    }

    fn values(&mut self, points: Points<'_, f64>, costs: &mut [f64]) -> Result<()> {
        let count = self.rows.count();
        let own = points.first * count..(points.first + points.count()) * count;
        self.rows.at(points, &mut self.h[own], costs)
    }

    fn derivatives(&mut self, point: Point<'_, f64>, out: &mut PointDerivatives<f64>) -> Result<f64> {
        alone(point, out, |points, all| self.all_derivatives(points, all))
    }

    fn all_derivatives(&mut self, points: Points<'_, f64>, out: &mut PointsDerivatives<f64>) -> Result<()> {
        let torque = &self.rows.constraints.torque;
        let (states, torques, terms) = (self.rows.states(), &self.torques, &self.terms);
        let mut add = |index: usize, _: &[f64], out: &mut ControlDerivatives<f64>| {
            for (row, term) in &terms[index] {
                let row = row.checked_sub(states);
                let Some((joint, slope)) = row.and_then(|row| torques.get(row).copied()) else {
                    continue;
                };
                out.gradient[joint] += slope * term.slope;
                out.curvature_weights[joint] += slope * term.multiplier;
                out.hessian[joint] += slope * slope * term.curvature;
            }
            torque.dim() > 0
        };
        self.rows.cost.all_derivatives_with(points, out, &mut add)?;
        for (g, cost) in out.costs.iter_mut().enumerate() {
            *cost += terms[points.first + g].iter().map(|(_, term)| term.cost).sum::<f64>();
        }
        self.add_rates(points, out);
        let standing = self.rows.standing(points.phase);
        if let (Some(foot), Some(standing)) = (self.feet.get_mut(points.phase), standing) {
            foot.add(standing, points, &self.terms, out)?;
        }
        if let Some(stage) = &mut self.stage {
            stage.add(points, &self.rows.constraints, &self.terms, out)?;
        }
        if states > 0 {
            for start in (0..points.count()).step_by(LANES) {
                self.add_state(points, start, out)?;
            }
        }
        Ok(())
    }
}
