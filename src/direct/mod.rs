//! The direct method: minimisation of the control effort, or another cost, over polynomials within constraints.
//!
//! On the manifold $v = \dot q$, which is the limit $k \to \infty$ of the penalty, the action is the control effort
//! $\int |u|^2 dt$ with $u = ID(q, \dot q, \ddot q)$. Neither `k` nor `s_max` appears: `q(t)` is a polynomial that
//! meets the boundary conditions, its free coefficients are the unknowns, and the integral is computed by
//! Gauss-Legendre quadrature with as many points as needed.
//!
//! [`Direct::solve`] is the whole algorithm:
//!
//! 1. `strategy/multistart.rs`: several starts, the cubic between the ends and the same with random bends, are
//!    minimised at a low degree. Those that cost little more than the best one before them go on to the next degree,
//!    from their previous end, and so on up to the degree and the segments of the settings. While none of them ends
//!    within the constraints, more starts are tried, every other one along a path that [`plan`](crate::plan) finds
//!    around the obstacles. If the first start is planned, it satisfies all constraints, and so does the final motion,
//!    whether or not it is a minimum. Within a time limit a path is planned first, for a search that is cut off.
//! 2. `minimise`: one minimisation, a nonlinear program whose unknowns are the coefficients and a free horizon, and
//!    whose rows are those of the constraints at the quadrature points. `nlp` solves it by a primal-dual interior-point
//!    method with exact Hessians and a line search (Nocedal and Wright, chapter 19; Wächter and Biegler, 2006). Each
//!    row has a slack and an elastic variable with an exact penalty, so a start may violate rows. A dense scan finds
//!    violations between the points. Without rows it is Newton's method.
//! 3. `strategy/degree.rs`: higher degrees until the cost settles, if requested.
//!
//! [`DirectSequence`] solves one after the other, each from the motion of the one before: for the least time, and on
//! other horizons. `transcription` computes integrals of running costs and rows and their derivatives; `cost` has
//! user-defined costs; [`SearchOptions`] and [`nlp::Options`](crate::nlp::Options) have all constants.

mod fixed_ends;
mod goal;
mod minimise;
mod options;
mod parts;
mod period;
mod sequence;
mod settings;
mod solution;
mod strategy;
mod tracker;
mod waypoint;

pub use goal::{GoalEnd, GoalSet};
pub use options::{SearchOptions, SequenceOptions};
pub use period::Period;
pub use sequence::DirectSequence;
pub use settings::{DirectSettings, PlannedStarts};
pub use solution::{DirectSolution, Iteration};
pub use strategy::{DegreeRefinement, FreeHorizon, LocalMinimum};
pub use tracker::{Command, Outcome, Safety, Step, Tracker, TrackerOptions};
pub use waypoint::Waypoint;

use crate::constraint::{Constraint, Constraints, NONE};
use crate::cost::{ControlEffort, CostWithControl};
use crate::curve::Curve;
use crate::error::{Error, Result};
use crate::motion::{Problem, Watch};
use crate::transcription::{Grids, Rows};
use fixed_ends::check_ends;
pub use minimise::Multipliers;
pub(crate) use minimise::working_set::{WorkingSet, equalities};
use minimise::{Candidate, Context, minimise};
pub(crate) use minimise::{Integrand, Stage};
pub(crate) use settings::Level;
use strategy::{MultistartOutcome, Planned, minimise_to_the_end, multistart, nearest_times, refine};

/// A problem with a running cost, constraints and settings, to be solved.
///
/// ```
/// use aghf::motion::Problem;
/// use aghf::direct::{Direct, DirectSettings};
/// let model = aghf::urdf::builtin_robot("pendulum_2")?;
/// let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.5, 0.0, 0.0], 2.0)?;
/// let settings = DirectSettings { degree: 9, ..DirectSettings::default() };
/// let solution = Direct::new(&problem).settings(settings).solve()?;
/// assert!(solution.converged);
/// # Ok::<(), aghf::Error>(())
/// ```
pub struct Direct<'a, K, P> {
    problem: &'a Problem<'a>,
    constraints: &'a Constraints<K>,
    cost: P,
    settings: DirectSettings,
    observe: Box<dyn FnMut(&Iteration) + 'a>,
}

impl<'a> Direct<'a, (), ControlEffort<'a, f64, f64>> {
    /// The problem of least control effort without constraints, with default settings.
    #[must_use]
    pub fn new(problem: &'a Problem<'a>) -> Self {
        Self {
            problem,
            constraints: &NONE,
            cost: ControlEffort::new(problem.model()),
            settings: DirectSettings::default(),
            observe: Box::new(|_| {}),
        }
    }
}

impl<'a, K: Constraint + Send + Sync, P: CostWithControl> Direct<'a, K, P> {
    /// Replaces the running cost.
    #[must_use]
    pub fn cost<Q: CostWithControl>(self, cost: Q) -> Direct<'a, K, Q> {
        Direct {
            problem: self.problem,
            constraints: self.constraints,
            cost,
            settings: self.settings,
            observe: self.observe,
        }
    }

    /// Replaces the constraints.
    #[must_use]
    pub fn constraints<L: Constraint + Send + Sync>(self, constraints: &'a Constraints<L>) -> Direct<'a, L, P> {
        Direct { problem: self.problem, constraints, cost: self.cost, settings: self.settings, observe: self.observe }
    }

    /// Replaces the settings.
    #[must_use]
    pub fn settings(self, settings: DirectSettings) -> Self {
        Self { settings, ..self }
    }

    /// Sets a function that is called after each iteration.
    #[must_use]
    pub fn observe(self, observe: impl FnMut(&Iteration) + 'a) -> Self {
        Self { observe: Box::new(observe), ..self }
    }

    /// Refuses phases that differ from those of the cost, or that do not consist of whole segments.
    fn check_phases(&self, phases: usize) -> Result<()> {
        let refuse = |what: &str, condition: String| Err(Error::input("settings", what, condition));
        let stage = &self.constraints.stage;
        if !stage.phases.is_empty() && stage.phases.len() != phases {
            let given = stage.phases.len();
            return refuse("phases", format!("there are {given}, the cost has {phases}"));
        }
        let segments = self.settings.segments;
        if !segments.is_multiple_of(phases) {
            let condition = format!("it is {segments} and must be a multiple of the {phases} phases");
            return refuse("segments", condition);
        }
        if phases > 1 && self.settings.continuous_acceleration {
            let condition = "accelerations jump where the foot changes".to_owned();
            return refuse("continuous_acceleration", condition);
        }
        let parts = self.settings.parts.len();
        if phases > 1 && parts > 0 && parts != phases {
            let condition = format!("there are {phases} phases");
            return refuse("parts", condition);
        }
        if phases > 1 && self.constraints.torque.has_passive() {
            return refuse("phases", "a joint has no motor".to_owned());
        }
        Ok(())
    }

    /// Finds a motion of locally least cost.
    ///
    /// # Errors
    /// A setting is out of range; the cost, the constraints or the start have another number of joints; a given end
    /// violates a row of the state; or the integral of the cost becomes negative. A search that ends outside the
    /// constraints or before its tolerance is not an error: the solution reports it.
    pub fn solve(mut self) -> Result<DirectSolution> {
        let (problem, settings) = (self.problem, &self.settings);
        settings.check(problem)?;
        let phases = self.cost.phases();
        self.check_phases(phases)?;
        check_ends(problem, settings, &self.constraints.state)?;
        let grids = Grids::default();
        let rows = Rows::new(problem.model(), self.constraints, self.cost.clone())?;
        self.check_multipliers(rows.count())?;
        let watch = Watch::start(settings.time_limit, &settings.interrupt);
        let given = Context {
            problem,
            grids: &grids,
            rows: &rows,
            watch: &watch,
            settings,
            free_horizon: settings.free_horizon,
            goal: settings.goal.as_ref(),
        };
        let planned = Planned::new(given)?;
        let longest = settings.free_horizon.map(|free| free.longest);
        let from = match (&settings.start, longest.or(settings.longest_horizon)) {
            (Some(curve), _) => problem_of_start(problem, curve, settings)?,
            (None, Some(longest)) => problem.with_horizon(planned.first_horizon(longest)?)?,
            (None, None) => problem.clone(),
        };
        let context = Context { problem: &from, ..given };
        let mut iterations = Vec::new();
        let observe = &mut self.observe;
        let mut log = |iteration: Iteration| {
            observe(&iteration);
            iterations.push(iteration);
        };
        let mut outcome = match &settings.start {
            Some(curve) => from_curve(context, curve, &mut log)?,
            None => {
                let passive = self.constraints.torque.has_passive();
                let phases = phases.max(settings.parts.len());
                let levels = settings.levels(settings.continuity(&from), passive, phases);
                multistart(context, &levels, &planned, &mut log)?
            }
        };
        let (best, adapted) = refine(settings, outcome.best, |from, basis| {
            let mut higher = from.clone();
            higher.change_basis(basis);
            minimise(context, higher, settings.highest(), &mut log)
        })?;
        outcome.best = best;
        let found = DirectSolution::of(&from, outcome)?;
        let free_horizon = settings.free_horizon;
        Ok(DirectSolution { stopped: watch.stopped(), adapted, iterations, free_horizon, ..found })
    }

    /// Refuses multipliers of another number of rows.
    fn check_multipliers(&self, needed: usize) -> Result<()> {
        match &self.settings.multipliers {
            Some(known) if known.rows() != needed => {
                let found = known.rows();
                let condition = format!("they are those of {found} rows, there are {needed}");
                Err(Error::input("settings", "multipliers", condition))
            }
            _ => Ok(()),
        }
    }
}

/// One minimisation from a given curve.
fn from_curve<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    curve: &Curve,
    log: &mut dyn FnMut(Iteration),
) -> Result<MultistartOutcome> {
    let Context { problem, settings, .. } = context;
    let start = Candidate::of_curve(curve, problem, settings);
    let start = Candidate {
        times: nearest_times(&start.path, problem, &settings.waypoints),
        multipliers: settings.multipliers.clone().unwrap_or_default(),
        penalty: Some(settings.search.planned_penalty),
        alternative: settings.goal.as_ref().map_or(0, |goal| goal.nearest(curve)),
        ..start
    };
    let guess = start.clone();
    let best = minimise_to_the_end(context, start, settings.highest(), f64::INFINITY, log)?;
    Ok(MultistartOutcome {
        best,
        first_costs: Vec::new(),
        minima: Vec::new(),
        curves: Vec::new(),
        best_start: (None, guess),
    })
}

/// The problem with the horizon of an initial curve, if the horizon is free, and with its end, if the goal is a set.
fn problem_of_start<'a>(problem: &Problem<'a>, start: &Curve, settings: &DirectSettings) -> Result<Problem<'a>> {
    let mut own = problem.clone();
    if let Some(free) = &settings.free_horizon {
        own = own.with_horizon(start.horizon().clamp(free.shortest, free.longest))?;
    }
    if settings.goal.is_some() {
        let (end, _) = start.at(start.horizon());
        own = own.with_final_position(&end.as_slice()[..start.dof()])?;
    }
    Ok(own)
}
