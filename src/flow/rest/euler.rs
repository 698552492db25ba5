//! The flow of an action by the implicit Euler method with growing steps.

use super::RestRecord;
use crate::error::Result;
use crate::flow::weak::{Action, ActionDerivatives, PointLagrangian};
use crate::linalg::{BlockTridiagonal, Region, Step, add_step};
use crate::motion::Watch;
use nalgebra::DMatrix;

/// The action below which a value is rounding error; gradients are not measured relative to less.
const SMALLEST_ACTION: f64 = f64::EPSILON;
/// The fraction of the predicted decrease that a step must achieve.
const SUFFICIENT: f64 = 1e-3;
/// The relative part of the action that rounding can hide.
const ROUNDING: f64 = 1e-13;
/// The number of cuts of a step before the step size shrinks, and the factor of a cut.
const CUTS: usize = 3;
const CUT: f64 = 0.4;
/// The largest number of consecutive rejected steps.
const REFUSALS: usize = 60;
/// The size of a Newton step, which is infinite, as a multiple of the largest step before it.
const NEWTON: f64 = 10.0;

crate::names::named_enum! {
/// The metric of a flow to rest. It changes the path, but not the condition at its end, where the gradient vanishes.
pub enum RestMetric("metric") {
    /// The Gauss-Newton metric of the action, which is the Hessian without what the curvature of the dynamics adds to
    /// it, relative to the action, and the Gram matrix of the velocities: as in the direct method.
    Action = "action",
    /// The metric of the flow, (11).
    Flow = "flow",
}
}

/// The termination criteria of one stretch of the flow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// The relative gradient norm at which the flow is at rest.
    pub tolerance: f64,
    /// The largest number of steps.
    pub steps: usize,
    /// The number of steps after which the metric of the action is recomputed.
    pub fresh: usize,
    /// The metric.
    pub metric: RestMetric,
}

/// The current state of the flow.
#[derive(Clone, Debug)]
pub(super) struct Progress {
    /// The coefficients, `2 N` by the number of functions.
    pub coefficients: DMatrix<f64>,
    /// $s$, in units of the metric.
    pub s: f64,
    /// The largest step in `s`.
    pub largest: f64,
    /// The action.
    pub action: f64,
    /// $\sqrt{g^T D^{-1} g / A}$ in the Gauss-Newton metric.
    pub gradient_norm: f64,
    /// The number of factorisations.
    pub factorisations: usize,
    /// The number of steps.
    pub steps: usize,
}

impl Progress {
    /// The state at the beginning of a stage.
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

    /// The progress record for this number of segments of this degree.
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

/// Scratch space of the steps.
pub(super) struct Euler {
    derivatives: ActionDerivatives<f64>,
    /// The Gauss-Newton Hessian, then its factor.
    convex: BlockTridiagonal<f64>,
    metric: BlockTridiagonal<f64>,
    gram: BlockTridiagonal<f64>,
    factor: BlockTridiagonal<f64>,
    region: Region,
    /// The number of steps after which the metric is recomputed.
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

    /// Requests that the next step recompute the metric.
    pub fn refresh(&mut self) {
        self.fresh = 0;
    }

    /// Follows the flow $D \dot c = -\nabla A$ until it is at rest, no step decreases the action, the number of steps
    /// is reached, or `look` returns false; returns true if it is at rest. A step of size `h` solves
    ///
    /// $$ \left( \tfrac1h D + \nabla^2 A \right) \delta = -\nabla A , $$
    ///
    /// the implicit Euler method with one step of Newton's method for its equation (a Rosenbrock method of order one).
    /// If the action decreases by less than a fraction of the prediction of its quadratic model, `h` shrinks; otherwise
    /// it grows, in the end without bound: the step size acts as a trust region.
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

    /// Computes the metrics of the current curve.
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
