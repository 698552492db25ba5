//! The flow from one guess to rest: basis by basis.

use super::clock::Clock;
use super::program::Program;
use super::{RestRecord, RestSettings, RestSolution};
use crate::constraint::{Constraint, Constraints};
use crate::cost::{CostWithControl, check_integral};
use crate::curve::{Basis, Continuity, Curve};
use crate::direct::{Level, Multipliers, Stage};
use crate::error::{Error, Result};
use crate::flow::weak::{Norm, RestMetric};
use crate::flow::{ActuationMetric, Metric};
use crate::motion::{Path, Problem, Watch, passive_share};
use crate::nlp::{Bordered, Kkt, Options, Progress, Solution, Status, solve};
use crate::transcription::{Derivatives, Grid, Grids, Objective, Rows};
use nalgebra::DMatrix;
use std::collections::VecDeque;

/// The factor of the cost in the first of two phases; the penalty of violations and the barrier parameter are larger by
/// its inverse.
const FIRST_PHASE: f64 = 1e-3;

/// The largest number of times that multipliers are updated at the end: more than for rows alone, since a small penalty
/// of the slip stays as it is.
const ROUNDS: usize = 40;

/// The data that the walks from all guesses share.
pub(super) struct Shared<'w, 'a, K, P> {
    pub problem: &'w Problem<'a>,
    pub settings: &'w RestSettings,
    /// The penalty of the slip.
    pub k: f64,
    pub rows: &'w Rows<'a, K, P>,
    pub grids: &'w Grids,
    pub watch: &'w Watch,
    /// The action above which the number of segments is not increased.
    pub least: f64,
}

/// The state of the flow.
struct Walk {
    path: Path,
    clock: Clock,
    /// The multipliers of the rows, and of the slips.
    multipliers: [Multipliers; 2],
    /// The action without the terms of multipliers.
    exact: f64,
    found: RestSolution,
}

impl<K: Constraint, P: CostWithControl> Shared<'_, '_, K, P> {
    /// Follows the flow from the guess of this number to rest.
    pub fn from(&self, guess: usize, curve: Curve, observe: &mut dyn FnMut(&RestRecord)) -> Result<RestSolution> {
        let (problem, settings) = (self.problem, self.settings);
        let constraints = &*self.rows.constraints;
        let mut levels: VecDeque<Level> = settings.levels(constraints).into();
        let mut walk = Walk {
            path: Path::of_states(&curve, levels[0].basis.clone()),
            clock: Clock::default(),
            multipliers: Default::default(),
            exact: f64::NAN,
            found: RestSolution::new(curve, guess),
        };
        let mut first_phase = settings.two_phases && self.rows.count() > 0;
        while let Some(level) = levels.pop_front() {
            walk.path = walk.path.in_basis(level.basis.clone());
            if first_phase {
                self.minimise(&mut walk, level.stage, FIRST_PHASE, observe)?;
                first_phase = false;
            }
            self.minimise(&mut walk, level.stage, 1.0, observe)?;
            if self.watch.stopped().is_some() {
                walk.found.at_rest = false;
                break;
            }
            let found = &walk.found;
            let left = found.passive_share > settings.search.passive_share && found.action < self.least;
            let finer = level.basis.finer(RestSettings::MAX_SIZE);
            if let (true, true, Some(basis)) = (levels.is_empty(), left, finer) {
                let stage = level.stage;
                levels.push_back(Level { basis, stage });
            }
        }
        let mut found = walk.found;
        found.at_rest &= found.passive_share <= settings.search.passive_share;
        found.curve = walk.path.curve_of_states(problem.horizon())?;
        found.steps = walk.clock.steps;
        found.factorisations = walk.clock.factorisations;
        found.stopped = self.watch.stopped();
        Ok(found)
    }

    /// Follows the flow in one basis, with as many points as needed.
    fn minimise(&self, walk: &mut Walk, stage: Stage, factor: f64, observe: &mut dyn FnMut(&RestRecord)) -> Result<()> {
        let basis = walk.path.basis.clone();
        let search = &self.settings.search;
        let per_degree = match basis.segments() {
            1 => search.points,
            _ => search.points_of_segments,
        };
        let mut points = (per_degree * basis.degree() as f64) as usize + 4;
        loop {
            let status = self.on_grid(walk, points, (stage, factor), observe)?;
            check_integral(walk.exact)?;
            if status != Status::QuadratureTooCoarse || self.watch.stopped().is_some() {
                break;
            }
            points = points * 3 / 2;
        }
        let limits = &self.rows.constraints.torque;
        if stage.last && limits.has_passive() {
            let curve = walk.path.curve_of_states(self.problem.horizon())?;
            let (model, times) = (self.problem.model(), search.last_scan.div_ceil(curve.segments()));
            walk.found.passive_share = passive_share(model, &curve, limits, times)?;
        }
        Ok(())
    }

    /// Follows the flow in one basis with this number of points per segment.
    fn on_grid(
        &self,
        walk: &mut Walk,
        points: usize,
        (stage, factor): (Stage, f64),
        observe: &mut dyn FnMut(&RestRecord),
    ) -> Result<Status> {
        let Self { problem, settings, rows, grids, .. } = *self;
        let basis = walk.path.basis.clone();
        let grid = if rows.attributes().equalities.contains(&true) {
            grids.collocated(&basis, [points, basis.degree() - 1])
        } else {
            grids.with_ends(&basis, points)
        };
        // Not a multiple, so that it sees between the points.
        let finer = grids.get(&basis, points * 3 / 2 + 7);
        let mut program = Program::new(
            (problem, self.watch),
            rows,
            [&grid, &finer],
            walk.path.clone(),
            (self.k, settings.duals),
            (stage, points < settings.search.most_points * basis.degree()),
            &settings.search,
        );
        let n = problem.model().dof();
        let [of_rows, of_slips] = &walk.multipliers;
        let known = of_rows.at(&grid.times, rows.count());
        if settings.duals
            && let Some(known) = of_slips.at(&grid.times, n)
        {
            *program.slip_multipliers() = DMatrix::from_vec(n, grid.times.len(), known);
        }
        let norm = Norm {
            model: problem.model(),
            kind: settings.metric,
            metric: ActuationMetric::default(),
            k: self.k,
            horizon: problem.horizon(),
        };
        let kkt = kkt(&grid, norm, &walk.path.coefficients)?;
        let (x, clock) = (program.free.unknowns(), &mut walk.clock);
        let history = &mut walk.found.history;
        let mut log = |progress: &Progress| {
            if let Some(record) = clock.tick(progress, (basis.segments(), basis.degree())) {
                observe(&record);
                history.push(record);
            }
        };
        let options = self.options(stage, factor);
        let end = solve(&mut program, x, known.as_deref(), kkt, &options, &mut log)?;
        walk.keep(&mut program, &end)?;
        let found = &mut walk.found;
        found.at_rest = end.status == Status::Converged && found.quadrature_error <= stage.quadrature_tolerance;
        Ok(end.status)
    }

    /// The options of the interior-point method, for the cost times a factor.
    fn options(&self, stage: Stage, factor: f64) -> Options {
        let default = self.settings.nlp.clone();
        Options {
            tolerance: stage.tolerance,
            feasible: stage.feasible,
            iterations: stage.iterations,
            last_barrier: stage.last_barrier / factor,
            first_barrier: default.first_barrier / factor,
            warm_barrier: default.warm_barrier / factor,
            min_warm_barrier: default.warm_barrier / factor,
            penalty: default.penalty / factor,
            rounds: ROUNDS,
            longest_step: longest_step(self.settings.metric, &default),
            ..default
        }
    }
}

impl Walk {
    /// Continues from the end of a search.
    fn keep<K: Constraint, P: CostWithControl>(
        &mut self,
        program: &mut Program<'_, '_, K, P>,
        end: &Solution,
    ) -> Result<()> {
        self.found.violation = program.violation(&end.x)?;
        let of_slips = program.slip_multipliers().as_slice().to_vec();
        let grid = program.free.grid;
        let times = if of_slips.is_empty() { Vec::new() } else { grid.times.clone() };
        let rows = &program.free.objective.cost().cost.rows;
        let of_rows = end.iterate.multipliers(grid.times.len() * rows.count());
        let mut multipliers = Multipliers::default();
        multipliers.put(grid, rows, &of_rows);
        self.multipliers = [multipliers, Multipliers { times, values: of_slips, ..Multipliers::default() }];
        self.exact = program.exact;
        let found = &mut self.found;
        found.action = program.action(&end.x, &end.iterate)?;
        self.path = program.free.path.clone();
        found.gradient_norm = end.progress.stationarity;
        found.slip = program.slip;
        found.quadrature_error = program.quadrature_error;
        found.rounds += program.updates;
        Ok(())
    }
}

/// The longest step in a metric: steps are only measured in radians in that of the velocities.
pub(super) fn longest_step(metric: RestMetric, options: &Options) -> f64 {
    match metric {
        RestMetric::Velocity => options.longest_step,
        RestMetric::Flow => f64::INFINITY,
    }
}

/// The equations with the metric at a curve as their norm.
pub(super) fn kkt<M: Metric>(grid: &Grid<f64>, norm: Norm<'_, f64, M>, coefficients: &DMatrix<f64>) -> Result<Kkt> {
    let size = 2 * norm.model.dof();
    let horizon = norm.horizon;
    let mut objective = Objective::new(grid, norm, size);
    objective.set_horizon(horizon);
    let mut derivatives = Derivatives::new(grid, size);
    objective.derivatives(coefficients, &mut derivatives)?;
    let matrix = derivatives.metric;
    Kkt::new(Bordered::with_border(matrix, 0))
        .ok_or_else(|| Error::input("flow", "metric", "it is not positive definite"))
}

impl RestSettings {
    /// The sequence of bases: that of the direct method, in the state.
    fn levels<K: Constraint>(&self, constraints: &Constraints<K>) -> Vec<Level> {
        let passive = constraints.torque.has_passive();
        let rows = usize::from(constraints.dim() > 0);
        let mut levels = self.as_direct(rows).levels(Continuity::default(), passive, 1);
        if self.start.is_some() {
            levels.drain(..levels.len() - 1);
        }
        for Level { basis, stage } in &mut levels {
            *basis = Basis::new(basis.segments(), basis.degree(), Continuity::STATE);
            if stage.last {
                stage.feasible = self.feasible;
                stage.last_barrier = self.nlp.last_barrier.max(self.tolerance * self.tolerance);
            }
        }
        levels
    }
}
