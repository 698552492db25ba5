//! Starts along planned paths.

use crate::constraint::{Constraint, Quantity};
use crate::cost::CostWithControl;
use crate::curve::Basis;
use crate::direct::minimise::{Candidate, Context};
use crate::direct::settings::PlannedStarts;
use crate::direct::strategy::through::nearest_times;
use crate::error::Result;
use crate::motion::{Path, Problem};
use crate::plan::{Plan, PlanSettings, along, plan, sets_with_equalities, thinned};
use crate::transcription::{Grid, RowSelection, place, points};
use nalgebra::DMatrix;

/// The planned starts: the first start, or the first, third and so on beyond the requested ones.
pub(crate) struct Planned<'c, 'a, K, P> {
    context: Context<'c, 'a, K, P>,
    /// True if there are obstacles.
    wanted: bool,
    /// The curve of the first start, if it is planned.
    first: Option<Path>,
    /// The curve of the first planned start of a search that may be cut off.
    pub reserve: Option<Path>,
}

impl<'c, 'a, K: Constraint, P: CostWithControl> Planned<'c, 'a, K, P> {
    pub fn new(context: Context<'c, 'a, K, P>) -> Result<Self> {
        let settings = context.settings;
        let (state, model) = (&context.rows.constraints.state, context.problem.model());
        let rows = 0..state.dim();
        let bounds = |row: usize| matches!(state.label(row, model).quantity, Quantity::Position | Quantity::Velocity);
        let wanted = settings.planned_starts != PlannedStarts::Never
            && settings.start.is_none()
            && sets_with_equalities(state).is_ok()
            && !rows.clone().all(bounds);
        let mut planned = Self { context, wanted, first: None, reserve: None };
        if wanted && settings.planned_starts == PlannedStarts::First {
            planned.first = planned.path(0, (0, &planned.problem(0)?))?;
        } else if wanted && settings.time_limit.is_some() {
            let number = settings.starts;
            planned.reserve = planned.path(0, (number, &planned.problem(number)?))?;
        }
        Ok(planned)
    }

    /// The number of the path of a planned start.
    fn number(&self, start: usize) -> Option<u64> {
        let first = u64::from(self.first.is_some());
        let beyond = start.checked_sub(self.context.settings.starts)?;
        (self.wanted && beyond.is_multiple_of(2)).then_some(first + beyond as u64 / 2)
    }

    /// The first penalty of a violation from a planned start: larger from one to the next, up to the largest one, and
    /// again.
    fn penalty(&self, start: usize) -> f64 {
        let search = &self.context.settings.search;
        let mut penalty = search.planned_penalty;
        for _ in 0..self.number(start).unwrap_or_default() {
            penalty *= search.planned_penalty_factor;
            if penalty > search.largest_planned_penalty {
                penalty = search.planned_penalty;
            }
        }
        penalty
    }

    /// The number of the bends of a start without a path.
    pub fn bends(&self, start: usize) -> u64 {
        let ends = self.context.goal.map_or(1, |goal| goal.ends.len());
        ((start - usize::from(self.first.is_some())) / ends) as u64
    }

    /// The problem of a start: to its first guess of the final configuration if the goal is a set.
    pub fn problem(&self, start: usize) -> Result<Problem<'a>> {
        match self.context.goal {
            Some(goal) => self.context.problem.with_final_position(&goal.end(start).q),
            None => Ok(self.context.problem.clone()),
        }
    }

    /// The curve of a planned start for a problem like that of the context, with the time that it needs if the horizon
    /// is free; `None` if the start is not planned or no path was found.
    pub fn start(&self, start: usize, problem: &Problem<'_>) -> Result<Option<Candidate>> {
        let path = match (&self.first, &self.reserve, self.number(start)) {
            (Some(first), ..) if start == 0 => Some(first.clone()),
            (_, Some(reserve), Some(0)) => Some(reserve.clone()),
            (.., Some(number)) => self.path(number, (start, problem))?,
            _ => None,
        };
        path.map(|path| self.candidate(path, (start, problem), 1.0)).transpose()
    }

    /// The first planned start of a search that is cut off, if there is one: its rows may be larger between the points,
    /// and it has no further iteration, so that a free horizon is longer.
    pub fn reserve_start(&self) -> Result<Option<Candidate>> {
        let (number, growth) = (self.context.settings.starts, self.context.settings.search.horizon_growth);
        let Some(path) = self.reserve.clone() else {
            return Ok(None);
        };
        Ok(Some(self.candidate(path, (number, &self.problem(number)?), growth)?))
    }

    /// The start along a path, with `growth` times the time that it needs if the horizon is free.
    fn candidate(&self, path: Path, (start, problem): (usize, &Problem<'_>), growth: f64) -> Result<Candidate> {
        let horizon = match self.context.free_horizon {
            Some(free) => (growth * self.horizon(&path, problem, free.longest)?).min(free.longest),
            None => problem.horizon(),
        };
        let problem = &problem.with_horizon(horizon)?;
        let path = path.between_ends_of(problem);
        Ok(Candidate {
            times: nearest_times(&path, problem, &self.context.settings.waypoints),
            penalty: Some(self.penalty(start)),
            ..Candidate::new(path, horizon)
        })
    }

    /// The curve along the paths of this number from waypoint to waypoint, for a start of the search; `None` without a
    /// path.
    fn path(&self, number: u64, (start, problem): (usize, &Problem<'_>)) -> Result<Option<Path>> {
        let constraint = &self.context.rows.constraints.state;
        let search = &self.context.settings.search;
        let n = problem.model().dof();
        let waypoints = self.context.settings.waypoints.iter();
        let waypoints = waypoints.map(|waypoint| waypoint.guess(start));
        let mut path = vec![problem.start()[..n].to_vec()];
        for to in waypoints.chain([&problem.goal()[..n]]) {
            let ends = [&path[path.len() - 1], to].map(|q| [q, &vec![0.0; n]].concat());
            let [from, to] = ends;
            let leg = Problem::new(problem.model(), from, to, problem.horizon())?;
            let Some(found) = self.leg(number, &leg)? else {
                return Ok(None);
            };
            path.extend(found.into_iter().skip(1));
        }
        let segments = search.planned_segments.max(path.len() - 1);
        let basis = if self.context.settings.segments >= segments {
            self.context.settings.basis(problem)
        } else {
            let continuity = self.context.settings.continuity(problem);
            Basis::new(segments, search.planned_degree, continuity)
        };
        let plans = self.plans(number);
        let stops = self.context.settings.waypoints.iter().filter(|waypoint| waypoint.stop);
        let stops: Vec<_> = stops.map(|waypoint| waypoint.guess(start)).collect();
        along(problem, constraint, (&path, &stops), basis, &plans).map(Some)
    }

    /// The settings of the planner for paths of this number.
    fn plans(&self, number: u64) -> PlanSettings {
        PlanSettings {
            seed: self.context.settings.seed,
            number,
            // Slopes make the curve round.
            roundings: 0,
            ..PlanSettings::default()
        }
    }

    /// The path of this number between two configurations; `None` if none is found.
    fn leg(&self, number: u64, problem: &Problem<'_>) -> Result<Option<Vec<Vec<f64>>>> {
        let Context { rows, watch, .. } = self.context;
        let constraint = &rows.constraints.state;
        let mut plans = self.plans(number);
        let most = self.context.settings.search.margin_checks;
        let budget = std::mem::replace(&mut plans.most_checks, most);
        let stopped = || watch.stopped().is_some();
        let mut found = plan(problem, constraint, &plans, &stopped)?;
        if matches!(found, Plan::OutOfBudget { .. }) {
            // Neighbouring links may be closer than the margin in all configurations.
            (plans.margin, plans.most_checks) = (0.0, budget);
            found = plan(problem, constraint, &plans, &stopped)?;
        }
        // The configurations of a path within equalities are close together.
        let legs = self.context.settings.waypoints.len() + 1;
        let lines = self.context.settings.search.planned_segments.div_ceil(legs);
        match found {
            Plan::Found(path) if rows.attributes().equalities.contains(&true) => Ok(Some(thinned(path, lines))),
            Plan::Found(path) => Ok(Some(path)),
            _ => Ok(None),
        }
    }

    /// The initial horizon of the problem: that of a planned first start.
    pub fn first_horizon(&self, longest: f64) -> Result<f64> {
        let problem = self.context.problem;
        match &self.first {
            Some(first) => self.horizon(first, problem, longest),
            None => Ok(problem.horizon()),
        }
    }

    /// The horizon of the problem, or a longer one up to `longest`, until the rows of a start are
    /// satisfied.
    fn horizon(&self, start: &Path, problem: &Problem<'_>, longest: f64) -> Result<f64> {
        let (mut horizon, mut rows) = (problem.horizon(), self.context.rows.clone());
        let basis = &start.basis;
        let n = problem.model().dof();
        while horizon < longest {
            let grid = Grid::with_ends(basis, 2 * basis.degree(), horizon);
            let mut states = DMatrix::zeros(n, grid.table.ncols());
            let mut higher = vec![DMatrix::zeros(n, grid.points()); rows.order() - 2];
            let mut h = vec![0.0; grid.points() * rows.count()];
            let mut kept = true;
            let path = start.clone().between_ends_of(&problem.with_horizon(horizon)?);
            for e in 0..basis.segments() {
                place(&path.coefficients, grid.first(e), &grid.table, &mut states);
                for (rates, of) in higher.iter_mut().zip(&grid.higher) {
                    place(&path.coefficients, grid.first(e), &of.table, rates);
                }
                let mut here = points(&grid, &grid.times, (&states, &higher), e, 0);
                here.first = 0;
                rows.of_all(here, RowSelection::All, &mut h)?;
                // No horizon makes a start keep equalities.
                let held = rows.attributes().equalities.iter().cycle();
                kept &= h.iter().zip(held).all(|(h, held)| *held || *h <= 0.0);
            }
            if kept {
                break;
            }
            horizon = (self.context.settings.search.horizon_growth * horizon).min(longest);
        }
        Ok(horizon)
    }
}
