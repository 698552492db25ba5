//! A motion that is followed and replanned at the same time.

mod options;
mod pace;
mod plan;
mod search;
mod step;
mod workspace;

pub use options::TrackerOptions;
pub use plan::Command;
pub use step::{Outcome, Safety, Step};

use super::Direct;
use super::minimise::Candidate;
use crate::constraint::{Constraint, Constraints};
use crate::cost::CostWithControl;
use crate::curve::{Basis, Continuity, Curve};
use crate::error::{Error, Result, check_length};
use crate::model::Model;
use crate::motion::{Interrupt, PathMemory, Problem, Violation, path_of};
use crate::transcription::Grids;
use pace::Pace;
use plan::{Commander, Plan};
use search::{Checked, Searched};
use std::sync::Arc;
use std::time::Duration;
use workspace::{OnPlan, Workspace};

/// The number of intervals per quadrature point at which rows are scanned after the first search: the check of a plan
/// is finer.
const SCAN: usize = 3;

/// A motion to a goal that is followed and replanned at the same time, as the goal and the obstacles move.
///
/// The tracker has one plan that it follows, a polynomial that ends at rest, and at most one other that it improves: by
/// one or a few iterations of the [interior-point method](crate::nlp) per step, from the rest of the last one with its
/// multipliers (the real-time iteration of Diehl, Bock and Schlöder, *A real-time iteration scheme for nonlinear
/// optimization in optimal feedback control*, 2005), with a [fixed barrier parameter](TrackerOptions::barrier). The
/// rest of a polynomial is a polynomial of the same degree, so it is exact. A plan begins on the plan before it, at the
/// state of that at the current time, and feedback keeps the robot near it; only a robot that is
/// [far](TrackerOptions::largest_deviation) from its plan gets a plan from its measured state, within the time that is
/// left.
///
/// A plan replaces the one that is followed if it is *safe*: it begins there, ends at rest at the goal, and violates no
/// row by more than [`FEASIBLE`](super::DirectSettings::FEASIBLE) at the times of a [check](TrackerOptions::look), with
/// refined maxima as in [`violations`](crate::motion::violations); and if it costs [less](TrackerOptions::least_gain),
/// or the goal or the constraints have changed so that the old plan does not fulfil them. Otherwise the old plan is
/// followed, to its end at rest.
///
/// **Promises.** While [`Step::safety`] is [`Safety::Kept`], the rest of the plan keeps all current rows in the sense
/// above, and so does a robot that follows it to its end without a further step. After
/// [`set_constraints`](Self::set_constraints) the next step checks the plan before anything else; if the plan now
/// violates a row, each step reports it until there is a safe plan, and the old plan is followed meanwhile: a caller
/// that cannot wait has to brake. Obstacles are assumed to stand still where they were last set. The promises are about
/// plans for this model: they do not cover deviations of the robot from its plan, delays, or torques of the feedback.
///
/// Accelerations and torques may jump from one plan to the next. The time of running costs and rows that depend on it
/// begins anew with each plan.
///
/// **Memory.** It is allocated by [`new`](Self::new), [`set_constraints`](Self::set_constraints) and the first steps.
/// A later step allocates nothing, unless a function of the user does, there are equalities, or more maxima of rows
/// come near their bounds than in all steps before.
///
/// ```
/// use aghf::constraint::{Bounds, Constraints, TorqueLimits};
/// use aghf::cost::ControlEffort;
/// use aghf::direct::{Outcome, Tracker, TrackerOptions};
/// use aghf::motion::Problem;
/// let model = aghf::urdf::builtin_robot("pendulum_2")?;
/// let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.5, 0.0, 0.0], 2.0)?;
/// let state = Bounds::velocities(&model);
/// let kept = Constraints { state, torque: TorqueLimits::of(&model), stage: Default::default() };
/// let options = TrackerOptions::default();
/// let mut tracker = Tracker::new(&problem, kept, ControlEffort::new(&model), options)?;
/// let step = tracker.step(problem.start(), 0.0)?;
/// assert_eq!(step.outcome, Outcome::Working);
/// assert_eq!(step.command.u.len(), 2);
/// # Ok::<(), aghf::Error>(())
/// ```
pub struct Tracker<'a, K, P> {
    model: &'a Model,
    /// The goal, $[q; v]$ at rest.
    goal: Vec<f64>,
    constraints: Arc<Constraints<K>>,
    cost: P,
    options: TrackerOptions,
    grids: Grids,
    /// The problem of the last search.
    problem: Problem<'a>,
    plan: Plan,
    /// The rest of that plan, the plan that is tried, and one that is not safe yet, or not better.
    others: [Plan; 3],
    /// Whether the plan was for the same goal and constraints as the last one, if there is one.
    attempted: Option<bool>,
    /// The requested horizon for a goal.
    asked: Option<f64>,
    /// True if the plan ends at the goal.
    aims: bool,
    violated: Option<Violation>,
    /// True if the constraints have changed since the last check of the plan.
    unseen: bool,
    now: Option<f64>,
    pace: Pace,
    commander: Commander,
    workspace: Workspace<'a, K, P>,
    on_plan: OnPlan,
    memory: PathMemory,
    /// The state at which a plan begins.
    begin: Vec<f64>,
}

/// Refuses constraints that a tracker does not support.
fn check_constraints<K: Constraint>(constraints: &Constraints<K>) -> Result<()> {
    if constraints.torque.has_passive() {
        let condition = "a joint is passive, and the feedback needs all motors";
        return Err(Error::input("tracker", "torque", condition));
    }
    if constraints.windows().next().is_some() {
        let condition = "some are kept between two times, which the rest of a motion has passed";
        return Err(Error::input("tracker", "constraints", condition));
    }
    Ok(())
}

impl<'a, K: Constraint + Send + Sync, P: CostWithControl> Tracker<'a, K, P> {
    /// Searches the first plan, with the settings of `options`: that of `problem`, whose start may move, and whose goal
    /// is at rest. A known motion comes in as
    /// [`DirectSettings::start`](super::DirectSettings::start).
    ///
    /// # Errors
    /// Those of [`TrackerOptions::check`] and [`Direct::solve`]; a joint is passive; or the search finds no motion
    /// that keeps all rows.
    pub fn new(
        problem: &Problem<'a>,
        constraints: Constraints<K>,
        cost: P,
        mut options: TrackerOptions,
    ) -> Result<Self> {
        options.check(problem)?;
        let model = problem.model();
        check_constraints(&constraints)?;
        let direct = Direct::new(problem).cost(cost.clone()).constraints(&constraints);
        let found = direct.settings(options.settings.clone()).solve()?;
        options.settings.degree = found.curve.degree();
        (options.settings.start, options.settings.multipliers) = (None, None);
        (options.settings.time_limit, options.settings.interrupt) = (None, Interrupt::default());
        options.settings.search.scan = SCAN;
        let continuity = Continuity { fixed_accelerations: [false, true], ..options.settings.continuity(problem) };
        let basis = Basis::new(1, options.settings.degree, continuity);
        let motion = Candidate {
            multipliers: found.multipliers,
            points: found.points,
            ..Candidate::new(path_of(&found.curve, basis), found.curve.horizon())
        };
        let plan = Plan { motion, began: 0.0 };
        let (constraints, grids) = (Arc::new(constraints), Grids::default());
        let of = (&constraints, cost.clone());
        let workspace = Workspace::new((problem, &grids), of, &plan.motion, &options)?;
        let mut tracker = Self {
            model,
            goal: problem.goal().to_vec(),
            constraints,
            cost,
            options,
            grids,
            problem: problem.clone(),
            others: [(); 3].map(|()| plan.clone()),
            attempted: None,
            asked: None,
            aims: true,
            violated: None,
            unseen: false,
            now: None,
            pace: Pace::unknown(),
            commander: Commander::new(model),
            on_plan: OnPlan::new(&plan.motion, workspace.rows.parts()),
            plan,
            workspace,
            memory: PathMemory::default(),
            begin: Vec::new(),
        };
        tracker.centre()?;
        if let Some(Violation { row, by, at_s }) = tracker.look_at_rest(0.0)? {
            let label = tracker.constraints.label(row, model);
            let by = tracker.constraints.excess(row, by, model);
            let condition = format!(
                "no safe plan was found: the best one violates {} by {by:e} {} at {at_s} s",
                label.name, label.unit
            );
            return Err(Error::input("tracker", "first plan", condition));
        }
        Ok(tracker)
    }

    /// Changes the goal to a configuration at rest, `N` entries, rad or m, to be reached within `horizon`, s; a free
    /// horizon begins there.
    ///
    /// The old plan is followed until one to the new goal is safe; the horizon of that begins when it is found.
    ///
    /// # Errors
    /// `q` does not have `N` finite entries, or the horizon is shorter than the [shortest
    /// one](TrackerOptions::shortest_horizon) or out of range.
    pub fn set_goal(&mut self, q: &[f64], horizon: f64) -> Result<()> {
        check_length("q", self.model.dof(), q.len())?;
        if let Some(i) = q.iter().position(|x| !x.is_finite()) {
            let condition = format!("entry {i} is not a finite number");
            return Err(Error::input(self.model.name(), "start", condition));
        }
        Problem::check_horizon(horizon).map_err(|condition| Error::input(self.model.name(), "horizon", condition))?;
        if horizon < self.options.shortest_horizon {
            let condition = format!("it is {horizon} s, less than the shortest");
            return Err(Error::input("tracker", "horizon", condition));
        }
        let horizon = match self.options.settings.free_horizon {
            Some(free) => horizon.min(free.longest),
            None => horizon,
        };
        self.goal[..q.len()].copy_from_slice(q);
        (self.asked, self.aims) = (Some(horizon), false);
        self.others[2].motion.horizons.set(0, horizon);
        Ok(())
    }

    /// Replaces the constraints, such as obstacles that have moved, from the next step on.
    ///
    /// # Errors
    /// They are for another robot, a joint is passive, or some are kept for a part of the time; the old ones then
    /// remain.
    pub fn set_constraints(&mut self, constraints: Constraints<K>) -> Result<()> {
        constraints.check(self.model)?;
        check_constraints(&constraints)?;
        let constraints = Arc::new(constraints);
        let of = (&constraints, self.cost.clone());
        let (problem, grids) = (&self.problem, &self.grids);
        let motion = &self.plan.motion;
        self.workspace = Workspace::new((problem, grids), of, motion, &self.options)?;
        if constraints.dim() != self.constraints.dim() {
            // The multipliers are those of other rows.
            self.plan.motion.multipliers = Default::default();
            self.attempted = None;
        }
        (self.constraints, self.unseen) = (constraints, true);
        self.pace.is_first = true;
        Ok(())
    }

    /// The constraints that the next step keeps.
    #[must_use]
    pub fn constraints(&self) -> &Constraints<K> {
        &self.constraints
    }

    /// Changes the [deadline](TrackerOptions::deadline) of the next steps.
    pub fn set_deadline(&mut self, deadline: Option<Duration>) {
        self.options.deadline = deadline;
    }

    /// The goal, `N` entries.
    #[must_use]
    pub fn goal(&self) -> &[f64] {
        &self.goal[..self.model.dof()]
    }

    /// The rest of the plan after the last step, as a curve that begins there; of the last
    /// [seconds](TrackerOptions::shortest_horizon) all of it.
    ///
    /// # Errors
    /// None for a plan of the tracker.
    pub fn rest(&self) -> Result<Curve> {
        let now = self.now.unwrap_or(self.plan.began);
        self.curve(&self.plan.rest(now, self.options.shortest_horizon))
    }

    /// Takes a step: improves the plan as far as the time allows, and returns the command for now.
    ///
    /// * `state`: the measured state $[q; v]$, `2 N` entries; rad or m, per s
    /// * `now`: the time, s; the first plan begins at that of the first step
    ///
    /// With a [deadline](TrackerOptions::deadline) an iteration begins only if it and the check of its result are
    /// expected to end before the deadline, by the times of the last ones. The check of a plan after a change of the
    /// constraints and the command are never left out.
    ///
    /// # Errors
    /// `state` does not have `2 N` finite entries, or `now` is not finite or before that of the last step.
    ///
    /// # Cost
    /// Per iteration that of the direct method, O(p^2 N^3) and more for degree `p`; the command O(N^2).
    pub fn step(&mut self, state: &[f64], now: f64) -> Result<Step<'_>> {
        self.pace.begin(self.options.deadline);
        self.begin(state, now)?;
        self.commander.place(&self.plan, now);
        let mut deviation = self.commander.deviation(state);
        let mut left = deviation > self.options.largest_deviation;
        if self.unseen || self.violated.is_some() {
            (self.violated, self.unseen) = (self.look_at_rest(now)?, false);
        }
        let is_current = self.aims && self.violated.is_none() && !left;
        let mut searched = Searched::default();
        let short = self.plan.left(now) < self.options.shortest_horizon;
        if !(is_current && short) {
            let mut begin = std::mem::take(&mut self.begin);
            begin.clear();
            if left {
                begin.extend(state)
            } else {
                begin.extend(&self.commander.command.q);
                begin.extend(&self.commander.command.v);
            }
            searched = self.search(&begin, now, is_current)?;
            self.begin = begin;
        }
        if searched.replaced {
            self.commander.place(&self.plan, now);
            (deviation, left) = (self.commander.deviation(state), false);
        }
        self.commander.command(self.model, state, &self.options)?;
        let finished = self.aims && !left && self.plan.left(now) == 0.0;
        Ok(Step {
            outcome: if finished { Outcome::Finished } else { Outcome::Working },
            command: &self.commander.command,
            safety: match self.violated {
                Some(Violation { row, by, at_s }) => Safety::Violated { row, by, after: at_s },
                None if left => Safety::Left,
                None => Safety::Kept,
            },
            deviation,
            iterations: searched.iterations,
            replaced: searched.replaced,
            cut_off: searched.cut_off,
            converged: searched.converged,
        })
    }

    /// The row that the rest of the plan violates most; `None` if it is safe.
    fn look_at_rest(&mut self, now: f64) -> Result<Option<Violation>> {
        let (shortest, memory) = (self.options.shortest_horizon, &mut self.memory);
        self.plan.rest_in(now, shortest, memory, &mut self.others[0]);
        self.look(Checked::Reference)
    }

    /// Checks the arguments of a step.
    fn begin(&mut self, state: &[f64], now: f64) -> Result<()> {
        check_length("state", 2 * self.model.dof(), state.len())?;
        if let Some(i) = state.iter().position(|x| !x.is_finite()) {
            let condition = format!("entry {i} is not a finite number");
            return Err(Error::input("tracker", "state", condition));
        }
        if !now.is_finite() || self.now.is_some_and(|before| now < before) {
            let condition = format!("it is {now} s and must be a finite time not before the last step");
            return Err(Error::input("tracker", "now", condition));
        }
        if self.now.replace(now).is_none() {
            self.plan.began = now;
        }
        Ok(())
    }
}
