//! The flow to rest by an implicit scheme with unbounded steps, and multipliers where penalties are insufficient.
//!
//! The published flow follows $\partial x / \partial s = \Omega$ up to some `s_max` with an integrator that resolves
//! the path, and stalls; `proofs/penalty.md` explains this. Here only the end of the path matters, so that the steps in
//! `s` may be arbitrarily large.
//!
//! 1. The flow is discretised in its weak form, see [`weak`](super::weak): $D \dot c = -\nabla A(c)$ for the
//!    coefficients of a continuous piecewise polynomial in the state, a basis of `transcription`.
//! 2. A step of the implicit Euler method, $(\tfrac1h D + \nabla^2 A)\\, \delta = -\nabla A$ with the exact Hessian, is
//!    one of Newton's method with a multiple of the norm added to the Hessian: the [interior-point
//!    method](crate::nlp) with the metric of the flow as norm takes them, and adds none in the end (`program.rs`).
//! 3. Constraints are its rows, and the slip $\dot x_{P1} - x_{P2}$ and the torques of passive joints its equalities,
//!    whose multipliers replace large penalties (the idea is that of EL-AGHF, arXiv 2505.24751).
//! 4. The bases are those of the [direct method](crate::direct), each from the rest point of the one before
//!    (`walk.rs`). In two phases (the idea of BLAZE, arXiv 2505.01589), the first looks for a motion within the
//!    constraints almost regardless of its cost.
//!
//! [`LagrangianDescent`] performs the second step for any Lagrangian and metric. `proofs/weak_form.md` has the
//! derivations.

mod clock;
mod descent;
mod free;
mod program;
mod walk;

pub use super::weak::RestMetric;
pub use descent::{LagrangianDescent, LagrangianDescentOptions, LagrangianDescentSolution};

use crate::constraint::{Constraint, Constraints, NONE};
use crate::cost::{ControlEffort, CostWithControl};
use crate::curve::{Basis, Continuity, Curve};
use crate::direct::{DirectSettings, SearchOptions};
use crate::error::{Error, Result, check_count, check_positive};
use crate::motion::{Interrupt, Path, Problem, Stopped, Watch, curve_of};
use crate::nlp;
use crate::transcription::{Grids, Rows};
use std::time::Duration;
use walk::Shared;

/// The lowest degree without and with rows.
const MIN_DEGREE: [usize; 2] = [6, 9];
/// The amplitude of bent guesses without and with rows, rad or m; with passive joints, of many minima, the first.
const AMPLITUDE: [f64; 2] = [2.5, 1.0];
/// The largest number of guesses while none leads to a motion within the constraints.
const MAX_GUESSES: usize = 64;

/// The settings of a flow to rest.
#[derive(Clone, Debug)]
pub struct RestSettings {
    /// The degree of the polynomial, or of each segment.
    pub degree: usize,
    /// The number of polynomials on equal parts of the horizon. The state is continuous at their joints.
    pub segments: usize,
    /// The metric of the descent.
    pub metric: RestMetric,
    /// True for multipliers of the slip in addition to its penalty: $v = \dot q$ is then satisfied to a tolerance, and
    /// not only up to the inverse of the penalty.
    pub duals: bool,
    /// True to find a motion within the constraints in a first phase.
    pub two_phases: bool,
    /// The relative gradient norm at rest; see [`RestRecord::gradient_norm`].
    pub tolerance: f64,
    /// The largest violation of a row of the constraints, in rad, rad/s, m, N m or N.
    pub feasible: f64,
    /// The largest number of steps in the last basis.
    pub iterations: usize,
    /// The number of starts, the cubic between the ends and bent ones; more are tried while none leads to a motion
    /// within the constraints.
    pub starts: usize,
    /// The seed of the bends.
    pub seed: u64,
    /// An initial curve, used directly in the final basis.
    pub start: Option<Curve>,
    /// The wall time after which the flow stops and returns the best curve so far.
    pub time_limit: Option<Duration>,
    /// The handle by which another thread stops the flow in the same way.
    pub interrupt: Interrupt,
    /// The constants of the search, those of the direct method.
    pub search: SearchOptions,
    /// The options of the interior-point method, of which the tolerances and the number of iterations are those above.
    pub nlp: nlp::Options,
}

impl Default for RestSettings {
    fn default() -> Self {
        Self {
            degree: 16,
            segments: 1,
            metric: RestMetric::Velocity,
            duals: true,
            two_phases: false,
            tolerance: 1e-8,
            feasible: 1e-5,
            iterations: 500,
            starts: 1,
            seed: 0,
            start: None,
            time_limit: None,
            interrupt: Interrupt::default(),
            search: SearchOptions::default(),
            nlp: nlp::Options::default(),
        }
    }
}

impl RestSettings {
    /// The largest degree, and the largest degree times the number of segments.
    pub const MAX_DEGREE: usize = 64;
    /// The bound beyond which the Hessians of a large robot do not fit into memory.
    pub const MAX_SIZE: usize = 512;
    /// The largest number of starts.
    pub const MAX_STARTS: usize = 100_000;
    /// The largest number of steps, each of which is recorded.
    pub const MAX_ITERATIONS: usize = 100_000;

    /// Refuses values out of range.
    ///
    /// # Errors
    /// A setting is out of range, or the start is not a curve of the problem.
    pub fn check(&self, problem: &Problem<'_>) -> Result<()> {
        let degrees = Continuity::default().smallest_degree()..=Self::MAX_DEGREE;
        check_count("degree", self.degree, degrees)?;
        let segments = 1..=Self::MAX_SIZE / self.degree;
        check_count("segments", self.segments, segments)?;
        check_count("starts", self.starts, 1..=Self::MAX_STARTS)?;
        check_count("iterations", self.iterations, 1..=Self::MAX_ITERATIONS)?;
        for (what, value) in [("tolerance", self.tolerance), ("feasible", self.feasible)] {
            check_positive("settings", what, value)?;
        }
        let Some(start) = &self.start else {
            return Ok(());
        };
        problem.model().check("start", start.dof())?;
        let (x, last) = (start.x(), start.x().ncols() - 1);
        let ends = x.column(0).as_slice() == problem.start() && x.column(last).as_slice() == problem.goal();
        if !ends || start.horizon() != problem.horizon() {
            let condition = "it does not go from the start of the problem to its goal in its time";
            return Err(Error::input("settings", "start", condition));
        }
        Ok(())
    }

    /// The settings of the direct method with these bases and tolerances, without or with rows.
    fn as_direct(&self, rows: usize) -> DirectSettings {
        DirectSettings {
            degree: self.degree,
            segments: self.segments,
            tolerance: self.tolerance,
            iterations: self.iterations,
            lowest_degree: MIN_DEGREE[rows],
            search: self.search.clone(),
            nlp: self.nlp.clone(),
            ..DirectSettings::default()
        }
    }
}

/// A step of a flow to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestRecord {
    /// The homotopy variable after the step, in units of the metric relative to the action; a Newton step counts as ten
    /// times the largest step before it.
    pub s: f64,
    /// The action before the step, without the terms of multipliers.
    pub action: f64,
    /// The Newton decrement before the step, $\sqrt{g^T H^{-1} g / A}$ with the gradient and the matrix of the step.
    pub gradient_norm: f64,
    /// The number of segments.
    pub segments: usize,
    /// The degree of each.
    pub degree: usize,
}

/// The result of a flow to rest.
#[derive(Clone, Debug)]
pub struct RestSolution {
    /// The curve.
    pub curve: Curve,
    /// The action of the curve, with the terms of the multipliers.
    pub action: f64,
    /// The relative gradient norm; see [`RestRecord::gradient_norm`].
    pub gradient_norm: f64,
    /// The largest slip $|\dot x_{P1} - x_{P2}|_\infty$ at the quadrature points, rad/s or m/s.
    pub slip: f64,
    /// The largest violation of a row of the constraints, in its unit.
    pub violation: f64,
    /// The relative difference between the quadrature and a finer one.
    pub quadrature_error: f64,
    /// The largest torque of a passive joint between its collocated points, relative to the largest torque.
    pub passive_share: f64,
    /// True if the gradient vanishes and the constraints are satisfied, to the tolerances of the settings.
    pub at_rest: bool,
    /// The number of the guess that led to this result.
    pub guess: usize,
    /// The number of starts that were tried.
    pub starts: usize,
    /// Steps, factorisations and updates of multipliers, summed over all guesses and bases.
    pub steps: usize,
    /// Factorisations, summed as [`steps`](Self::steps).
    pub factorisations: usize,
    /// Updates of the multipliers of equalities, summed as [`steps`](Self::steps).
    pub rounds: usize,
    /// The progress from the guess that led to this result.
    pub history: Vec<RestRecord>,
    /// The reason of an early stop, if there was one.
    pub stopped: Option<Stopped>,
}

/// The flow of a Lagrangian $k |\dot x_{P1} - x_{P2}|^2 + l$ to rest, by default with the control effort for the running
/// cost $l$, without constraints and with default settings.
///
/// ```
/// use aghf::flow::rest::FlowToRest;
/// use aghf::motion::Problem;
/// let model = aghf::urdf::builtin_robot("pendulum_2")?;
/// let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.5, 0.0, 0.0], 2.0)?;
/// let solution = FlowToRest::new(&problem, 1e5).run()?;
/// assert!(solution.at_rest && solution.slip < 1e-6);
/// # Ok::<(), aghf::Error>(())
/// ```
pub struct FlowToRest<'a, K, P> {
    problem: &'a Problem<'a>,
    k: f64,
    cost: P,
    constraints: &'a Constraints<K>,
    settings: RestSettings,
    observe: Box<dyn FnMut(&RestRecord) + 'a>,
}

impl<'a> FlowToRest<'a, (), ControlEffort<'a, f64, f64>> {
    /// The flow of the control effort under the penalty `k` of the slip, without constraints, with default settings.
    #[must_use]
    pub fn new(problem: &'a Problem<'a>, k: f64) -> Self {
        Self {
            problem,
            k,
            cost: ControlEffort::new(problem.model()),
            constraints: &NONE,
            settings: RestSettings::default(),
            observe: Box::new(|_| {}),
        }
    }
}

impl<'a, K: Constraint, P: CostWithControl> FlowToRest<'a, K, P> {
    /// Replaces the running cost, which is one of the [direct method](crate::direct::Direct::cost).
    #[must_use]
    pub fn cost<Q: CostWithControl>(self, cost: Q) -> FlowToRest<'a, K, Q> {
        FlowToRest {
            problem: self.problem,
            k: self.k,
            cost,
            constraints: self.constraints,
            settings: self.settings,
            observe: self.observe,
        }
    }

    /// Replaces the constraints.
    #[must_use]
    pub fn constraints<L: Constraint>(self, constraints: &'a Constraints<L>) -> FlowToRest<'a, L, P> {
        FlowToRest {
            problem: self.problem,
            k: self.k,
            cost: self.cost,
            constraints,
            settings: self.settings,
            observe: self.observe,
        }
    }

    /// Replaces the settings.
    #[must_use]
    pub fn settings(self, settings: RestSettings) -> Self {
        Self { settings, ..self }
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
    /// A setting or the penalty is out of range; cost, constraints or start have another number of joints; or the
    /// integral of the cost becomes negative. A flow that does not come to rest is not an error:
    /// [`RestSolution::at_rest`] is false.
    pub fn run(self) -> Result<RestSolution> {
        let Self { problem, k, cost, constraints, ref settings, mut observe } = self;
        settings.check(problem)?;
        check_positive("flow", "k", k)?;
        let stage = &constraints.stage;
        stage.refuse_in_a_flow(problem.model().name(), false)?;
        let watch = Watch::start(settings.time_limit, &settings.interrupt);
        let grids = Grids::default();
        let rows = Rows::new(problem.model(), constraints, cost)?;
        let kind = usize::from(constraints.dim() > 0);
        let basis = Basis::new(1, MIN_DEGREE[kind], Continuity::default());
        let line = Path::line(problem, basis);
        let passive = constraints.torque.has_passive();
        let amplitude = AMPLITUDE[if passive { 0 } else { kind }];
        let (mut best, mut work): (Option<RestSolution>, _) = (None, [0; 3]);
        let mut number = 0;
        loop {
            let guess = match &settings.start {
                Some(start) => start.clone(),
                None => {
                    let bent = line.start(amplitude, settings.seed, number as u64);
                    curve_of(problem, &bent)?
                }
            };
            // The action above which a guess is not worth more segments.
            let known = best.as_ref().filter(|best| best.at_rest);
            let shared = Shared {
                problem,
                settings,
                k,
                rows: &rows,
                grids: &grids,
                watch: &watch,
                least: known.map_or(f64::INFINITY, |best| best.action),
            };
            let found = shared.from(number, guess, &mut *observe)?;
            let own = [found.steps, found.factorisations, found.rounds];
            for (sum, own) in work.iter_mut().zip(own) {
                *sum += own;
            }
            let mut now = match best {
                Some(best) if !is_better(&found, &best) => best,
                _ => found,
            };
            now.starts = number + 1;
            [now.steps, now.factorisations, now.rounds] = work;
            let enough = kind == 0 || now.at_rest;
            let over = watch.stopped().is_some() || settings.start.is_some();
            let most = if enough { settings.starts } else { settings.starts.max(MAX_GUESSES) };
            if over || now.starts >= most {
                return Ok(now);
            }
            number = now.starts;
            best = Some(now);
        }
    }
}

impl RestSolution {
    /// A curve that has not been checked.
    fn new(curve: Curve, guess: usize) -> Self {
        Self {
            curve,
            action: f64::NAN,
            gradient_norm: f64::INFINITY,
            slip: f64::NAN,
            violation: f64::NAN,
            quadrature_error: f64::NAN,
            passive_share: 0.0,
            at_rest: false,
            guess,
            starts: 1,
            steps: 0,
            factorisations: 0,
            rounds: 0,
            history: Vec::new(),
            stopped: None,
        }
    }

    /// The distance from a feasible motion.
    fn excess(&self) -> f64 {
        self.violation.max(self.slip).max(self.passive_share)
    }
}

/// Returns true if `a` is preferred: rest comes first, then the lower action, otherwise the smaller violation.
fn is_better(a: &RestSolution, b: &RestSolution) -> bool {
    match (a.at_rest, b.at_rest) {
        (true, true) => a.action < b.action,
        (false, false) => a.excess() < b.excess(),
        (a, _) => a,
    }
}
