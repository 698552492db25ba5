//! From several starts at a low degree to the best curve at a high one.

use super::grid::Grids;
use super::newton::{End, Iteration, Judge, Minimum, Newton, SMALLEST_COST, Stop, move_by};
use super::running_cost::check_integral;
use super::{Objective, PointCost, RelaxSettings};
use crate::curve::Basis;
use crate::error::Result;
use crate::motion::Problem;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A curve in a basis.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    pub basis: Basis,
    pub coefficients: DMatrix<f64>,
}

/// What is asked of one level of the ladder.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    pub stop: Stop,
    /// How well the quadrature has to agree with a finer one, relative.
    pub quadrature_tolerance: f64,
    /// Whether to see to it that it is a minimum.
    pub last: bool,
}

/// What came of one level.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    pub path: Path,
    /// The cost by a finer quadrature.
    pub cost: f64,
    pub gradient_norm: f64,
    pub points: usize,
    /// How far the quadrature is from the finer one, relative.
    pub quadrature_error: f64,
    /// Whether gradient and quadrature are as good as was asked.
    pub converged: bool,
    /// Of the last level.
    pub smallest_curvature: f64,
}

/// Points to start with for each degree.
const POINTS: usize = 3;
/// More points than this for each degree do not help: the curve has corners that no quadrature of this kind sees.
const MOST_POINTS: usize = 16;
/// How far along a direction of negative curvature to look first, in the norm of Gauss and Newton relative to the cost.
const LEAVE: f64 = 0.3;

/// The curve that takes `q` from the start to the goal as a cubic with the right velocities.
pub(super) fn line(problem: &Problem<'_>, basis: Basis) -> Path {
    let (n, horizon) = (problem.model().dof(), problem.horizon());
    let cubic = Basis::new(1, 3, false);
    let mut coefficients = DMatrix::zeros(n, 4);
    for (at, state) in [(0, problem.start()), (2, problem.goal())] {
        let (q, v) = state.split_at(n);
        coefficients.column_mut(at).copy_from_slice(v);
        coefficients.column_mut(at).scale_mut(horizon);
        coefficients.column_mut(at + 1).copy_from_slice(q);
    }
    let cubic = Path {
        basis: cubic,
        coefficients,
    };
    cubic.in_basis(basis)
}

/// What a search starts from: the line, and the same with bends as far as the settings say.
pub(super) fn starts(problem: &Problem<'_>, settings: &RelaxSettings, basis: Basis) -> Vec<Path> {
    let line = line(problem, basis);
    let bent =
        (1..settings.num_starts as u64).map(|seed| line.bent(settings.start_amplitude, seed));
    std::iter::once(line.clone()).chain(bent).collect()
}

impl Path {
    /// The same curve, or the nearest there is, in another basis.
    pub fn in_basis(&self, basis: Basis) -> Self {
        let dof = self.coefficients.nrows();
        let coefficients = basis.fit(dof, |time| self.basis.evaluate(&self.coefficients, time));
        Self {
            basis,
            coefficients,
        }
    }

    /// The same with bends: each joint is moved by random multiples, up to `size` for the longest, of the bubbles.
    pub fn bent(&self, size: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut bent = self.clone();
        let times = (0..=64).map(|i| i as f64 / 32.0 - 1.0);
        let tables: Vec<_> = times.map(|s| self.basis.local(s)).collect();
        for k in 2..self.basis.degree() - 1 {
            let heights = tables.iter().map(|table| table[(0, k)].abs());
            let height = heights.fold(0.0, f64::max);
            for j in 0..bent.coefficients.nrows() {
                let share: f64 = rng.random_range(-1.0..1.0);
                bent.coefficients[(j, k)] += size * share / ((k - 1) as f64 * height);
            }
        }
        bent
    }
}

/// Minimises the integral of `cost` from `path` in its basis, with as many points as it takes.
pub(super) fn settle<P: PointCost<f64> + Clone>(
    grids: &Grids,
    problem: &Problem<'_>,
    cost: &P,
    path: Path,
    level: Level,
    observe: &mut dyn FnMut(Iteration),
) -> Result<Settled> {
    let n = problem.model().dof();
    let Path {
        basis,
        mut coefficients,
    } = path;
    let mut points = POINTS * basis.degree() + 4;
    let most = MOST_POINTS * basis.degree();
    loop {
        let grid = grids.get(&basis, points, problem.horizon());
        // Not a multiple, so that it sees between the points.
        let finer = grids.get(&basis, points * 3 / 2 + 7, problem.horizon());
        let mut objective = Objective::new(&grid, cost.clone(), n);
        let mut judge = Judge {
            finer: Objective::new(&finer, cost.clone(), n),
            quadrature_tolerance: if points < most {
                level.quadrature_tolerance
            } else {
                f64::INFINITY
            },
            cost: f64::NAN,
        };
        let mut newton = Newton::new(&objective);
        let found = newton.minimise(
            &mut objective,
            coefficients,
            level.stop,
            &mut |curve, cost, end| judge.finds_coarse(curve, cost, end),
            observe,
        )?;
        let Minimum {
            end,
            cost,
            gradient_norm,
            ..
        } = found;
        coefficients = found.coefficients;
        check_integral(judge.cost)?;
        if end == End::Coarse {
            points = points * 3 / 2;
            continue;
        }
        let quadrature_error = (judge.cost - cost).abs() / judge.cost.max(SMALLEST_COST);
        let mut smallest_curvature = f64::NAN;
        if level.last {
            let (curvature, direction) = newton.smallest_curvature();
            smallest_curvature = curvature;
            let saddle = curvature < 0.0 && end == End::Converged;
            let lower = saddle.then(|| leave(&mut objective, &coefficients, &direction, cost));
            if let Some(lower) = lower.transpose()?.flatten() {
                coefficients = lower;
                continue;
            }
        }
        return Ok(Settled {
            path: Path {
                basis,
                coefficients,
            },
            cost: judge.cost,
            gradient_norm,
            points,
            quadrature_error,
            converged: end == End::Converged && quadrature_error <= level.quadrature_tolerance,
            smallest_curvature,
        });
    }
}

/// A curve along a direction of negative curvature, either way, that costs less.
fn leave<P: PointCost<f64>>(
    objective: &mut Objective<'_, f64, P>,
    coefficients: &DMatrix<f64>,
    direction: &DVector<f64>,
    cost: f64,
) -> Result<Option<DMatrix<f64>>> {
    let mut trial = coefficients.clone();
    let mut length = LEAVE * cost.sqrt();
    for _ in 0..20 {
        for sign in [1.0, -1.0] {
            move_by(
                objective,
                coefficients,
                &(direction * (sign * length)),
                &mut trial,
            );
            if objective.value(&trial)? < cost {
                return Ok(Some(trial));
            }
        }
        length *= 0.3;
    }
    Ok(None)
}
