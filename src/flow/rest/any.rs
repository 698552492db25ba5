//! The flow of any Lagrangian to rest, without constraints.

use super::euler::{Euler, Progress, Stretch};
use super::{RestMetric, RestRecord};
use crate::curve::{Continuity, Curve};
use crate::error::{Error, Result, check_positive};
use crate::flow::weak::{Action, PointLagrangian, StateGrid};
use crate::motion::{Interrupt, Stopped, Watch};
use std::time::Duration;

/// The number of steps after which the metric is recomputed.
const FRESH: usize = 10;
/// The relative difference up to which the horizons of a grid and of a curve count as equal.
const ROUNDING: f64 = 1e-9;

/// The options of [`AnyFlowToRest`].
#[derive(Clone, Debug)]
pub struct AnyRestOptions {
    /// The metric of the descent.
    pub metric: RestMetric,
    /// The relative gradient norm at rest, $\sqrt{g^T D^{-1} g / A}$ in the metric of the action.
    pub tolerance: f64,
    /// The largest number of steps.
    pub steps: usize,
    /// The wall time after which the flow stops and returns the current curve.
    pub time_limit: Option<Duration>,
    /// The handle by which another thread stops the flow in the same way.
    pub interrupt: Interrupt,
}

impl Default for AnyRestOptions {
    fn default() -> Self {
        Self {
            metric: RestMetric::Action,
            tolerance: 1e-8,
            steps: 500,
            time_limit: None,
            interrupt: Interrupt::default(),
        }
    }
}

/// The result of the flow of any Lagrangian.
#[derive(Clone, Debug)]
pub struct AnyRest {
    /// The curve.
    pub curve: Curve,
    /// The action of the curve, by the quadrature of the grid.
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

/// The flow of any Lagrangian in its metric from a curve to rest, by the same implicit scheme as
/// [`FlowToRest`](super::FlowToRest), on one grid and without constraints. The ends of the curve are fixed. The
/// [guide](crate::guide::lagrangian) has an example.
///
/// The quadrature is that of the grid; compare with a finer one to check that it is accurate enough for the Lagrangian.
pub struct AnyFlowToRest<'a, L> {
    grid: &'a StateGrid<f64>,
    lagrangian: L,
    curve: &'a Curve,
    options: AnyRestOptions,
    observe: Box<dyn FnMut(&RestRecord) + 'a>,
}

impl<'a, L: PointLagrangian<f64>> AnyFlowToRest<'a, L> {
    /// The flow of `lagrangian` from `curve` on `grid` with default options.
    #[must_use]
    pub fn new(grid: &'a StateGrid<f64>, lagrangian: L, curve: &'a Curve) -> Self {
        Self {
            grid,
            lagrangian,
            curve,
            options: AnyRestOptions::default(),
            observe: Box::new(|_| {}),
        }
    }

    /// Replaces the options.
    #[must_use]
    pub fn options(self, options: AnyRestOptions) -> Self {
        Self { options, ..self }
    }

    /// Sets a function that is called before each step.
    #[must_use]
    pub fn observe(self, observe: impl FnMut(&RestRecord) + 'a) -> Self {
        let observe = Box::new(observe);
        Self { observe, ..self }
    }

    /// Follows the flow to rest.
    ///
    /// # Errors
    /// An option is out of range, the grid has another horizon than the curve or too low a degree, or the Lagrangian
    /// has another number of joints. A flow that does not come to rest is not an error: [`AnyRest::at_rest`] is false.
    pub fn run(mut self) -> Result<AnyRest> {
        let (grid, curve, options) = (self.grid, self.curve, &self.options);
        check(grid, curve, options)?;
        let watch = Watch::start(options.time_limit, &options.interrupt);
        let mut action = Action::new(grid, self.lagrangian, curve.dof());
        let mut progress = Progress::new(grid.fit(curve), 0.0);
        let stretch = Stretch {
            tolerance: options.tolerance,
            steps: options.steps,
            fresh: FRESH,
            metric: options.metric,
        };
        let mut look = |progress: &Progress| {
            (self.observe)(&progress.record((grid.segments(), grid.degree())));
            Ok(true)
        };
        let at_rest =
            Euler::new(&action).run(&mut action, &mut progress, stretch, &watch, &mut look)?;
        Ok(AnyRest {
            curve: grid.curve(&progress.coefficients, curve.horizon())?,
            action: progress.action,
            gradient_norm: progress.gradient_norm,
            at_rest,
            steps: progress.steps,
            factorisations: progress.factorisations,
            stopped: watch.stopped(),
        })
    }
}

/// Refuses invalid combinations of grid, curve and options.
fn check(grid: &StateGrid<f64>, curve: &Curve, options: &AnyRestOptions) -> Result<()> {
    check_positive("options", "tolerance", options.tolerance)?;
    let refuse = |what: &str, condition: String| Err(Error::input("grid", what, condition));
    let (own, horizon) = (grid.horizon(), curve.horizon());
    if (own - horizon).abs() > ROUNDING * horizon {
        let condition = format!("it is {own} s, that of the curve {horizon} s");
        return refuse("horizon", condition);
    }
    let (degree, least) = (grid.degree(), Continuity::default().smallest_degree());
    if degree < least {
        return refuse("degree", format!("it is {degree}, the least is {least}"));
    }
    Ok(())
}
