//! The flow of an action by the implicit Euler method, with steps that grow.

use super::RestRecord;
use crate::error::Result;
use crate::flow::weak::{Action, ActionDerivatives, PointLagrangian};
use crate::linalg::{BlockTridiagonal, Region, Step, add_step};
use crate::motion::Watch;
use nalgebra::DMatrix;

/// The smallest action that gradients are measured against: below it all is rounding.
const SMALLEST_ACTION: f64 = f64::EPSILON;
/// The part of the predicted decrease that a step has to make.
const SUFFICIENT: f64 = 1e-3;
/// The part of the action that rounding can hide.
const ROUNDING: f64 = 1e-13;
/// The number of times that a step is cut before its size shrinks, and the factor by which.
const CUTS: usize = 3;
const CUT: f64 = 0.4;
/// The steps that may be refused one after the other.
const REFUSALS: usize = 60;
/// A step of Newton's method, of infinite size, counts as so many of the largest before it.
const NEWTON: f64 = 10.0;

crate::names::named_enum! {
/// The metric in which a flow to rest goes down. It bends the path; where that ends the gradient vanishes in any.
pub enum RestMetric("metric") {
    /// That of Gauss and Newton of the action, which is the Hessian without what the curvature of the dynamics adds to it, relative to the
    /// action, and the Gram matrix of the velocities: as the relaxation has.
    Action = "action",
    /// That of the flow, (11).
    Flow = "flow",
}
}

/// The demands on one stretch of the flow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// The relative gradient norm at which the flow is at rest.
    pub tolerance: f64,
    /// The most steps.
    pub steps: usize,
    /// After so many steps the metric of the action is that of the present curve again.
    pub fresh: usize,
    /// The metric.
    pub metric: RestMetric,
}

/// The flow on its way.
#[derive(Clone, Debug)]
pub(super) struct Progress {
    /// `2 N` by the number of functions.
    pub coefficients: DMatrix<f64>,
    /// $s$, in units of the metric.
    pub s: f64,
    /// The largest step in `s`.
    pub largest: f64,
    /// The action.
    pub action: f64,
    /// $\sqrt{g^T D^{-1} g / A}$ in the metric of Gauss and Newton.
    pub gradient_norm: f64,
    /// The number of factorisations.
    pub factorisations: usize,
    /// The number of steps.
    pub steps: usize,
}

impl Progress {
    /// At the beginning of a stage.
    pub fn new(coefficients: DMatrix<f64>, s: f64) -> Self {
        Self {
            coefficients,
            s,
            largest: 1.0,
            action: 0.0,
            gradient_norm: f64::INFINITY,
            factorisations: 0,
            steps: 0,
        }
    }

    /// The progress as it is told, in this number of segments of this degree.
    pub fn record(&self, (segments, degree): (usize, usize)) -> RestRecord {
        RestRecord {
            s: self.s,
            action: self.action,
            gradient_norm: self.gradient_norm,
            segments,
            degree,
        }
    }

    /// Counts a step of this size.
    fn advance(&mut self, step: f64) {
        let step = if step.is_finite() {
            step
        } else {
            NEWTON * self.largest
        };
        self.largest = self.largest.max(step);
        self.s += step;
    }
}

/// Room for the steps.
pub(super) struct Euler {
    derivatives: ActionDerivatives<f64>,
    /// The Hessian of Gauss and Newton, then its factor.
    convex: BlockTridiagonal<f64>,
    metric: BlockTridiagonal<f64>,
    gram: BlockTridiagonal<f64>,
    factor: BlockTridiagonal<f64>,
    region: Region,
    /// The number of steps after which the metric is measured again.
    fresh: usize,
}

impl Euler {
    pub fn new<L: PointLagrangian<f64>>(action: &Action<'_, f64, L>) -> Self {
        let gram = action.gram();
        Self {
            derivatives: ActionDerivatives::new(action.grid(), action.dof()),
            convex: gram.clone(),
            metric: gram.clone(),
            factor: gram.clone(),
            region: Region::default(),
            fresh: 0,
            gram,
        }
    }

    /// Has the metric measured again at the next step.
    pub fn refresh(&mut self) {
        self.fresh = 0;
    }

    /// Follows the flow $D \dot c = -\nabla A$ until it is at rest, or no step makes the action smaller, or there were as many as asked
    /// for, or `look` says no; returns whether it is at rest. A step of size `h` solves
    ///
    /// $$ \left( \tfrac1h D + \nabla^2 A \right) \delta = -\nabla A , $$
    ///
    /// the implicit Euler method with one step of Newton's method for its equation (a Rosenbrock method of order one). Where the action is
    /// not smaller afterwards by as much as its quadratic model says `h` shrinks, where it is it grows, in the end without bound:
    /// the size of steps is that of a trust region.
    pub fn run<L: PointLagrangian<f64>>(
        &mut self,
        action: &mut Action<'_, f64, L>,
        progress: &mut Progress,
        stretch: Stretch,
        watch: &Watch,
        look: &mut dyn FnMut(&Progress) -> Result<bool>,
    ) -> Result<bool> {
        let mut trial = progress.coefficients.clone();
        for _ in 0..stretch.steps {
            progress.action = action.derivatives(&progress.coefficients, &mut self.derivatives)?;
            let size = progress.action.abs().max(SMALLEST_ACTION);
            if progress.steps >= self.fresh || stretch.metric == RestMetric::Flow {
                self.measure(action, progress, stretch, size)?;
            }
            let mut natural = self.derivatives.gradient.clone();
            self.convex.solve(&mut natural);
            let gradient = &self.derivatives.gradient;
            progress.gradient_norm = (natural.dot(gradient) / size).sqrt();
            if progress.gradient_norm <= stretch.tolerance {
                return Ok(true);
            }
            if !look(progress)? {
                return Ok(false);
            }
            self.region.scale = progress.gradient_norm * size;
            let mut accepted = false;
            for _ in 0..REFUSALS {
                if watch.stopped().is_some() {
                    return Ok(false);
                }
                let found = self.region.step(
                    gradient,
                    &self.derivatives.hessian,
                    &self.metric,
                    &mut self.factor,
                    &mut progress.factorisations,
                );
                let Some(Step { step, length }) = found else {
                    return Ok(false);
                };
                let slope = gradient.dot(&step);
                let bend = step.dot(&self.derivatives.hessian.product(&step));
                let rounding = ROUNDING * size;
                let (mut share, mut ratio, mut value) = (1.0, f64::NAN, f64::NAN);
                for cut in 0..CUTS {
                    if cut > 0 {
                        share *= CUT;
                    }
                    // The first function is not free, nor the last.
                    let from = &progress.coefficients;
                    add_step(from, from.nrows(), &step, share, &mut trial);
                    value = action.value(&trial)?;
                    let promised = -share * (slope + 0.5 * share * bend);
                    let gained = progress.action - value;
                    // Near rest rounding hides what is gained.
                    let hidden = promised.abs() <= rounding && gained.abs() <= rounding;
                    ratio = if hidden { 1.0 } else { gained / promised };
                    if ratio > SUFFICIENT {
                        break;
                    }
                }
                accepted = ratio > SUFFICIENT;
                let trust = if accepted && share < 1.0 { 0.0 } else { ratio };
                self.region.learn(trust, share * length);
                if accepted {
                    std::mem::swap(&mut progress.coefficients, &mut trial);
                    progress.action = value;
                    progress.steps += 1;
                    progress.advance(share / self.region.damping);
                    break;
                }
            }
            if !accepted {
                return Ok(false);
            }
        }
        Ok(false)
    }

    /// The metrics of the present curve.
    fn measure<L: PointLagrangian<f64>>(
        &mut self,
        action: &mut Action<'_, f64, L>,
        progress: &Progress,
        stretch: Stretch,
        size: f64,
    ) -> Result<()> {
        self.fresh = progress.steps + stretch.fresh;
        action.gauss_newton(&progress.coefficients, &mut self.convex)?;
        match stretch.metric {
            RestMetric::Action => self.metric.set_sum(&self.gram, size.recip(), &self.convex),
            RestMetric::Flow => action.metric(&progress.coefficients, &mut self.metric)?,
        }
        self.factor.clone_from(&self.convex);
        if !self.convex.factorise() {
            self.convex.set_sum(&self.factor, size, &self.gram);
            self.convex.factorise();
        }
        Ok(())
    }
}
