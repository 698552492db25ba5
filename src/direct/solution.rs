//! The results of the direct method.

use super::strategy::MultistartOutcome;
use super::{DegreeRefinement, FreeHorizon, LocalMinimum, Multipliers};
use crate::curve::Curve;
use crate::error::Result;
use crate::motion::{Problem, Stopped};

/// One iteration of the minimiser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// The number of the start, from 0; `None` when the best result is continued at another degree or horizon.
    pub start: Option<usize>,
    /// The horizon, s.
    pub horizon: f64,
    /// The number of segments.
    pub segments: usize,
    /// The degree of the segments.
    pub degree: usize,
    /// The number of quadrature points per segment.
    pub points: usize,
    /// The cost $J$ before the step.
    pub cost: f64,
    /// The Newton decrement $\sqrt{g^T H^{-1} g / J}$ with the gradient $g$ of the barrier function and the condensed
    /// matrix $H$. Half its square is the predicted relative decrease of the barrier function.
    pub gradient_norm: f64,
    /// The multiple of the norm of steps, that of the velocities, that was added to the Hessian.
    pub damping: f64,
    /// The length of the step in that norm, roughly in radians; zero without a step.
    pub step: f64,
    /// The number of matrix factorisations.
    pub factorisations: usize,
    /// The largest violation of a constraint at the quadrature points, in its own unit; zero if all are satisfied.
    pub violation: f64,
}

/// The result of a direct solve.
#[derive(Clone, Debug)]
pub struct DirectSolution {
    /// The motion, with $v = \dot q$, on the optimal horizon if that was free.
    pub curve: Curve,
    /// The integral of the running cost, by default $\int |u|^2 dt$, by a quadrature finer than that of the
    /// minimisation. The weighted duration of a free horizon is not included.
    pub cost: f64,
    /// The final relative gradient norm; see [`Iteration::gradient_norm`].
    pub gradient_norm: f64,
    /// The norm of the gradient of the Lagrangian relative to the cost, in the norm that is dual to that of
    /// velocities: the first of the three residuals of the optimality conditions, beside
    /// [`largest_violation`](Self::largest_violation) and [`complementarity`](Self::complementarity).
    pub stationarity: f64,
    /// The smallest eigenvalue of the Hessian relative to the Gauss-Newton metric: positive at a minimum, one for a
    /// linear problem; NaN if the search has not converged.
    pub smallest_curvature: f64,
    /// The violation of the worst constraint at the worst time, in rad, rad/s, m, N m or N; zero without constraints.
    pub largest_violation: f64,
    /// The largest torque of a passive joint between its collocated points, relative to the largest torque. Above 5e-4
    /// the number of segments is increased as far as possible.
    pub passive_share: f64,
    /// The number of quadrature points per segment.
    pub points: usize,
    /// The relative difference between the cost by this quadrature and by the finer one.
    pub quadrature_error: f64,
    /// True if the gradient norm is below the tolerance, the quadratures agree, and a free horizon is stationary or at
    /// a bound.
    pub converged: bool,
    /// True if the search did not reach a minimum but the motion satisfies the constraints. If a start satisfies them,
    /// such as a [planned first one](super::PlannedStarts::First), so does the motion: a search that ends outside them
    /// returns an earlier iterate.
    pub kept: bool,
    /// The reason of an early stop, if there was one; the motion is then the best so far.
    pub stopped: Option<Stopped>,
    /// The degrees of the refinement, if the degree is adaptive.
    pub adapted: Option<DegreeRefinement>,
    /// The number of unknowns.
    pub unknowns: usize,
    /// The costs of all starts at their first degree, ascending; that is the lowest degree except for some planned
    /// starts.
    pub start_costs: Vec<f64>,
    /// The final barrier parameter, summed over all rows and relative to the cost: the relative excess of the cost over
    /// that with exact complementarity.
    pub complementarity: f64,
    /// The minima found from the starts, by cost; empty without starts.
    pub minima: Vec<LocalMinimum>,
    /// The curves of the first [few](Self::MINIMA_CURVES) minima at the end of the multistart, before any further
    /// degree or horizon.
    pub minima_curves: Vec<Curve>,
    /// The number of the start that led to the motion; `None` without starts.
    pub best_start: Option<usize>,
    /// The alternative of the [goal](super::GoalSet) at which the motion ends; zero without one.
    pub alternative: usize,
    /// The times of the waypoints, s.
    pub waypoint_times: Vec<f64>,
    /// The initial curve of that start.
    pub first_guess: Curve,
    /// The multipliers of the rows.
    pub multipliers: Multipliers,
    /// The bounds and the weight of the horizon in the search to which the multipliers belong, if it was free.
    pub free_horizon: Option<FreeHorizon>,
    /// All iterations, of all starts and degrees.
    pub iterations: Vec<Iteration>,
}

impl DirectSolution {
    /// The number of minima whose curves are stored.
    pub const MINIMA_CURVES: usize = 4;

    /// Returns true if the motion keeps all constraints to within the [tolerance](super::DirectSettings::FEASIBLE).
    #[must_use]
    pub fn is_feasible(&self) -> bool {
        self.largest_violation <= super::DirectSettings::FEASIBLE
    }

    /// The solution with the best of the starts, without iterations.
    pub(super) fn of(problem: &Problem<'_>, outcome: MultistartOutcome) -> Result<Self> {
        let (found, (best_start, guess)) = (outcome.best, outcome.best_start);
        let curves = outcome.curves.iter().map(|end| end.curve(problem));
        Ok(Self {
            curve: found.curve(problem)?,
            cost: found.cost,
            gradient_norm: found.gradient_norm,
            stationarity: found.stationarity,
            smallest_curvature: found.smallest_curvature,
            largest_violation: found.violation,
            passive_share: found.passive_share,
            points: found.points,
            quadrature_error: found.quadrature_error,
            converged: found.converged,
            kept: found.kept,
            stopped: None,
            adapted: None,
            unknowns: found.path.basis.free().len() * problem.model().dof(),
            start_costs: outcome.first_costs,
            complementarity: found.complementarity,
            minima: outcome.minima,
            minima_curves: curves.collect::<Result<_>>()?,
            best_start,
            alternative: found.alternative,
            waypoint_times: found.times.iter().map(|time| found.time(*time)).collect(),
            first_guess: guess.curve(problem)?,
            multipliers: found.multipliers,
            free_horizon: None,
            iterations: Vec::new(),
        })
    }
}
