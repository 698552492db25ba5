//! The search of the direct method for the motion of an objective: one solve, or one after the other for a preset.

use crate::solve::compared_ends::goal_with_end;
use crate::{Preset, Scenario};
use aghf::constraint::{AnyConstraint, Constraints};
use aghf::direct::{Direct, DirectSettings, DirectSolution, FreeHorizon, GoalEnd, Iteration, Multipliers};
use aghf::error::Result;
use aghf::motion::{Problem, Stopped};
use std::time::Instant;

/// The weights of time in a search for the least time, as multiples of the effort per second of the motion before. With
/// a first one of 30 balanced motions of four robots among obstacles take an eighth more iterations.
const SHARE: f64 = 1000.0;

/// The weight below which a search that leads to no faster motion gives up.
const MIN_SHARE: f64 = 2.0;

/// The same at the end, of the last motion: the effort is at most a hundredth of the objective; without it the motion
/// of joints that do not determine the duration would be arbitrary.
const LAST_SHARE: f64 = 100.0;

/// The largest number of weights. If only inertia costs effort, each of them divides the duration by four.
const STEPS: usize = 8;

/// The longest duration of a balanced motion, and the least one from which its search starts, as multiples of the least
/// duration.
const BALANCED: f64 = 1.25;
const SLOWED: f64 = 1.2;

/// The factor by which the horizon of a faster motion may be longer than before, because of rounding.
const NOT_LONGER: f64 = 1.0 + 1e-6;

/// The factor up to which a horizon with a larger weight of time shows that there is no faster motion nearby: margins
/// of rows between the points of the quadrature differ from search to search by parts in ten thousand of it.
const SAME_HORIZON: f64 = 1.001;

/// The first penalty of the equalities of goals and waypoints in a search from a motion that meets them: ten times that
/// of others, with which 28 motions of a Panda to poses take 8 % more iterations, and one ends at no minimum.
const POINT_PENALTY: f64 = 1000.0;

/// The factor of the first penalty with which a search that leads to no better minimum is done again, and the largest
/// number of times: with a larger penalty a search from a motion that keeps its rows violates them less.
const PENALTY_FACTOR: f64 = 10.0;
const MAX_REPEATS: i32 = 2;

/// The part of a time limit for the starts of a search that continues from the best one.
const PART_OF_STARTS: f64 = 0.5;

/// A search for the motion of a scenario.
pub(crate) struct Search<'s, 'o> {
    pub scenario: &'s Scenario,
    pub settings: DirectSettings,
    /// Those of the scenario.
    pub constraints: Constraints<Vec<AnyConstraint>>,
    pub observe: &'o mut dyn FnMut(&Iteration),
    pub started: Instant,
    /// The final configuration, if it is one of those in a goal that is a set.
    pub end: Option<Vec<f64>>,
    /// The number of ends of a goal that is a set to which motions were compared one by one.
    pub tried: Option<usize>,
    /// The reason why the last solve stopped early, if it did.
    stopped: Option<Stopped>,
    /// False if the last solve was not reached, or led to nothing better than the one before.
    complete: bool,
}

impl<'s, 'o> Search<'s, 'o> {
    pub fn new(scenario: &'s Scenario, settings: DirectSettings, observe: &'o mut dyn FnMut(&Iteration)) -> Self {
        Self {
            scenario,
            settings,
            constraints: scenario.constraints(),
            observe,
            started: Instant::now(),
            end: None,
            tried: None,
            stopped: None,
            complete: true,
        }
    }

    /// Finds the motion of the objective.
    pub fn run(&mut self) -> Result<DirectSolution> {
        match self.scenario.file.objective.preset() {
            None | Some(Preset::LeastEffort) => self.first(self.settings.clone()),
            Some(Preset::LeastTime) => self.least_time(),
            Some(Preset::Balanced) => self.compare_ends(|search| search.balanced_to_end()),
        }
    }

    /// The first solve. A walk on a free horizon is first solved on the given one: from the longest horizon the search
    /// would shorten it at once, while feet are not yet at their places.
    fn first(&mut self, settings: DirectSettings) -> Result<DirectSolution> {
        let problem = self.problem()?;
        let is_walk = !self.scenario.file.phases.is_empty();
        let Some(free) = settings.free_horizon.filter(|_| is_walk) else {
            return self.solve(&problem, settings);
        };
        let fixed = DirectSettings { free_horizon: None, ..settings };
        let before = self.solve(&problem, fixed)?;
        if self.should_continue(&before) {
            let horizon = if self.settings.parts.is_empty() { problem.horizon() } else { before.curve.horizon() };
            let found = self.from(&before, horizon, Some(free), None, 0)?;
            if is_valid(&found) {
                return Ok(joined(before, found));
            }
        }
        Ok(DirectSolution { converged: false, ..before })
    }

    /// The motion of least time.
    pub fn least_time(&mut self) -> Result<DirectSolution> {
        self.compare_ends(|search| {
            let (first, others) = search.faster()?;
            Ok(search.whole(first, others))
        })
    }

    /// Motions each of which is faster than the one before: first one that weighs time as much as effort, then with a
    /// weight of the effort that vanishes in steps, each from the motion before.
    fn faster(&mut self) -> Result<(DirectSolution, Vec<DirectSolution>)> {
        let scenario = self.scenario;
        let goal = self.first_end().unwrap_or(&scenario.file.q_goal);
        let unit = scenario.cost_of_straight(&mut scenario.running_cost()?, goal)?;
        let mut weight_before = unit / scenario.unit_of_time(Some(goal));
        let mut settings = self.settings.clone();
        settings.free_horizon = self.weighted(weight_before);
        settings.time_limit = settings.time_limit.map(|limit| limit.mul_f64(PART_OF_STARTS));
        let mut first = self.first(settings)?;
        let (mut others, mut share, mut again) = (Vec::new(), SHARE, 0);
        for _ in 0..STEPS {
            let before = others.last().unwrap_or(&first);
            self.complete = self.should_continue(before);
            if !self.complete {
                break;
            }
            let horizon = before.curve.horizon();
            let (density, weight) = (before.cost / horizon, share * before.cost / horizon);
            // Multipliers grow with the objective.
            let growth = (density + weight) / (density + weight_before);
            let multipliers = before.multipliers.scaled(growth);
            let free = self.weighted(weight);
            let next = self.from(before, horizon, free, Some(multipliers), again)?;
            let later = next.curve.horizon() / horizon;
            let last = weight * next.curve.horizon() >= LAST_SHARE * next.cost;
            let is_faster = is_valid(&next) && later <= NOT_LONGER;
            // A search that fails may return the motion with which it began.
            let is_better = is_faster && (next.converged || later * SAME_HORIZON <= 1.0);
            self.complete = next.converged && is_valid(&next) && later <= SAME_HORIZON;
            let ends = if self.complete { last } else { is_better };
            if is_better {
                weight_before = weight;
                others.push(next);
            } else {
                let before = others.last_mut().unwrap_or(&mut first);
                before.iterations.extend(next.iterations);
            }
            again = if self.complete || again == MAX_REPEATS { 0 } else { again + 1 };
            share = match (self.complete, others.is_empty()) {
                _ if ends => break,
                _ if again > 0 => share,
                (true, _) => SHARE,
                // Half of the way there on a logarithmic scale.
                (false, true) if share > MIN_SHARE => share.sqrt(),
                (false, false) if share > LAST_SHARE => LAST_SHARE,
                _ => break,
            };
        }
        Ok((first, others))
    }

    /// The least effort within [`BALANCED`] times the least time, from the slowest of the motions that led to that.
    fn balanced_to_end(&mut self) -> Result<DirectSolution> {
        let (mut first, mut others) = self.faster()?;
        let fast = others.last().unwrap_or(&first);
        let is_least = self.complete;
        self.complete = self.should_continue(fast);
        if self.complete {
            let least = fast.curve.horizon();
            let within = |of: &&DirectSolution| of.curve.horizon() <= BALANCED * least;
            let slow = [&first].into_iter().chain(&others).find(within);
            let slow = slow.unwrap_or(fast);
            let horizon = slow.curve.horizon().max(SLOWED * least);
            let found = self.at_most(slow, horizon, BALANCED * least)?;
            // Otherwise the fast motion remains.
            self.complete = is_valid(&found);
            if self.complete {
                others.push(found);
            } else {
                let fast = others.last_mut().unwrap_or(&mut first);
                fast.iterations.extend(found.iterations);
            }
        }
        self.complete &= is_least;
        Ok(self.whole(first, others))
    }

    /// The last motion, with the starts of the first one and the iterations of all.
    fn whole(&self, first: DirectSolution, others: Vec<DirectSolution>) -> DirectSolution {
        let found = others.into_iter().fold(first, joined);
        DirectSolution { converged: found.converged && self.complete, stopped: self.stopped, ..found }
    }

    /// Returns true if a search continues from this motion: it is valid, and there is time.
    fn should_continue(&self, found: &DirectSolution) -> bool {
        is_valid(found) && self.has_time()
    }

    /// Returns true if there is time for another solve.
    pub fn has_time(&self) -> bool {
        let limit = self.settings.time_limit;
        let late = limit.is_some_and(|limit| self.started.elapsed() >= limit);
        !late && !self.settings.interrupt.is_raised()
    }

    /// The least effort on a horizon of at most `longest`, from another motion stretched to `horizon`.
    pub fn at_most(&mut self, from: &DirectSolution, horizon: f64, longest: f64) -> Result<DirectSolution> {
        let free = self.weighted(0.0).map(|free| FreeHorizon { longest: free.longest.min(longest), ..free });
        self.repeated(from, horizon, free)
    }

    /// The least effort on a given horizon, from another motion stretched to it.
    pub fn at(&mut self, from: &DirectSolution, horizon: f64) -> Result<DirectSolution> {
        self.repeated(from, horizon, None)
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
        for again in 1..=MAX_REPEATS {
            if found.converged || !self.should_continue(from) {
                break;
            }
            let mut other = self.from(from, horizon, free_horizon, None, again)?;
            let mut iterations = std::mem::take(&mut found.iterations);
            iterations.append(&mut other.iterations);
            let is_better = other.converged || (is_valid(&other) && !is_valid(&found));
            let better = if is_better { other } else { found };
            found = DirectSolution { iterations, ..better };
        }
        Ok(found)
    }

    /// The bounds of the horizon with another cost of a second.
    fn weighted(&self, weight: f64) -> Option<FreeHorizon> {
        let free = self.settings.free_horizon;
        free.map(|free| FreeHorizon { weight, ..free })
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
        let horizon = match free_horizon {
            Some(free) => horizon.clamp(free.shortest, free.longest),
            None => horizon,
        };
        let (curve, alternative) = (&from.curve, from.alternative);
        let dof = curve.dof();
        let limit = self.settings.time_limit;
        let goal = self.settings.goal.as_ref();
        let goal = goal.map(|goal| {
            let last = curve.x().column(curve.x().ncols() - 1);
            let q = last.as_slice()[..dof].to_vec();
            goal_with_end(goal, &GoalEnd { q, alternative })
        });
        let times = &from.waypoint_times;
        let mut waypoints = self.settings.waypoints.clone();
        for (waypoint, time) in waypoints.iter_mut().zip(times) {
            let (x, _) = curve.at(*time);
            waypoint.guesses = vec![x.as_slice()[..dof].to_vec()];
        }
        let mut settings = DirectSettings {
            waypoints,
            // The basis of a planned start is its own.
            degree: curve.degree(),
            segments: curve.segments(),
            start: Some(curve.stretched(horizon)?),
            multipliers,
            free_horizon,
            goal,
            time_limit: limit.map(|limit| limit.saturating_sub(self.started.elapsed())),
            ..self.settings.clone()
        };
        settings.search.point_penalty = POINT_PENALTY;
        settings.search.planned_penalty *= PENALTY_FACTOR.powi(again);
        let problem = self.problem()?.with_horizon(horizon)?;
        let found = self.solve(&problem, settings)?;
        Ok(DirectSolution { alternative, ..found })
    }

    /// The problem with which a search begins: on a free horizon to an end of a goal that is a set, whatever
    /// `horizon_s`.
    fn problem(&self) -> Result<Problem<'s>> {
        let mut problem = self.scenario.problem()?;
        if let Some(end) = &self.end {
            problem = problem.with_final_position(end)?;
        }
        match (self.first_end(), self.settings.free_horizon) {
            (Some(end), Some(free)) if self.scenario.file.objective.weighs_time() => {
                let first = self.scenario.first_horizon(end);
                problem.with_horizon(first.clamp(free.shortest, free.longest))
            }
            _ => Ok(problem),
        }
    }

    /// The end of a goal that is a set to which the search goes first.
    fn first_end(&self) -> Option<&[f64]> {
        let goal = self.settings.goal.as_ref();
        let end = self.end.as_deref();
        end.or_else(|| goal.map(|goal| &goal.ends[0].q[..]))
    }

    /// One solve of a problem of the scenario.
    fn solve(&mut self, problem: &Problem<'_>, settings: DirectSettings) -> Result<DirectSolution> {
        let found = Direct::new(problem)
            .cost(self.scenario.running_cost()?)
            .constraints(&self.constraints)
            .settings(settings)
            .observe(&mut *self.observe)
            .solve()?;
        self.stopped = found.stopped;
        Ok(found)
    }
}

/// Returns true if the motion keeps all constraints.
pub(crate) fn is_valid(found: &DirectSolution) -> bool {
    found.largest_violation <= DirectSettings::FEASIBLE
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
