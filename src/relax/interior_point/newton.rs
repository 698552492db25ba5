//! Newton's method with the exact Hessian in a trust region.

use super::barrier_cost::BarrierCost;
use crate::constraint::Constraint;
use crate::error::Result;
use crate::linalg::{BlockTridiagonal, Region, Step, add_step};
use crate::relax::tuning::{CUT, CUTS, REFUSALS, ROUNDING, SMALLEST_COST, SUFFICIENT};
use crate::relax::{CostWithControl, Derivatives, Iteration, Objective};
use nalgebra::{DMatrix, DVector};

/// An objective with barriers.
pub(super) type Merit<'g, 'a, K, P> = Objective<'g, f64, BarrierCost<'a, K, P>>;

/// Scratch space of the minimiser.
pub(super) struct Newton {
    pub derivatives: Derivatives<f64>,
    factor: BlockTridiagonal<f64>,
    metric_factor: BlockTridiagonal<f64>,
    /// True if the metric was positive definite.
    definite: bool,
    gram: BlockTridiagonal<f64>,
    norm: BlockTridiagonal<f64>,
    pub region: Region,
    /// The fraction of the last step that was taken.
    pub share: f64,
}

impl Newton {
    pub fn new<K: Constraint, P: CostWithControl>(objective: &Merit<'_, '_, K, P>) -> Self {
        let derivatives = Derivatives::new(objective.grid(), objective.dof());
        let gram = objective.gram();
        Self {
            factor: gram.clone(),
            metric_factor: gram.clone(),
            definite: false,
            norm: gram.clone(),
            gram,
            derivatives,
            region: Region::default(),
            share: 1.0,
        }
    }

    /// Evaluates the merit function, and its derivatives into `derivatives`; the metric is updated only if `fresh`.
    pub fn derive<K: Constraint, P: CostWithControl>(
        &mut self,
        objective: &mut Merit<'_, '_, K, P>,
        coefficients: &DMatrix<f64>,
        fresh: bool,
    ) -> Result<f64> {
        if !fresh {
            return objective.gradient_and_hessian(coefficients, &mut self.derivatives);
        }
        let merit = objective.derivatives(coefficients, &mut self.derivatives)?;
        let size = objective.cost_mut().cost.max(SMALLEST_COST);
        let metric = &self.derivatives.metric;
        self.norm.set_sum(&self.gram, 1.0 / size, metric);
        self.metric_factor.clone_from(metric);
        self.definite = self.metric_factor.factorise();
        if !self.definite {
            self.metric_factor.set_sum(metric, size, &self.gram);
            self.definite = self.metric_factor.factorise();
        }
        Ok(merit)
    }

    /// $\sqrt{g^T G^{-1} g / J}$. If the metric is singular, `J` times the norm of the trust region replaces it.
    pub fn gradient_norm(&self, cost: f64) -> f64 {
        if !self.definite {
            return f64::INFINITY;
        }
        let mut natural = self.derivatives.gradient.clone();
        self.metric_factor.solve(&mut natural);
        (natural.dot(&self.derivatives.gradient) / cost.max(SMALLEST_COST)).sqrt()
    }

    /// Finds a step from `from` to `to` that reduces the merit function sufficiently. Returns the decrease that the
    /// quadratic model predicted, or `None` without such a step. The multipliers take the step too.
    pub fn step<K: Constraint, P: CostWithControl>(
        &mut self,
        objective: &mut Merit<'_, '_, K, P>,
        from: &DMatrix<f64>,
        to: &mut DMatrix<f64>,
        merit: f64,
        iteration: &mut Iteration,
    ) -> Result<Option<f64>> {
        let Derivatives {
            gradient, hessian, ..
        } = &self.derivatives;
        let size = iteration.cost.max(SMALLEST_COST);
        let rounding = ROUNDING * size.max(merit.abs());
        // The multiplier cannot be above the norm of the gradient over the radius where the Hessian is positive.
        self.region.scale = iteration.gradient_norm * size;
        for _ in 0..REFUSALS {
            let step = self.region.step(
                gradient,
                hessian,
                &self.norm,
                &mut self.factor,
                &mut iteration.factorisations,
            );
            let Some(Step { step, length }) = step else {
                return Ok(None);
            };
            let (slope, bend) = (gradient.dot(&step), step.dot(&hessian.product(&step)));
            let promised = -(slope + 0.5 * bend);
            move_by(objective, from, &step, 1.0, to);
            objective.cost_mut().begin();
            let mut value = objective.value(to)?;
            // As far as the rows allow that are inside, if they change evenly along the way.
            let cost = objective.cost_mut();
            let cut = cost.end_of_whole();
            let [price, back, work] = cost.price_of_relaxations();
            let (mut share, mut ratio) = (cut, f64::NAN);
            for _ in 0..CUTS {
                if share < 1.0 {
                    move_by(objective, from, &step, share, to);
                    objective.cost_mut().try_share(share);
                    value = objective.value(to)?;
                }
                let predicted = -share * (slope - work - price + back + 0.5 * share * bend);
                let gained = merit + price - value - objective.cost_mut().trial_price();
                // Near the minimum rounding hides what is gained.
                let hidden = predicted.abs() <= rounding && gained.abs() <= rounding;
                ratio = match (hidden, predicted > 0.0) {
                    (true, _) => 1.0,
                    (false, true) => gained / predicted,
                    // With relaxations the model is no better than its first order.
                    (false, false) => gained.signum(),
                };
                if ratio > SUFFICIENT {
                    break;
                }
                share *= CUT;
            }
            iteration.damping = self.region.damping;
            iteration.step = share * length;
            self.share = share;
            if ratio > SUFFICIENT {
                if cut == 1.0 {
                    self.region
                        .learn(if share < 1.0 { 0.0 } else { ratio }, share * length);
                }
                objective.cost_mut().accept();
                return Ok(Some(promised));
            }
            objective.cost_mut().reject();
            self.region.learn(ratio, share * length);
        }
        Ok(None)
    }

    /// The smallest eigenvalue of the Hessian relative to the Gauss-Newton metric, and its eigenvector, by inverse
    /// iteration. The derivatives are those of the last curve.
    pub fn smallest_curvature(&mut self) -> (f64, DVector<f64>) {
        let Derivatives {
            hessian, metric, ..
        } = &self.derivatives;
        let mut shift: f64 = 0.0;
        loop {
            self.factor.set_sum(hessian, shift, metric);
            if self.factor.factorise() || shift > 1e12 {
                break;
            }
            shift = (4.0 * shift).max(0.1);
        }
        let mut x = DVector::from_fn(hessian.order(), |i, _| (1.0 + i as f64).sin());
        let mut curvature = f64::INFINITY;
        for _ in 0..100 {
            let mut y = metric.product(&x);
            self.factor.solve(&mut y);
            let norm = y.dot(&metric.product(&y)).sqrt();
            x = y / norm;
            let now = x.dot(&hessian.product(&x));
            let settled = (curvature - now).abs() <= 1e-3 * (now + shift).abs();
            curvature = now;
            if settled {
                break;
            }
        }
        (curvature, x)
    }
}

/// Adds a `share` of `step` to `from` in the unknown coefficients.
pub(super) fn move_by<K: Constraint, P: CostWithControl>(
    objective: &Merit<'_, '_, K, P>,
    from: &DMatrix<f64>,
    step: &DVector<f64>,
    share: f64,
    to: &mut DMatrix<f64>,
) {
    let first = objective.grid().free.start * objective.dof();
    add_step(from, first, step, share, to);
}
