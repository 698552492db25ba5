//! Least effort within constraints: an augmented Lagrangian about Newton's method.

use super::adaptive::climb;
use super::augmented::{Augmented, Rows};
use super::grid::Grids;
use super::held::Held;
use super::horizon::{Exactness, Tried, search};
use super::ladder::line;
use super::newton::{End, Newton, SMALLEST_COST, Stop};
use super::running_cost::check_integral;
use super::scan::{Peak, rows_on};
use super::{
    ControlEffort, CostWithControl, FRESH, FreeHorizon, Grid, Iteration, Objective, Points,
    RelaxSettings, RelaxSolution, curve_of, ladder, path_of,
};
use crate::constraint::{Constraint, Constraints};
use crate::error::Result;
use crate::motion::Problem;
use nalgebra::DMatrix;

const FEASIBLE: f64 = RelaxSettings::FEASIBLE;
/// Points to start with for each degree, and at the highest level, where with fewer most searches have to go on with more.
const POINTS: f64 = 3.0;
const POINTS_LAST: f64 = 3.5;
/// How many intervals between two points are looked at.
const SCAN: usize = 6;
/// The last look is at so many intervals at least.
const FINE: usize = 2400;
/// Rows below this are of no interest, relative to their scale.
const FLOOR: f64 = -0.05;
/// The violation has to shrink by this in a round, or else the weight grows.
const SHRINK: f64 = 0.3;
/// By how much.
const GROWTH: f64 = 4.0;
/// A violation of this, relative to the scale of the rows, costs at first what the effort does.
const DEPTH: f64 = 0.05;
/// Below this violation the look is fine.
const NEAR: f64 = 1e-4;
/// How many of the candidates go up the ladder at most.
const TRIED: usize = 3;
/// After so many rounds in which nothing became better the constraints are taken to exclude each other.
const PATIENCE: usize = 8;
/// The most iterations in a round.
const ITERATIONS: usize = 60;

/// The step in the logarithm of a free horizon by which the cost is differentiated.
const DIFFERENCE: f64 = 0.01;
/// How exactly it is found.
const EXACTNESS: Exactness = Exactness {
    slope: 1e-3,
    horizon: 1e-5,
};

/// What is asked of one level of the ladder.
#[derive(Clone, Copy, Debug)]
struct Level {
    /// Rounds of multipliers.
    rounds: usize,
    /// Gradient norm and iterations of each round.
    stop: Stop,
    quadrature_tolerance: f64,
    /// Whether all has to be right at the end.
    last: bool,
}

const LOWER: Level = Level {
    rounds: 3,
    stop: Stop {
        tolerance: 0.1,
        iterations: 12,
        fresh: 3,
        precise: false,
    },
    quadrature_tolerance: 0.05,
    last: false,
};

/// Finds a motion of locally least control effort that keeps `constraints` at all times. `observe` is called after each
/// iteration.
///
/// As [`relax`](super::relax), with starts that bend around obstacles in different ways; the best goes up the ladder of degrees, and
/// the next best where it does not end within the constraints. These are kept exactly: each point of the quadrature has
/// multipliers, and what a row exceeds between the points is added to it at the points beside.
///
/// A free horizon is found by differences of the cost, three solves for each horizon that is tried; one that ends at the shortest
/// horizon on which there is a motion is found to 1e-3, and takes long.
///
/// # Errors
/// A setting is out of range, or constraints or start are for another robot. A search that ends outside the constraints or before
/// its tolerance is a solution that says so.
pub fn relax_constrained<K: Constraint + Clone>(
    problem: &Problem<'_>,
    settings: &RelaxSettings,
    constraints: &Constraints<K>,
    observe: &mut dyn FnMut(&Iteration),
) -> Result<RelaxSolution> {
    let effort = ControlEffort::new(problem.model());
    relax_constrained_with(problem, settings, constraints, &effort, observe)
}

/// The same for the integral of another running cost, such as a [`CostThroughDynamics`](super::CostThroughDynamics).
///
/// # Errors
/// As [`relax_constrained`], or `cost` is for another robot, or the integral is negative somewhere on the way.
pub fn relax_constrained_with<K: Constraint + Clone, P: CostWithControl>(
    problem: &Problem<'_>,
    settings: &RelaxSettings,
    constraints: &Constraints<K>,
    cost: &P,
    observe: &mut dyn FnMut(&Iteration),
) -> Result<RelaxSolution> {
    settings.check(problem)?;
    let grids = Grids::default();
    let mut rows = Rows::new(problem.model(), constraints, cost.clone())?;
    let mut iterations = Vec::new();
    let mut log = |iteration: Iteration| {
        observe(&iteration);
        iterations.push(iteration);
    };
    let highest = Level {
        rounds: 40,
        stop: Stop {
            tolerance: settings.tolerance,
            iterations: settings.iterations.min(ITERATIONS),
            fresh: FRESH,
            precise: true,
        },
        quadrature_tolerance: settings.quadrature_tolerance,
        last: true,
    };
    // Where an end breaks a constraint there is nothing to be found; the numbers are told all the same.
    let possible = at_ends(problem, settings, &mut rows)? <= FEASIBLE;
    let highest = if possible { highest } else { LOWER };
    let (lower, mut starts) = (settings.lower_rungs(), Vec::new());
    let mut candidates = Vec::new();
    match (&settings.start, lower.split_first()) {
        (Some(curve), _) => candidates.push(Held::free(
            path_of(curve, settings.basis()).between_ends_of(problem),
        )),
        (None, None) => candidates.push(Held::free(line(problem, settings.basis()))),
        (None, Some((first, _))) => {
            for path in ladder::starts(problem, settings, first.clone()) {
                let start = Held::free(path);
                candidates.push(hold(&grids, problem, &rows, start, LOWER, &mut log)?);
            }
            candidates.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
            starts = candidates.iter().map(|c| c.effort).collect();
            starts.sort_by(f64::total_cmp);
        }
    }
    let rungs = lower.get(1..).unwrap_or_default();
    let mut best: Option<Held> = None;
    let tried = if possible { TRIED } else { 1 };
    for mut held in candidates.into_iter().take(tried) {
        for basis in rungs {
            held.path = held.path.in_basis(basis.clone());
            held = hold(&grids, problem, &rows, held, LOWER, &mut log)?;
        }
        held.path = held.path.in_basis(settings.basis());
        let held = hold(&grids, problem, &rows, held, highest, &mut log)?;
        // None before it was right at the end.
        if best
            .as_ref()
            .is_none_or(|b| held.converged || held.violation < b.violation)
        {
            best = Some(held);
        }
        if best.as_ref().is_some_and(|b| b.converged) {
            break;
        }
    }
    // The settings ask for one start at least.
    let found = best.unwrap_or_else(|| Held::free(line(problem, settings.basis())));
    let (mut found, adapted) = climb(settings, found, |from, basis| {
        let mut held = from.clone();
        held.path = held.path.in_basis(basis);
        hold(&grids, problem, &rows, held, highest, &mut log)
    })?;
    let mut problem = problem.clone();
    if possible && let Some(free) = settings.free_horizon {
        let mut on = |horizon: f64, from: &Held, before: f64| {
            let problem = problem.with_horizon(horizon)?;
            let from = from.on_horizon(&problem, horizon / before);
            hold(&grids, &problem, &rows, from, highest, &mut log)
        };
        let first = by_differences(free, problem.horizon(), found, &mut on)?;
        let (best, settled) = search(free, EXACTNESS, first, |horizon, from| {
            let found = on(horizon, &from.found, from.horizon)?;
            by_differences(free, horizon, found, &mut on)
        })?;
        problem = problem.with_horizon(best.horizon)?;
        found = best.found;
        found.converged &= settled;
    }
    Ok(RelaxSolution {
        curve: curve_of(&problem, &found.path)?,
        cost: found.effort,
        gradient_norm: found.gradient_norm,
        smallest_curvature: found.smallest_curvature,
        largest_violation: found.violation,
        points: found.points,
        quadrature_error: found.quadrature_error,
        converged: found.converged,
        adapted,
        unknowns: found.path.basis.free().len() * problem.model().dof(),
        start_costs: starts,
        iterations,
    })
}

/// Minimises within the constraints from a curve in its basis.
fn hold<K: Constraint + Clone, P: CostWithControl>(
    grids: &Grids,
    problem: &Problem<'_>,
    rows: &Rows<'_, K, P>,
    mut held: Held,
    level: Level,
    observe: &mut dyn FnMut(Iteration),
) -> Result<Held> {
    let n = problem.model().dof();
    let count = rows.count();
    let basis = held.path.basis.clone();
    let each = if level.last { POINTS_LAST } else { POINTS };
    let mut points = (each * basis.degree() as f64) as usize + 4;
    let (mut rounds, mut best, mut since) = (0, f64::INFINITY, 0);
    'points: loop {
        let grid = grids.get(&basis, points, problem.horizon());
        let finer = grids.get(&basis, points * 3 / 2 + 7, problem.horizon());
        let mut scan = grids.scan(&basis, SCAN * points, problem.horizon());
        let mut fine = false;
        let mut cost = Augmented::of(rows.clone(), held.rho, grid.times.len());
        cost.multipliers = held.multipliers_at(&grid.times, count);
        held.times = grid.times.clone();
        held.points = points;
        let mut own = Objective::new(&grid, rows.cost.clone(), n);
        let mut judge = Objective::new(&finer, rows.cost.clone(), n);
        let mut h = vec![0.0; count * grid.times.len()];
        let (mut violation_before, mut tolerance) = (f64::INFINITY, 0.1_f64);
        let peaks = scan.peaks(&mut cost.rows, &held.path.coefficients, FLOOR)?;
        let effort = rows_on(&grid, &mut cost.rows, &held.path.coefficients, &mut h)?;
        cost.set_margins(&grid, &peaks, &h);
        if cost.rho == 0.0 {
            cost.rho = first_weight(&grid, &h, count, effort);
        }
        let mut objective = Objective::new(&grid, cost, n);
        let mut newton = Newton::new(&objective);
        loop {
            let stop = Stop {
                tolerance: tolerance.max(level.stop.tolerance),
                precise: level.stop.precise && tolerance <= level.stop.tolerance,
                ..level.stop
            };
            let (mut exact, mut error) = (f64::NAN, f64::NAN);
            let mut coarse = |c: &DMatrix<f64>, _: f64, _: bool| {
                exact = judge.value(c)?;
                let seen = own.value(c)?;
                error = (exact - seen).abs() / exact.max(f64::EPSILON);
                Ok(error > level.quadrature_tolerance && points < 64 * basis.degree())
            };
            let from = held.path.coefficients.clone();
            let found = newton.minimise(&mut objective, from, stop, &mut coarse, observe)?;
            let cost = objective.cost_mut();
            held.path.coefficients = found.coefficients;
            (held.effort, held.quadrature_error) = (exact, error);
            check_integral(exact)?;
            rounds += 1;

            let mut peaks = scan.peaks(&mut cost.rows, &held.path.coefficients, FLOOR)?;
            let mut violation = largest(&peaks, &cost.rows.units);
            let effort = rows_on(&grid, &mut cost.rows, &held.path.coefficients, &mut h)?;
            let moved = cost.update(&grid, &peaks, &h);
            held.gradient_norm = found.gradient_norm * (found.cost / effort.max(1e-16)).sqrt();
            let settled = found.end == End::Converged
                && stop.tolerance <= level.stop.tolerance
                && moved <= FEASIBLE;
            if violation <= NEAR && level.last && !fine {
                fine = true;
                let intervals = (FINE / basis.segments()).max(SCAN * points);
                scan = grids.scan(&basis, intervals, problem.horizon());
                peaks = scan.peaks(&mut cost.rows, &held.path.coefficients, FLOOR)?;
                violation = largest(&peaks, &cost.rows.units);
            }
            held.violation = violation.max(0.0);
            held.multipliers.clone_from(&cost.multipliers);
            held.rho = cost.rho;
            if found.end == End::Coarse {
                points = points * 3 / 2;
                continue 'points;
            }
            held.converged =
                settled && violation <= FEASIBLE && error <= level.quadrature_tolerance;
            // What is left to do, most of it in the constraints first.
            let left = moved / FEASIBLE + held.gradient_norm / level.stop.tolerance;
            since += 1;
            if left < 0.5 * best {
                (best, since) = (left, 0);
            }
            if held.converged
                || since > PATIENCE
                || rounds >= level.rounds
                || (!level.last && violation < 1e-3)
            {
                if level.last {
                    held.smallest_curvature = newton.smallest_curvature().0;
                }
                return Ok(held);
            }
            if found.end == End::Converged {
                if moved > SHRINK * violation_before {
                    cost.rho *= GROWTH;
                }
                violation_before = moved;
                tolerance = if moved == 0.0 { 0.0 } else { 0.1 * tolerance };
            }
        }
    }
}

/// The slope of the cost in the logarithm of the horizon, by differences: multipliers are far less exact than the cost. `on` solves
/// on a horizon, from what was found on another.
fn by_differences(
    free: FreeHorizon,
    horizon: f64,
    found: Held,
    on: &mut dyn FnMut(f64, &Held, f64) -> Result<Held>,
) -> Result<Tried<Held>> {
    let of = |held: &Held, horizon: f64| {
        let cost = held.effort + free.weight * horizon;
        held.converged.then_some(cost)
    };
    let (here, mut slopes) = (of(&found, horizon), Vec::new());
    if let Some(here) = here {
        for step in [-DIFFERENCE, DIFFERENCE] {
            let other = horizon * step.exp();
            let there = of(&on(other, &found, horizon)?, other);
            slopes.extend(there.map(|there| (there - here) / step));
        }
    }
    Ok(Tried {
        horizon,
        cost: found.effort + free.weight * horizon,
        slope: slopes.iter().sum::<f64>() / slopes.len() as f64,
        sound: !slopes.is_empty(),
        found,
    })
}

/// By how much the states at the ends that are given break the constraints on the state.
fn at_ends<K: Constraint, P: CostWithControl>(
    problem: &Problem<'_>,
    settings: &RelaxSettings,
    rows: &mut Rows<'_, K, P>,
) -> Result<f64> {
    let n = problem.model().dof();
    let goal = (!settings.free_final_velocity).then(|| problem.goal());
    let mut worst = 0.0_f64;
    for state in [problem.start()].into_iter().chain(goal) {
        let mut states = DMatrix::zeros(n, 3);
        states.as_mut_slice()[..2 * n].copy_from_slice(state);
        let point = Points {
            first: 0,
            times: &[0.0],
            states: &states,
        };
        let mut h = vec![f64::NEG_INFINITY; rows.count()];
        rows.of_state(point, &mut h)?;
        let violations = h.iter().zip(&rows.units).map(|(h, unit)| h * unit);
        worst = violations.fold(worst, f64::max);
    }
    Ok(worst)
}

/// A weight with which the violation costs about as much as the effort.
fn first_weight(grid: &Grid<f64>, h: &[f64], count: usize, effort: f64) -> f64 {
    let mut sum = 0.0;
    for (g, h) in h.chunks_exact(count.max(1)).enumerate() {
        let weight = grid.weights[g % grid.points()];
        sum += weight * h.iter().map(|h| h.max(0.0).powi(2)).sum::<f64>();
    }
    // A violation of that much for the whole time at least.
    let least = DEPTH * DEPTH * grid.weights.iter().sum::<f64>() * grid.segments as f64;
    2.0 * effort.max(SMALLEST_COST) / sum.max(least)
}

/// The largest violation, in the units of the rows.
fn largest(peaks: &[Peak], units: &[f64]) -> f64 {
    let all = peaks.iter().map(|peak| peak.height * units[peak.row]);
    all.fold(f64::NEG_INFINITY, f64::max)
}
