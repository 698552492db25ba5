//! A minimum in a basis within constraints, by the [interior-point method](crate::nlp).
//!
//! `program` is the nonlinear program: `unknowns` and blocks of rows, each with its margins. `grid_rows` are those at
//! the points of the quadrature, which `integrand` adds to the running cost; `points` those at single times
//! (`point_rows`): of waypoints, of a goal that is a set, at the ends of the time in which a row is kept (`windows`),
//! and beside an end that is at a bound (`end_rows`); `border` those that are linear in the horizon and in times.
//! `margins` evaluates rows between the points, `finer` checks the quadrature, `ends` are those of a periodic motion,
//! and `working_set` lists rows: clearances while they are near their bound, all others always.

mod border;
mod candidate;
mod curvature;
mod end_rows;
mod ends;
mod finer;
mod foot_terms;
mod free;
mod grid_rows;
mod integrand;
mod margins;
mod place;
mod point_rows;
mod points;
mod program;
mod rate_rows;
mod real_time;
mod stage_terms;
mod unknowns;
mod windows;
pub(crate) mod working_set;

pub(super) use candidate::Candidate;
pub use candidate::Multipliers;
pub(crate) use integrand::Integrand;
pub(super) use real_time::{Iterations, RealTime};

use super::{DirectSettings, FreeHorizon, GoalSet, Iteration, parts};
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::cost::check_integral;
use crate::curve::Basis;
use crate::error::{Error, Result};
use crate::motion::{Problem, Watch, passive_share};
use crate::nlp::{Options, Progress, Solution, Status, solve};
use crate::transcription::{Grid, Grids, Rows};
use program::Program;
use std::sync::Arc;

/// The termination criteria of one minimisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stage {
    /// The norm of the gradient of the Lagrangian relative to the cost.
    pub tolerance: f64,
    /// The largest number of iterations.
    pub iterations: usize,
    /// The largest relative difference between the quadrature and a finer one.
    pub quadrature_tolerance: f64,
    /// The last barrier parameter, relative to the cost.
    pub last_barrier: f64,
    /// The accepted excess of a row, in its unit.
    pub feasible: f64,
    /// True if the end is checked to be a minimum within the constraints.
    pub last: bool,
}

/// A problem with the data that its minimisations share.
pub(super) struct Context<'c, 'a, K, P> {
    pub problem: &'c Problem<'a>,
    pub grids: &'c Grids,
    pub rows: &'c Rows<'a, K, P>,
    pub watch: &'c Watch,
    pub settings: &'c DirectSettings,
    pub free_horizon: Option<FreeHorizon>,
    pub goal: Option<&'c GoalSet>,
}

impl<K, P> Clone for Context<'_, '_, K, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<K, P> Copy for Context<'_, '_, K, P> {}

/// Minimises the running cost within the rows, from a candidate and in its basis.
pub(super) fn minimise<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    mut candidate: Candidate,
    stage: Stage,
    observe: &mut dyn FnMut(Iteration),
) -> Result<Candidate> {
    let basis = candidate.path.basis.clone();
    let search = &context.settings.search;
    let per_degree = match basis.segments() {
        1 => search.points,
        _ => search.points_of_segments,
    };
    let parts = &context.settings.parts;
    if !parts.is_empty() && candidate.horizons.reference().is_none() {
        let whole = candidate.horizons.whole();
        candidate.horizons = parts::horizons(parts, |_| whole, whole);
    }
    candidate.points = (per_degree * basis.degree() as f64) as usize + 4;
    if context.settings.start_is_minimum {
        candidate.points = candidate.points.max(points_of_start(context, &candidate));
    }
    loop {
        let status = on_grid(context, &mut candidate, stage, observe)?;
        check_integral(candidate.cost)?;
        if status != Status::QuadratureTooCoarse || context.watch.stopped().is_some() {
            break;
        }
        candidate.points = candidate.points * 3 / 2;
    }
    if stage.last {
        look_at_passive_joints(context, &mut candidate)?;
    }
    Ok(candidate)
}

/// The number of quadrature points per segment for which a candidate has multipliers.
fn points_of_start<K: Constraint, P: CostWithControl>(context: Context<'_, '_, K, P>, candidate: &Candidate) -> usize {
    let basis = &candidate.path.basis;
    let held = context.rows.attributes().equalities.contains(&true);
    let held = if held { collocated_points(context, basis) } else { 0 };
    (candidate.multipliers.times.len() / basis.segments()).saturating_sub(held)
}

/// Minimises with the number of points of the candidate.
fn on_grid<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    candidate: &mut Candidate,
    stage: Stage,
    observe: &mut dyn FnMut(Iteration),
) -> Result<Status> {
    let Context { grids, rows, settings, .. } = context;
    let (basis, points) = (candidate.path.basis.clone(), candidate.points);
    let grid = grid(context, &basis, points);
    // Not a multiple, so that it evaluates between the points.
    let finer = grids.get(&basis, points * 3 / 2 + 7);
    let refinable = points < settings.search.most_points * basis.degree();
    let (mut program, x) = Program::of_search(context, candidate, (grid, Some(finer)), (stage, refinable))?;
    let options = options_of(settings, stage, candidate.penalty, rows.count());
    let kkt = program
        .kkt()
        .ok_or_else(|| Error::input("basis", "norm", "the norm of velocities is not positive definite"))?;
    let mut log = |progress: &Progress| observe(iteration_of(progress, &basis, points));
    let mut known = Vec::new();
    let known = program.known_multipliers(candidate, &mut known);
    if stage.last {
        program.feasible_iterates.push(x.clone());
    }
    let end = solve(&mut program, x, known, kkt, &options, &mut log)?;
    take_end(context, &mut program, candidate, &end, stage)?;
    Ok(end.status)
}

/// Changes the candidate to the end of a search, or to the last iterate that satisfied the constraints.
fn take_end<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    program: &mut Program<'_, '_, K, P>,
    candidate: &mut Candidate,
    end: &Solution,
    stage: Stage,
) -> Result<()> {
    let (rows, settings) = (context.rows, context.settings);
    let mut violation = program.violation(&end.x)?;
    program.put_all_multipliers(&end.iterate, candidate);
    candidate.converged = end.status == Status::Converged && program.finer.cost[1] <= stage.quadrature_tolerance;
    let mut x = end.x.clone();
    while stage.last && violation > stage.feasible {
        let Some(earlier) = program.feasible_iterates.pop() else {
            break;
        };
        let of = program.violation(&earlier)?;
        if of <= stage.feasible {
            (x, violation) = (earlier, of);
        }
    }
    (candidate.violation, candidate.deviation) = (violation, program.grid_rows.deviation);
    let rough = stage.last && candidate.deviation > settings.search.deviation;
    candidate.converged &= !rough;
    candidate.kept = rows.count() > 0 && !candidate.converged && violation <= stage.feasible && !rough;
    program.put(&x, candidate);
    if stage.last && !candidate.converged {
        // The finer quadrature may be that of another iterate.
        program.is_coarse(true)?;
    }
    [candidate.cost, candidate.quadrature_error] = program.finer.cost;
    let time = program.unknowns.free.weight * candidate.horizons.whole();
    candidate.objective = candidate.cost + time;
    candidate.gradient_norm = end.progress.stationarity;
    candidate.complementarity = end.progress.complementarity;
    if stage.last {
        candidate.stationarity = program.stationarity(&x, &end.iterate)?;
        // Elsewhere the gradient does not vanish, and curvature does not show a minimum.
        candidate.smallest_curvature =
            if candidate.converged { program.smallest_curvature(&end.x, &end.iterate)? } else { f64::NAN };
    }
    Ok(())
}

/// The options of the interior-point method from a start with this penalty, or that of the options.
fn options_of(settings: &DirectSettings, stage: Stage, penalty: Option<f64>, rows: usize) -> Options {
    let of_bounds = settings.search.last_barrier_of_bounds;
    Options {
        tolerance: stage.tolerance,
        feasible: stage.feasible,
        penalty: penalty.unwrap_or(settings.nlp.penalty),
        penalty_of_multipliers: 0.0,
        // The multipliers of a lower degree may be those of violated rows.
        row_penalty_of_multipliers: match penalty {
            Some(_) => settings.nlp.row_penalty_of_multipliers,
            None => 0.0,
        },
        iterations: stage.iterations,
        min_warm_barrier: if settings.start_is_minimum { 0.0 } else { settings.nlp.warm_barrier },
        last_barrier: match rows {
            0 => of_bounds.min(stage.last_barrier),
            _ => stage.last_barrier,
        },
        ..settings.nlp.clone()
    }
}

/// An iteration of the interior-point method in a basis as one of the search.
fn iteration_of(progress: &Progress, basis: &Basis, points: usize) -> Iteration {
    Iteration {
        start: None,
        horizon: progress.measure,
        segments: basis.segments(),
        degree: basis.degree(),
        points,
        cost: progress.objective,
        gradient_norm: progress.stationarity,
        damping: progress.regularisation,
        step: progress.step * progress.alpha,
        factorisations: progress.factorisations,
        violation: progress.infeasibility,
    }
}

/// The number of points per segment at which equalities are collocated: `degree - 1`, as of a second-order equation,
/// the torque of a passive joint, and fewer where equalities of the state would leave less than a quarter of the
/// unknowns free. With half as many again, searches take twice as many iterations, more than with more segments.
fn collocated_points<K: Constraint, P: CostWithControl>(context: Context<'_, '_, K, P>, basis: &Basis) -> usize {
    let second_order = basis.degree() - 1;
    match context.rows.equalities_of_state().count() {
        0 => second_order,
        held => {
            let unknowns = context.problem.model().dof() * basis.free().len() / basis.segments();
            second_order.min(3 * unknowns / (4 * held)).max(1)
        }
    }
}

/// The quadrature points: with those at which equalities are collocated if there are any.
fn grid<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    basis: &Basis,
    points: usize,
) -> Arc<Grid<f64>> {
    if context.rows.attributes().equalities.contains(&true) {
        let held = collocated_points(context, basis);
        context.grids.collocated(basis, [points, held])
    } else {
        context.grids.with_ends(basis, points)
    }
}

/// Evaluates the residual torques of passive joints.
fn look_at_passive_joints<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    candidate: &mut Candidate,
) -> Result<()> {
    let search = &context.settings.search;
    let limits = &context.rows.constraints.torque;
    if limits.has_passive() {
        let curve = candidate.curve(context.problem)?;
        let times = search.last_scan.div_ceil(curve.segments());
        let model = context.problem.model();
        candidate.passive_share = passive_share(model, &curve, limits, times)?;
        candidate.converged &= candidate.passive_share <= search.passive_share;
    }
    Ok(())
}
