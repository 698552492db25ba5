//! Straight to where the flow comes to rest: the control effort minimised over polynomials by Newton's method.
//!
//! On the manifold $v = \dot q$, which is the limit $k \to \infty$ of the penalty, the action is the control effort
//! $\int |u|^2 dt$ with $u = ID(q, \dot q, \ddot q)$. There is neither `k` nor `s_max`: `q(t)` is a polynomial that meets the boundary
//! conditions, its free coefficients are the unknowns, the integral is Gauss-Legendre quadrature with as many points as it takes.

mod adaptive;
mod augmented;
mod blocks;
mod constrained;
mod cost;
mod effort;
mod grid;
mod held;
mod horizon;
mod ladder;
mod newton;
mod objective;
mod running_cost;
mod scan;
mod settings;
mod trust_region;

pub use adaptive::DegreeRefinement;
pub use augmented::Augmented;
pub use blocks::PackedHessian;
pub use constrained::{relax_constrained, relax_constrained_with};
pub use cost::{Point, PointCost, PointDerivatives, Points, PointsDerivatives};
pub use effort::ControlEffort;
pub use grid::Grid;
pub use horizon::FreeHorizon;
pub(crate) use horizon::horizon_slope;
pub use newton::Iteration;
pub use objective::{Derivatives, Objective};
pub use running_cost::{
    AutodiffCost, ChainRule, ControlTerm, CostThroughDynamics, CostWithControl, HyperDual64,
    RunningCost, StageDerivatives, StageInput, WeightedSquares,
};
pub use settings::{RelaxSettings, RelaxSolution};

use crate::curve::{Basis, Chebyshev, Curve};
use crate::error::Result;
use crate::motion::Problem;
use adaptive::climb;
use grid::Grids;
use horizon::{Exactness, Tried, search};
pub(crate) use ladder::Path;
use ladder::{Level, Settled, settle};
use nalgebra::{DMatrix, DVector};
use newton::Stop;

/// At the highest degree the metric is computed anew after so many steps. Below, where a search has far to go, that is more often: the
/// minima that are found are better.
const FRESH: usize = 60;

/// What is asked below the highest degree, where a curve is no more than the start of the next.
const LOWER: Level = Level {
    stop: Stop {
        tolerance: 0.1,
        iterations: 15,
        fresh: 1,
        precise: false,
    },
    quadrature_tolerance: 0.02,
    last: false,
};

/// The same on fewer segments, where each has much to gain by the next breakpoint.
const PIECES: Level = Level {
    stop: Stop {
        tolerance: 0.1,
        iterations: 60,
        fresh: 1,
        precise: false,
    },
    ..LOWER
};

/// How many curves go on from the lowest degree: the best there need not be the best at the next.
const KEPT: usize = 3;
/// Those that cost more than the best one by more than this, relative, do not.
const HOPELESS: f64 = 0.2;
/// Costs that differ by less than this, relative, are taken for those of one curve.
const SAME: f64 = 0.01;

/// How exactly a free horizon is found.
const EXACTNESS: Exactness = Exactness {
    slope: 1e-7,
    horizon: 1e-9,
};

/// Finds a motion of locally least control effort $\int |u|^2 dt$. `observe` is called after each iteration.
///
/// Several starts, the line and bent ones, are relaxed at the lowest degree of a ladder of degrees. The best few of them are relaxed at
/// the next, from where they ended, and the best one of these goes up to the degree and the segments that the settings name, or beyond
/// if the degree is adaptive.
///
/// # Errors
/// A setting is out of range, or the start of the settings is for another robot. A search that ends before its tolerance is
/// a solution that says so.
pub fn relax(
    problem: &Problem<'_>,
    settings: &RelaxSettings,
    observe: &mut dyn FnMut(&Iteration),
) -> Result<RelaxSolution> {
    let effort = ControlEffort::new(problem.model());
    relax_with(problem, settings, &effort, observe)
}

/// The same for the integral of any running cost, such as a [`CostThroughDynamics`].
///
/// # Errors
/// As [`relax`], or `cost` is for another robot, or the integral is negative somewhere on the way.
pub fn relax_with<P: PointCost<f64> + Clone>(
    problem: &Problem<'_>,
    settings: &RelaxSettings,
    cost: &P,
    observe: &mut dyn FnMut(&Iteration),
) -> Result<RelaxSolution> {
    settings.check(problem)?;
    let grids = Grids::default();
    let mut iterations = Vec::new();
    let mut log = |iteration: Iteration| {
        observe(&iteration);
        iterations.push(iteration);
    };
    let (lower, mut starts) = (settings.lower_rungs(), Vec::new());
    let path = if let Some(curve) = &settings.start {
        path_of(curve, settings.basis()).between_ends_of(problem)
    } else {
        let mut paths = ladder::starts(problem, settings, lower[0].clone());
        for (rung, basis) in lower.iter().enumerate() {
            let settled = paths.iter().map(|path| {
                let path = path.in_basis(basis.clone());
                let full = rung > 0 && basis.degree() == settings.degree;
                let level = if full { PIECES } else { LOWER };
                settle(&grids, problem, cost, path, level, &mut log)
            });
            let mut settled = settled.collect::<Result<Vec<Settled>>>()?;
            settled.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            if rung == 0 {
                starts = settled.iter().map(|s| s.cost).collect();
            }
            settled.dedup_by(|b, a| b.cost - a.cost <= SAME * a.cost);
            let best = settled[0].cost;
            let near = settled.partition_point(|s| s.cost - best <= HOPELESS * best.abs());
            let most = if rung == 0 { KEPT } else { 1 };
            settled.truncate(near.clamp(1, most));
            paths = settled.into_iter().map(|s| s.path).collect();
        }
        paths.swap_remove(0).in_basis(settings.basis())
    };
    let highest = Level {
        stop: Stop {
            tolerance: settings.tolerance,
            iterations: settings.iterations,
            fresh: FRESH,
            precise: true,
        },
        quadrature_tolerance: settings.quadrature_tolerance,
        last: true,
    };
    let found = settle(&grids, problem, cost, path, highest, &mut log)?;
    let (mut found, adapted) = climb(settings, found, |from, basis| {
        let path = from.path.in_basis(basis);
        settle(&grids, problem, cost, path, highest, &mut log)
    })?;
    let mut problem = problem.clone();
    if let Some(free) = settings.free_horizon {
        let tried = |problem: &Problem<'_>, found: Settled| -> Result<Tried<Settled>> {
            let grid = grids.get(&found.path.basis, found.points, problem.horizon());
            let rates = found.path.rates(problem);
            let (horizon, curve) = (problem.horizon(), &found.path.coefficients);
            let slope = horizon_slope(&grid, &mut cost.clone(), curve, &rates, horizon)?;
            Ok(Tried {
                horizon,
                cost: found.cost + free.weight * horizon,
                slope: horizon * (slope + free.weight),
                sound: found.converged,
                found,
            })
        };
        let first = tried(&problem, found)?;
        let (best, settled) = search(free, EXACTNESS, first, |horizon, from| {
            let problem = problem.with_horizon(horizon)?;
            let path = from.found.path.clone().between_ends_of(&problem);
            tried(
                &problem,
                settle(&grids, &problem, cost, path, highest, &mut log)?,
            )
        })?;
        problem = problem.with_horizon(best.horizon)?;
        found = best.found;
        found.converged &= settled;
    }
    Ok(RelaxSolution {
        curve: curve_of(&problem, &found.path)?,
        cost: found.cost,
        gradient_norm: found.gradient_norm,
        smallest_curvature: found.smallest_curvature,
        largest_violation: 0.0,
        points: found.points,
        quadrature_error: found.quadrature_error,
        converged: found.converged,
        adapted,
        unknowns: found.path.basis.free().len() * problem.model().dof(),
        start_costs: starts,
        iterations,
    })
}

/// The polynomials through Chebyshev nodes that are the same curve, with $v = \dot q$.
pub(crate) fn curve_of(problem: &Problem<'_>, path: &Path) -> Result<Curve> {
    let (n, horizon) = (problem.model().dof(), problem.horizon());
    let (segments, p) = (path.basis.segments(), path.basis.degree());
    let chebyshev = Chebyshev::new(p, 1.0)?;
    let mut x = DMatrix::zeros(2 * n, segments * (p + 1));
    for e in 0..segments {
        for (node, time) in chebyshev.times().iter().enumerate() {
            // Where two segments meet this is the same number for both, and so is the state.
            let time = (e as f64 + time) / segments as f64;
            let [q, slope, _] = path.basis.evaluate(&path.coefficients, time);
            let column = e * (p + 1) + node;
            x.view_mut((0, column), (n, 1)).copy_from(&q);
            x.view_mut((n, column), (n, 1))
                .copy_from(&(slope / horizon));
        }
    }
    let last = x.ncols() - 1;
    x.column_mut(0).copy_from_slice(problem.start());
    // The velocity at the end may be free, and is then the slope that was found.
    let given = if path.basis.free_final_velocity() {
        n
    } else {
        2 * n
    };
    x.column_mut(last)
        .rows_mut(0, given)
        .copy_from_slice(&problem.goal()[..given]);
    Curve::piecewise(horizon, segments, x)
}

/// The configuration of a curve in a basis.
fn path_of(curve: &Curve, basis: Basis) -> Path {
    let (n, chebyshev) = (curve.dof(), curve.chebyshev());
    let horizon = curve.horizon();
    let d2 = chebyshev.d2().transpose();
    let second: Vec<_> = (0..curve.segments())
        .map(|e| curve.segment(e) * &d2)
        .collect();
    let mut weights = DVector::zeros(chebyshev.degree() + 1);
    let coefficients = basis.fit(n, |time| {
        let time = time * horizon;
        let part = curve.segment_at(time);
        let (x, xdot) = curve.at_in(part, time);
        chebyshev.interpolation(time - curve.breakpoints()[part], &mut weights);
        let a = second[part].rows(0, n) * &weights;
        let of_q = |x: &DVector<f64>, scale: f64| x.rows(0, n) * scale;
        [of_q(&x, 1.0), of_q(&xdot, horizon), a * horizon * horizon]
    });
    Path {
        basis,
        coefficients,
    }
}
