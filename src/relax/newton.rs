//! Newton's method with the exact Hessian in a trust region.

use super::trust_region::{Region, Step};
use super::{Derivatives, Objective, PointCost};
use crate::error::Result;
use crate::linalg::BlockTridiagonal;
use nalgebra::{DMatrix, DVector};

/// The part of the predicted decrease that a step has to make.
const SUFFICIENT: f64 = 1e-3;
/// What rounding can hide of the cost.
const ROUNDING: f64 = 1e-13;
/// How often a step may be refused before the search is given up.
const REFUSALS: usize = 60;
/// How many steps are made between two looks at the quadrature.
const LOOK: usize = 6;
/// How well quadratures have to agree where the search has not come to an end.
const ON_THE_WAY: f64 = 0.05;
/// A cost below this, in N^2 m^2 s, is rounding: gradients are not measured against less.
pub(super) const SMALLEST_COST: f64 = f64::EPSILON;

/// When the minimiser stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stop {
    /// The relative gradient norm.
    pub tolerance: f64,
    /// Steps.
    pub iterations: usize,
    /// After so many steps the metric of Gauss and Newton is computed anew, which takes as long as the Hessian.
    pub fresh: usize,
    /// Whether the gradient norm has to be that in the metric of the last curve.
    pub precise: bool,
}

/// One iteration of the minimiser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// The degree of the segments.
    pub degree: usize,
    /// How many points of quadrature each segment has.
    pub points: usize,
    /// The cost $J$ before the step.
    pub cost: f64,
    /// $\sqrt{g^T G^{-1} g / J}$ with the gradient $g$ and the metric $G$ of Gauss and Newton. The cost of a problem that is
    /// linear in the curve would be above its minimum by half the square of this, relatively.
    pub gradient_norm: f64,
    /// The multiple $\lambda$ of the norm of the trust region that was added to the Hessian.
    pub damping: f64,
    /// The length of the step in that norm, roughly radians; zero where there was none.
    pub step: f64,
    /// How often a matrix was factorised.
    pub factorisations: usize,
}

/// Why the minimiser stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// The gradient is small enough.
    Converged,
    /// There were as many steps as allowed, or no step makes the cost smaller.
    Stalled,
    /// The quadrature sees another cost than it should.
    Coarse,
}

/// Where the minimiser stopped.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    pub coefficients: DMatrix<f64>,
    pub cost: f64,
    pub gradient_norm: f64,
    pub end: End,
}

/// Says of a curve, its cost, and whether the search ends there, whether the quadrature is too coarse for it.
pub(super) type LookAtQuadrature<'a> = dyn FnMut(&DMatrix<f64>, f64, bool) -> Result<bool> + 'a;

/// Looks at the quadrature of an objective with a finer one: a minimiser exploits what a coarse one does not see.
pub(super) struct Judge<'g, P> {
    pub finer: Objective<'g, f64, P>,
    /// How well the two have to agree at the end, relative.
    pub quadrature_tolerance: f64,
    /// The cost by the finer one when it was last asked.
    pub cost: f64,
}

impl<P: PointCost<f64>> Judge<'_, P> {
    /// Whether the quadrature is too coarse for this curve, which it says costs `cost`. On the way less is asked than at the `end`.
    pub fn finds_coarse(&mut self, curve: &DMatrix<f64>, cost: f64, end: bool) -> Result<bool> {
        self.cost = self.finer.value(curve)?;
        let quadrature_tolerance = if end {
            self.quadrature_tolerance
        } else {
            self.quadrature_tolerance.max(ON_THE_WAY)
        };
        Ok((self.cost - cost).abs() > quadrature_tolerance * self.cost.max(SMALLEST_COST))
    }
}

/// Scratch space of the minimiser.
pub(super) struct Newton {
    pub derivatives: Derivatives<f64>,
    factor: BlockTridiagonal<f64>,
    metric_factor: BlockTridiagonal<f64>,
    /// Whether there is one.
    definite: bool,
    gram: BlockTridiagonal<f64>,
    norm: BlockTridiagonal<f64>,
}

impl Newton {
    pub fn new<P: PointCost<f64>>(objective: &Objective<'_, f64, P>) -> Self {
        let derivatives = Derivatives::new(objective.grid(), objective.dof());
        let gram = objective.gram();
        Self {
            factor: gram.clone(),
            metric_factor: gram.clone(),
            definite: false,
            norm: gram.clone(),
            gram,
            derivatives,
        }
    }

    /// Minimises `objective` from `coefficients`, asking `coarse` now and then about its quadrature.
    pub fn minimise<P: PointCost<f64>>(
        &mut self,
        objective: &mut Objective<'_, f64, P>,
        mut coefficients: DMatrix<f64>,
        stop: Stop,
        coarse: &mut LookAtQuadrature<'_>,
        observe: &mut dyn FnMut(Iteration),
    ) -> Result<Minimum> {
        let (mut region, mut steps) = (Region::default(), 0_usize);
        let mut trial = coefficients.clone();
        loop {
            let mut fresh = steps.is_multiple_of(stop.fresh);
            let mut cost = self.derive(objective, &coefficients, fresh)?;
            let mut gradient_norm = self.gradient_norm(cost);
            let ends = |gradient_norm| gradient_norm <= stop.tolerance || steps == stop.iterations;
            if !fresh && stop.precise && ends(gradient_norm) {
                fresh = true;
                cost = self.derive(objective, &coefficients, fresh)?;
                gradient_norm = self.gradient_norm(cost);
            }
            let mut iteration = Iteration {
                degree: objective.grid().table.nrows() - 1,
                points: objective.grid().points(),
                cost,
                gradient_norm,
                damping: 0.0,
                step: 0.0,
                factorisations: usize::from(fresh),
            };
            let converged = gradient_norm <= stop.tolerance;
            let last = converged || steps == stop.iterations;
            let look = last || steps % LOOK == LOOK - 1;
            let mut end = match look && coarse(&coefficients, cost, last)? {
                true => Some(End::Coarse),
                false if converged => Some(End::Converged),
                false if last => Some(End::Stalled),
                false => None,
            };
            if end.is_none() {
                let from = &coefficients;
                let step = self.step(objective, from, &mut trial, &mut region, &mut iteration)?;
                if !step {
                    end = Some(End::Stalled);
                }
            }
            observe(iteration);
            if let Some(end) = end {
                return Ok(Minimum {
                    coefficients,
                    cost,
                    gradient_norm,
                    end,
                });
            }
            std::mem::swap(&mut coefficients, &mut trial);
            steps += 1;
        }
    }

    /// The cost, and its derivatives into `derivatives`; only a `fresh` metric is that of this curve.
    fn derive<P: PointCost<f64>>(
        &mut self,
        objective: &mut Objective<'_, f64, P>,
        coefficients: &DMatrix<f64>,
        fresh: bool,
    ) -> Result<f64> {
        if !fresh {
            return objective.gradient_and_hessian(coefficients, &mut self.derivatives);
        }
        let cost = objective.derivatives(coefficients, &mut self.derivatives)?;
        let (metric, size) = (&self.derivatives.metric, cost.max(SMALLEST_COST));
        self.norm.set_sum(&self.gram, 1.0 / size, metric);
        self.metric_factor.clone_from(metric);
        self.definite = self.metric_factor.factorise();
        if !self.definite {
            self.metric_factor.set_sum(metric, size, &self.gram);
            self.definite = self.metric_factor.factorise();
        }
        Ok(cost)
    }

    /// $\sqrt{g^T G^{-1} g / J}$. Where the metric does not see every direction, `J` times the norm of the trust region takes its place.
    fn gradient_norm(&self, cost: f64) -> f64 {
        if !self.definite {
            return f64::INFINITY;
        }
        let mut natural = self.derivatives.gradient.clone();
        self.metric_factor.solve(&mut natural);
        (natural.dot(&self.derivatives.gradient) / cost.max(SMALLEST_COST)).sqrt()
    }

    /// Looks for a step that makes the cost smaller by enough, from `from` to `to`; says whether there is one.
    fn step<P: PointCost<f64>>(
        &mut self,
        objective: &mut Objective<'_, f64, P>,
        from: &DMatrix<f64>,
        to: &mut DMatrix<f64>,
        region: &mut Region,
        iteration: &mut Iteration,
    ) -> Result<bool> {
        let cost = iteration.cost;
        let Derivatives {
            gradient, hessian, ..
        } = &self.derivatives;
        // The multiplier cannot be above the norm of the gradient over the radius where the Hessian is positive.
        region.scale = iteration.gradient_norm * cost;
        for _ in 0..REFUSALS {
            let step = region.step(
                gradient,
                hessian,
                &self.norm,
                &mut self.factor,
                &mut iteration.factorisations,
            );
            let Some(Step { step, length }) = step else {
                return Ok(false);
            };
            move_by(objective, from, &step, to);
            let predicted = gradient.dot(&step) - 0.5 * step.dot(&hessian.product(&step));
            let gained = cost - objective.value(to)?;
            // Near the minimum rounding hides what is gained.
            let hidden = predicted.abs() <= ROUNDING * cost && gained.abs() <= ROUNDING * cost;
            let gain = if hidden { 1.0 } else { gained / predicted };
            iteration.damping = region.damping;
            iteration.step = length;
            region.learn(gain, length);
            if gain > SUFFICIENT {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The smallest eigenvalue of the Hessian relative to the metric of Gauss and Newton, and its vector, by inverse iteration. The
    /// derivatives are those where [`minimise`](Self::minimise) ended.
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

/// `from` less `step` in the unknown coefficients.
pub(super) fn move_by<P: PointCost<f64>>(
    objective: &Objective<'_, f64, P>,
    from: &DMatrix<f64>,
    step: &DVector<f64>,
    to: &mut DMatrix<f64>,
) {
    to.copy_from(from);
    let first = objective.grid().free.start * objective.dof();
    let unknowns = &mut to.as_mut_slice()[first..first + step.len()];
    for (to, step) in unknowns.iter_mut().zip(step.iter()) {
        *to -= step;
    }
}
