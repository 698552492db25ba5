//! The flow of any Lagrangian to rest, without constraints.

use super::clock::Clock;
use super::free::Free;
use super::walk::{kkt, longest_step};
use super::{RestMetric, RestRecord};
use crate::curve::{Basis, Continuity, Curve};
use crate::direct::SearchOptions;
use crate::error::{Result, check_count, check_positive};
use crate::flow::weak::{DualLagrangian, Norm};
use crate::flow::{ActuationMetric, Lagrangian, Metric};
use crate::model::Model;
use crate::motion::{Interrupt, Path, Stopped, Watch};
use crate::nlp::{Nlp, Options, Status, solve};
use crate::transcription::Grid;
use std::time::Duration;

/// The options of [`LagrangianDescent`].
#[derive(Clone, Debug)]
pub struct LagrangianDescentOptions {
    /// The number of polynomials on equal parts of the horizon. The state is continuous at their joints.
    pub segments: usize,
    /// The degree of each, at least 4.
    pub degree: usize,
    /// The number of Gauss-Legendre points of each; by default 3.5 per degree, and 4 more. Compare with a larger one to
    /// check that the quadrature is accurate enough for the Lagrangian.
    pub points: Option<usize>,
    /// The metric of the descent.
    pub metric: RestMetric,
    /// The relative gradient norm at rest; see [`RestRecord::gradient_norm`].
    pub tolerance: f64,
    /// The largest number of steps.
    pub steps: usize,
    /// The wall time after which the flow stops and returns the current curve.
    pub time_limit: Option<Duration>,
    /// The handle by which another thread stops the flow in the same way.
    pub interrupt: Interrupt,
}

impl Default for LagrangianDescentOptions {
    fn default() -> Self {
        Self {
            segments: 1,
            degree: 16,
            points: None,
            metric: RestMetric::Velocity,
            tolerance: 1e-8,
            steps: 500,
            time_limit: None,
            interrupt: Interrupt::default(),
        }
    }
}

/// The result of the flow of any Lagrangian.
#[derive(Clone, Debug)]
pub struct LagrangianDescentSolution {
    /// The curve.
    pub curve: Curve,
    /// The action of the curve, by the quadrature of the flow.
    pub action: f64,
    /// The relative gradient norm.
    pub gradient_norm: f64,
    /// True if the gradient norm is below the tolerance.
    pub at_rest: bool,
    /// The number of steps.
    pub steps: usize,
    /// The number of factorisations.
    pub factorisations: usize,
    /// The reason of an early stop, if there was one.
    pub stopped: Option<Stopped>,
}

/// The flow of any Lagrangian in any metric from a curve to rest, by the same implicit scheme as
/// [`FlowToRest`](super::FlowToRest), in one basis and without constraints. The ends of the curve are fixed. The
/// [guide](crate::guide::lagrangian) has an example.
pub struct LagrangianDescent<'a, L, M = ActuationMetric> {
    model: &'a Model,
    lagrangian: L,
    metric: M,
    k: f64,
    curve: &'a Curve,
    options: LagrangianDescentOptions,
    observe: Box<dyn FnMut(&RestRecord) + 'a>,
}

impl<'a, L: Lagrangian> LagrangianDescent<'a, L> {
    /// The flow of `lagrangian` under the penalty `k` from `curve` with default options; the metric of the flow is the
    /// paper's.
    #[must_use]
    pub fn new(model: &'a Model, lagrangian: L, k: f64, curve: &'a Curve) -> Self {
        Self {
            model,
            lagrangian,
            metric: ActuationMetric::default(),
            k,
            curve,
            options: LagrangianDescentOptions::default(),
            observe: Box::new(|_| {}),
        }
    }
}

impl<'a, L: Lagrangian, M: Metric> LagrangianDescent<'a, L, M> {
    /// Replaces the options.
    #[must_use]
    pub fn options(self, options: LagrangianDescentOptions) -> Self {
        Self { options, ..self }
    }

    /// Replaces the metric of [`RestMetric::Flow`].
    #[must_use]
    pub fn metric<N: Metric>(self, metric: N) -> LagrangianDescent<'a, L, N> {
        LagrangianDescent {
            model: self.model,
            lagrangian: self.lagrangian,
            metric,
            k: self.k,
            curve: self.curve,
            options: self.options,
            observe: self.observe,
        }
    }

    /// Sets a function that is called after each step.
    #[must_use]
    pub fn observe(self, observe: impl FnMut(&RestRecord) + 'a) -> Self {
        let observe = Box::new(observe);
        Self { observe, ..self }
    }

    /// Follows the flow to rest.
    ///
    /// # Errors
    /// An option or the penalty is out of range, or curve, Lagrangian or metric have another number of joints. A flow
    /// that does not come to rest is not an error: [`LagrangianDescentSolution::at_rest`] is false.
    pub fn run(mut self) -> Result<LagrangianDescentSolution> {
        let (model, curve, options) = (self.model, self.curve, &self.options);
        options.check()?;
        check_positive("flow", "k", self.k)?;
        model.check("curve", curve.dof())?;
        let (segments, degree) = (options.segments, options.degree);
        let basis = Basis::new(segments, degree, Continuity::STATE);
        let path = Path::of_states(curve, basis.clone());
        let points = (SearchOptions::default().points * degree as f64) as usize + 4;
        let grid = Grid::new(&basis, options.points.unwrap_or(points), 1.0);
        let norm = Norm { model, kind: options.metric, metric: self.metric, k: self.k, horizon: curve.horizon() };
        let kkt = kkt(&grid, norm, &path.coefficients)?;
        let lagrangian = DualLagrangian::new(model, self.lagrangian, self.k);
        let watch = Watch::start(options.time_limit, &options.interrupt);
        let mut free = Free::new(&grid, lagrangian, path, curve.horizon(), &watch);
        let settings = Options::default();
        let settings = Options {
            tolerance: options.tolerance,
            iterations: options.steps,
            longest_step: longest_step(options.metric, &settings),
            ..settings
        };
        let (x, mut clock) = (free.unknowns(), Clock::default());
        let observe = &mut self.observe;
        let end = solve(&mut free, x, None, kkt, &settings, &mut |progress| {
            if let Some(record) = clock.tick(progress, (segments, degree)) {
                observe(&record);
            }
        })?;
        let action = free.value(&end.x, &mut Vec::new())?;
        Ok(LagrangianDescentSolution {
            curve: free.path.curve_of_states(curve.horizon())?,
            action,
            gradient_norm: end.progress.stationarity,
            at_rest: end.status == Status::Converged,
            steps: clock.steps,
            factorisations: clock.factorisations,
            stopped: watch.stopped(),
        })
    }
}

impl LagrangianDescentOptions {
    /// Refuses values out of range.
    fn check(&self) -> Result<()> {
        use super::RestSettings as Settings;
        let degrees = Continuity::default().smallest_degree()..=Settings::MAX_DEGREE;
        check_count("degree", self.degree, degrees)?;
        let segments = 1..=Settings::MAX_SIZE / self.degree;
        check_count("segments", self.segments, segments)?;
        if let Some(points) = self.points {
            check_count("points", points, 1..=Settings::MAX_SIZE)?;
        }
        check_positive("options", "tolerance", self.tolerance)
    }
}
