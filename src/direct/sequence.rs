//! Solves one after the other, each from the motion of the one before.

use super::{Direct, DirectSettings, DirectSolution, FreeHorizon, GoalEnd, Iteration, Multipliers, SequenceOptions};
use crate::constraint::{Constraint, Constraints};
use crate::cost::CostWithControl;
use crate::error::Result;
use crate::motion::{Problem, Stopped};
use std::time::Instant;

/// The factor by which the horizon of a faster motion may be longer than before, because of rounding.
const NOT_LONGER: f64 = 1.0 + 1e-6;

/// Solves of one problem, each from the motion of the one before, within the time limit of the settings: for the least
/// time, for a balance of time and cost, and on other horizons.
///
/// ```
/// use aghf::constraint::{Bounds, Constraints, StageConstraints, TorqueLimits};
/// use aghf::cost::ControlEffort;
/// use aghf::direct::{DirectSequence, DirectSettings, FreeHorizon};
/// use aghf::motion::Problem;
///
/// let model = aghf::urdf::builtin_robot("pendulum_2")?;
/// let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.5, 0.0, 0.0], 2.0)?;
/// let (state, stage) = (Bounds::velocities(&model), StageConstraints::default());
/// let limits = Constraints { state, torque: TorqueLimits(Vec::new()), stage };
/// let free_horizon = Some(FreeHorizon { shortest: 0.1, longest: 10.0, weight: 0.0 });
/// let settings = DirectSettings { degree: 9, free_horizon, ..DirectSettings::default() };
/// let mut solves = DirectSequence::new(problem, ControlEffort::new(&model), &limits).settings(settings);
/// let fast = solves.least_time(1.0)?;
/// let slow = solves.at(&fast, 2.0 * fast.curve.horizon())?;
/// assert!(fast.is_feasible() && slow.cost < fast.cost);
/// # Ok::<(), aghf::Error>(())
/// ```
pub struct DirectSequence<'s, K, P> {
    problem: Problem<'s>,
    constraints: &'s Constraints<K>,
    cost: P,
    settings: DirectSettings,
    options: SequenceOptions,
    observe: Box<dyn FnMut(&Iteration) + 's>,
    started: Instant,
    /// The reason why the last solve stopped early, if it did.
    stopped: Option<Stopped>,
    /// False if the last solve was not reached, or led to nothing better than the one before.
    is_complete: bool,
}

impl<'s, K, P> DirectSequence<'s, K, P> {
    /// Solves of a problem with this running cost within constraints, with default settings and options.
    #[must_use]
    pub fn new(problem: Problem<'s>, cost: P, constraints: &'s Constraints<K>) -> Self {
        Self {
            problem,
            constraints,
            cost,
            settings: DirectSettings::default(),
            options: SequenceOptions::default(),
            observe: Box::new(|_| {}),
            started: Instant::now(),
            stopped: None,
            is_complete: true,
        }
    }

    /// Replaces the settings of the solves.
    #[must_use]
    pub fn settings(self, settings: DirectSettings) -> Self {
        Self { settings, ..self }
    }

    /// Replaces the options.
    #[must_use]
    pub fn options(self, options: SequenceOptions) -> Self {
        Self { options, ..self }
    }

    /// Sets a function that is called after each iteration.
    #[must_use]
    pub fn observe(self, observe: impl FnMut(&Iteration) + 's) -> Self {
        Self { observe: Box::new(observe), ..self }
    }

    /// Sets the time at which the time limit begins; by default that of [`new`](Self::new).
    #[must_use]
    pub fn started(self, started: Instant) -> Self {
        Self { started, ..self }
    }
}

impl<K: Constraint + Send + Sync, P: CostWithControl> DirectSequence<'_, K, P> {
    /// The motion of the settings: one solve, or two with [`fixed_first`](SequenceOptions::fixed_first).
    ///
    /// # Errors
    /// Those of [`Direct::solve`].
    pub fn first(&mut self) -> Result<DirectSolution> {
        self.first_with(self.settings.clone())
    }

    fn first_with(&mut self, settings: DirectSettings) -> Result<DirectSolution> {
        let Some(free) = settings.free_horizon.filter(|_| self.options.fixed_first) else {
            return self.solve(&self.problem.clone(), settings);
        };
        let fixed = DirectSettings { free_horizon: None, ..settings };
        let before = self.solve(&self.problem.clone(), fixed)?;
        if self.should_continue(&before) {
            let in_parts = !self.settings.parts.is_empty();
            let horizon = if in_parts { before.curve.horizon() } else { self.problem.horizon() };
            let found = self.from(&before, horizon, Some(free), None, 0)?;
            if found.is_feasible() {
                return Ok(joined(before, found));
            }
        }
        Ok(DirectSolution { converged: false, ..before })
    }

    /// The motion of least time on a free horizon: the cost has a weight that vanishes. The first motion weighs a
    /// second like `weight` of the cost.
    ///
    /// # Errors
    /// Those of [`Direct::solve`].
    pub fn least_time(&mut self, weight: f64) -> Result<DirectSolution> {
        let (first, others) = self.faster(weight)?;
        Ok(self.whole(first, others))
    }

    /// The least cost within [`balanced`](SequenceOptions::balanced) times the least time, from the slowest of the
    /// motions that led to that; `weight` is that of [`least_time`](Self::least_time).
    ///
    /// # Errors
    /// Those of [`Direct::solve`].
    pub fn balanced(&mut self, weight: f64) -> Result<DirectSolution> {
        let (mut first, mut others) = self.faster(weight)?;
        let SequenceOptions { balanced, slowed, .. } = self.options;
        let fast = others.last().unwrap_or(&first);
        let is_least = self.is_complete;
        self.is_complete = self.should_continue(fast);
        if self.is_complete {
            let least = fast.curve.horizon();
            let within = |of: &&DirectSolution| of.curve.horizon() <= balanced * least;
            let slow = [&first].into_iter().chain(&others).find(within);
            let slow = slow.unwrap_or(fast);
            let horizon = slow.curve.horizon().max(slowed * least);
            let found = self.at_most(slow, horizon, balanced * least)?;
            // Otherwise the fast motion remains.
            self.is_complete = found.is_feasible();
            if self.is_complete {
                others.push(found);
            } else {
                let fast = others.last_mut().unwrap_or(&mut first);
                fast.iterations.extend(found.iterations);
            }
        }
        self.is_complete &= is_least;
        Ok(self.whole(first, others))
    }

    /// The least cost on a given horizon, from another motion stretched to it.
    ///
    /// # Errors
    /// Those of [`Direct::solve`].
    pub fn at(&mut self, from: &DirectSolution, horizon: f64) -> Result<DirectSolution> {
        self.repeated(from, horizon, None)
    }

    /// The least cost on a horizon of at most `longest`, from another motion stretched to `horizon`.
    ///
    /// # Errors
    /// Those of [`Direct::solve`].
    pub fn at_most(&mut self, from: &DirectSolution, horizon: f64, longest: f64) -> Result<DirectSolution> {
        let free = self.weighted(0.0).map(|free| FreeHorizon { longest: free.longest.min(longest), ..free });
        self.repeated(from, horizon, free)
    }

    /// Motions each of which is faster than the one before: first one that weighs a second like `weight` of the cost,
    /// then with a weight of the cost that vanishes in steps, each from the motion before.
    fn faster(&mut self, weight: f64) -> Result<(DirectSolution, Vec<DirectSolution>)> {
        let SequenceOptions {
            time_share,
            min_time_share,
            last_time_share,
            same_horizon,
            part_of_starts,
            max_repeats,
            ..
        } = self.options;
        let mut weight_before = weight;
        let mut settings = self.settings.clone();
        settings.free_horizon = self.weighted(weight_before);
        settings.time_limit = settings.time_limit.map(|limit| limit.mul_f64(part_of_starts));
        let mut first = self.first_with(settings)?;
        let is_last = |weight: f64, of: &DirectSolution| weight * of.curve.horizon() >= last_time_share * of.cost;
        // A start may be the last of such motions.
        if self.settings.start.is_some() && is_last(weight, &first) && first.converged && first.is_feasible() {
            return Ok((first, Vec::new()));
        }
        let (mut others, mut share, mut again) = (Vec::new(), time_share, 0);
        for _ in 0..self.options.max_weights {
            let before = others.last().unwrap_or(&first);
            self.is_complete = self.should_continue(before);
            if !self.is_complete {
                break;
            }
            let horizon = before.curve.horizon();
            let (density, weight) = (before.cost / horizon, share * before.cost / horizon);
            let multipliers = before.multipliers.reweighted(density, [weight_before, weight]);
            let free = self.weighted(weight);
            let next = self.from(before, horizon, free, Some(multipliers), again)?;
            let later = next.curve.horizon() / horizon;
            let is_faster = next.is_feasible() && later <= NOT_LONGER;
            // A search that fails may return the motion with which it began.
            let is_better = is_faster && (next.converged || later * same_horizon <= 1.0);
            self.is_complete = next.converged && next.is_feasible() && later <= same_horizon;
            let ends = if self.is_complete { is_last(weight, &next) } else { is_better };
            if is_better {
                weight_before = weight;
                others.push(next);
            } else {
                let before = others.last_mut().unwrap_or(&mut first);
                before.iterations.extend(next.iterations);
            }
            again = if self.is_complete || again == max_repeats { 0 } else { again + 1 };
            share = match (self.is_complete, others.is_empty()) {
                _ if ends => break,
                _ if again > 0 => share,
                (true, _) => time_share,
                // Half of the way there on a logarithmic scale.
                (false, true) if share > min_time_share => share.sqrt(),
                (false, false) if share > last_time_share => last_time_share,
                _ => break,
            };
        }
        Ok((first, others))
    }

    /// The last motion, with the starts of the first one and the iterations of all.
    fn whole(&self, first: DirectSolution, others: Vec<DirectSolution>) -> DirectSolution {
        let found = others.into_iter().fold(first, joined);
        DirectSolution { converged: found.converged && self.is_complete, stopped: self.stopped, ..found }
    }

    /// Returns true if a sequence continues from this motion: it keeps its constraints, and there is time.
    fn should_continue(&self, found: &DirectSolution) -> bool {
        found.is_feasible() && self.settings.has_time(self.started)
    }

    /// One solve from a motion without known multipliers, and further ones with larger penalties until one leads to a
    /// minimum.
    fn repeated(
        &mut self,
        from: &DirectSolution,
        horizon: f64,
        free_horizon: Option<FreeHorizon>,
    ) -> Result<DirectSolution> {
        let mut found = self.from(from, horizon, free_horizon, None, 0)?;
        for again in 1..=self.options.max_repeats {
            if found.converged || !self.should_continue(from) {
                break;
            }
            let mut other = self.from(from, horizon, free_horizon, None, again)?;
            let mut iterations = std::mem::take(&mut found.iterations);
            iterations.append(&mut other.iterations);
            let is_better = other.converged || (other.is_feasible() && !found.is_feasible());
            let better = if is_better { other } else { found };
            found = DirectSolution { iterations, ..better };
        }
        Ok(found)
    }

    /// The bounds of the horizon with another cost of a second.
    fn weighted(&self, weight: f64) -> Option<FreeHorizon> {
        self.settings.free_horizon.map(|free| FreeHorizon { weight, ..free })
    }

    /// One solve from a motion, to its alternative of a goal that is a set, on a horizon within the bounds, with
    /// multipliers for its objective if they are known, and with larger penalties if it is done `again`.
    fn from(
        &mut self,
        from: &DirectSolution,
        horizon: f64,
        free_horizon: Option<FreeHorizon>,
        multipliers: Option<Multipliers>,
        again: i32,
    ) -> Result<DirectSolution> {
        let horizon = free_horizon.map_or(horizon, |free| horizon.clamp(free.shortest, free.longest));
        let (curve, alternative) = (&from.curve, from.alternative);
        let q_of = |x: &[f64]| x[..curve.dof()].to_vec();
        let goal = self.settings.goal.as_ref();
        let goal = goal.map(|goal| {
            let last = curve.x().column(curve.x().ncols() - 1);
            goal.with_end(&GoalEnd { q: q_of(last.as_slice()), alternative })
        });
        let mut waypoints = self.settings.waypoints.clone();
        for (waypoint, time) in waypoints.iter_mut().zip(&from.waypoint_times) {
            waypoint.guesses = vec![q_of(curve.at(*time).0.as_slice())];
        }
        let limit = self.settings.time_limit;
        let mut settings = DirectSettings {
            waypoints,
            // The basis of a planned start is its own.
            degree: curve.degree(),
            segments: curve.segments(),
            start: Some(curve.stretched(horizon)?),
            multipliers,
            start_is_minimum: false,
            free_horizon,
            goal,
            time_limit: limit.map(|limit| limit.saturating_sub(self.started.elapsed())),
            ..self.settings.clone()
        };
        settings.search.planned_penalty *= self.options.penalty_factor.powi(again);
        let problem = self.problem.with_horizon(horizon)?;
        let found = self.solve(&problem, settings)?;
        Ok(DirectSolution { alternative, ..found })
    }

    /// One solve.
    fn solve(&mut self, problem: &Problem<'_>, settings: DirectSettings) -> Result<DirectSolution> {
        let found = Direct::new(problem)
            .cost(self.cost.clone())
            .constraints(self.constraints)
            .settings(settings)
            .observe(&mut *self.observe)
            .solve()?;
        self.stopped = found.stopped;
        Ok(found)
    }
}

/// A motion that was found from another one, with the starts of the other one and the iterations of both. The minima of
/// another objective are not minima here.
fn joined(before: DirectSolution, mut found: DirectSolution) -> DirectSolution {
    let mut iterations = before.iterations;
    iterations.append(&mut found.iterations);
    DirectSolution {
        iterations,
        start_costs: before.start_costs,
        best_start: before.best_start,
        alternative: before.alternative,
        first_guess: before.first_guess,
        minima: Vec::new(),
        minima_curves: Vec::new(),
        ..found
    }
}
