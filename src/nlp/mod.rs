//! A primal-dual interior-point method for nonlinear programs with many rows, most of them far from active.
//!
//! $$ \min_x f(x) \quad \text{subject to} \quad h_j(x) \le 0 \ \text{or} \ h_j(x) = 0 . $$
//!
//! Each row has a slack $s_j > 0$ and an elastic variable $t_j > 0$, and an exact $\ell_1$ penalty $\nu_j$ bounds its
//! multiplier (Gould, Orban and Toint, *An interior-point l1-penalty method for nonlinear optimization*, 2015). With
//! the weights $w_j$ of the rows, which are those of a quadrature, the barrier problem is
//!
//! $$ \min_{x, s, t} f(x) + \sum_j w_j (\nu_j t_j + \underline\nu_j s_j - \mu \log s_j - \mu \log t_j)
//!    \quad \text{subject to} \quad h_j(x) + s_j = t_j . $$
//!
//! The slack of an inequality costs nothing, $\underline\nu_j = 0$; that of an equality is a violation too,
//! $\underline\nu_j = \nu_j$, and its multiplier is between $-\nu_j$ and $\nu_j$. There are feasible points for any
//! `x`, so a start may violate the rows and no restoration phase is needed; rows with elastic variables that do not
//! vanish are those that cannot be kept. The condensed matrix is positive definite if and only if the saddle-point
//! matrix of `x` and all multipliers has the inertia of a minimum (NW 16.3), dependent rows or not.
//!
//! [Other equalities](Nlp::equalities) are no rows with elastic variables but [equations](Saddle) of the step, as those
//! of [hard](Row::is_hard) rows are, $h_j + s_j = 0$; a filter of their violation and the barrier function accepts
//! steps (WB 2.3). The loop of [`solve`] is that of Nocedal and Wright, *Numerical Optimization*, algorithm 19.2, and
//! of Wächter and Biegler, *On the implementation of an interior-point filter line-search algorithm*, 2006 (WB):
//!
//! 1. `kkt`: the Newton step of the primal-dual equations, condensed to `x`; multiples of a norm are added to the
//!    Hessian until the condensed matrix is positive definite (WB 3.1).
//! 2. `line_search`: backtracking until the barrier function is sufficiently below the largest of its last values, or
//!    until `filter` accepts it; each slack and each multiplier keeps a part of its distance from its bounds, row by
//!    row (WB 2.2). Slacks follow the rows themselves, multipliers the linearised ones (NW 19.12). Along negative
//!    curvature a step is doubled while that decreases the barrier function further. A whole step that the curvature
//!    of rows makes too long is corrected once (NW 15.6, WB 2.4).
//! 3. `barrier`: the barrier parameter is reduced when the predicted decrease of its problem is small, or after some
//!    iterations with a small decrease ([`BarrierUpdate`]).
//! 4. [`Nlp::tighten`]: after each reduction the rows are evaluated between the points of the quadrature, and violated
//!    rows at their penalties get larger ones (NW 18.36).
//! 5. `warm_start`: with known multipliers the barrier parameter begins at the error of the start, or the search ends.

mod barrier;
mod filter;
mod iterate;
mod kkt;
mod kkt_error;
mod leave_saddle;
mod line_search;
mod options;
mod row;
mod saddle;
mod scaled;
mod smooth;
mod smooth_program;
mod state;
mod warm_start;

pub use barrier::{Barrier, BarrierState, BarrierUpdate, Monotone};
pub use iterate::Iterate;
pub use kkt::{Bordered, Kkt};
pub use kkt_error::{KktError, Scales};
pub use options::Options;
pub use row::{Equality, Row, RowState, RowStep, Term};
pub use saddle::Saddle;
pub use smooth::{SmoothSolution, solve_smooth};
pub use smooth_program::{SmoothDerivatives, SmoothProgram};

use crate::error::Result;
use line_search::line_search;
use nalgebra::DVector;
pub(crate) use state::State;

/// A nonlinear program.
pub trait Nlp {
    /// Evaluates the objective at `x`, and the rows into `h`, the same number in each evaluation; those that are
    /// neither in the working set nor may enter it are not read. The objective is infinite where a row outside the
    /// working set is violated.
    ///
    /// # Errors
    /// Those of the functions of the user.
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64>;

    /// Computes gradient and Hessian of the objective plus the weighted rows at `x`, the last evaluated point, with the
    /// [terms](Iterate::term) of `iterate`.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    fn derivatives(&mut self, x: &DVector<f64>, iterate: &Iterate, out: &mut Kkt) -> Result<()>;

    /// The factor of the weights of the rows at `x`: the horizon.
    fn measure(&self, x: &DVector<f64>) -> f64;

    /// The factor of the weight of one row, if it has its own, as where parts of the horizon differ in length.
    fn row_measure(&self, x: &DVector<f64>, _row: usize) -> f64 {
        self.measure(x)
    }

    /// The equalities of the saddle-point equations, whose gradients are put into [`Kkt::equalities`] with the
    /// [derivatives](Self::derivatives).
    fn equalities(&self) -> Vec<Equality> {
        Vec::new()
    }

    /// True if the program [adds gradients of single rows](Self::add_row_gradients), with which steps have a
    /// second-order correction.
    const HAS_ROW_GRADIENTS: bool = false;

    /// True if a filter accepts steps: where there are equalities, or inequalities without elastic variables that may
    /// be violated.
    fn has_filter(&self) -> bool {
        !self.equalities().is_empty()
    }

    /// Adds the gradients of rows at the point at which derivatives were last computed, each times its weight, to
    /// `out`.
    fn add_row_gradients(&self, _weights: &[(usize, f64)], _out: &mut DVector<f64>) {}

    /// Lists the rows of the working set, which has all other equalities, in ascending order, for the values `h` of the
    /// last evaluation, in place of those in `rows`.
    fn working_set(&mut self, h: &[f64], rows: &mut Vec<Row>);

    /// The largest fraction of a step from `x` that may be tried, at most 1.
    fn max_step_fraction(&self, _x: &DVector<f64>, _step: &DVector<f64>) -> f64 {
        1.0
    }

    /// Evaluates rows between the points at `x`, the last evaluated one, and adapts their margins; after some rounds at
    /// the last barrier parameter, counted by `round`, margins only grow. `h` gets the values without the new margins
    /// of rows that may enter the working set by these.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    fn tighten(&mut self, x: &DVector<f64>, h: &mut Vec<f64>, round: usize) -> Result<Tightened>;

    /// Returns true if the search is to stop.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// The result of an evaluation of the rows between the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tightened {
    /// The largest violation of a row, in its unit.
    Violation(f64),
    /// No row is violated by more than the tolerance, but other margins may keep all bounds themselves.
    Beyond,
    /// The points are too few for the objective.
    QuadratureTooCoarse,
}

/// The reason of the end of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All tolerances are met.
    Converged,
    /// No step decreases the barrier function.
    NoDescent,
    /// Rows are violated at a local minimum of their violation, or although the penalty is at its largest value.
    Infeasible,
    /// The largest number of iterations.
    Iterations,
    /// The points are too few for the objective.
    QuadratureTooCoarse,
    /// Stopped from outside.
    Stopped,
}

/// One iteration, for observers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Progress {
    pub objective: f64,
    pub measure: f64,
    /// The Newton decrement $\sqrt{g^T H^{-1} g / f}$ with the condensed matrix `H`: half its square is the predicted
    /// relative decrease of the barrier function.
    pub stationarity: f64,
    /// The barrier parameter relative to the objective, summed over all rows.
    pub complementarity: f64,
    /// The largest elastic variable.
    pub infeasibility: f64,
    /// The multiple of the norm that was added to the Hessian.
    pub regularisation: f64,
    /// The length of the step in the norm, and the fraction of it that was taken: more than 1 along negative curvature.
    pub step: f64,
    pub alpha: f64,
    pub factorisations: usize,
}

impl Progress {
    /// The curvature along the step without the multiple of the norm, relative to that with it.
    fn curvature(&self) -> f64 {
        if self.regularisation > 0.0 {
            1.0 - self.regularisation * (self.step / self.stationarity).powi(2)
        } else {
            1.0
        }
    }
}

/// The end of a search.
pub struct Solution {
    pub x: DVector<f64>,
    pub iterate: Iterate,
    pub status: Status,
    pub progress: Progress,
}

/// Solves a nonlinear program from `x`, with known multipliers if there are any.
///
/// # Errors
/// Those of the problem; an [option](Options::check) is out of range.
pub fn solve<P: Nlp>(
    problem: &mut P,
    x: DVector<f64>,
    multipliers: Option<&[f64]>,
    kkt: Kkt,
    options: &Options,
    observe: &mut dyn FnMut(&Progress),
) -> Result<Solution> {
    options.check()?;
    let mut state = State::new(problem, x, multipliers, kkt, options)?;
    if state.is_solution(problem, options)? {
        observe(&state.progress);
        return Ok(state.end(Status::Converged));
    }
    loop {
        if let Some(status) = iterate(problem, &mut state, options, observe)? {
            return Ok(state.end(status));
        }
    }
}

/// Takes one iteration; returns the status if the search is over.
pub(crate) fn iterate<P: Nlp>(
    problem: &mut P,
    state: &mut State,
    options: &Options,
    observe: &mut dyn FnMut(&Progress),
) -> Result<Option<Status>> {
    state.derive(problem)?;
    if let Some(status) = state.stop(problem, options) {
        observe(&state.progress);
        return Ok(Some(status));
    }
    let mut step = state.kkt.step(state.scale(), &mut state.progress, options);
    if let Some(step) = step.take_if(|_| state.raise_first_barrier(options)) {
        state.kkt.reuse(step);
        return Ok(None);
    }
    let is_part = state.iterate.curvature_weight < 1.0;
    if is_part && state.is_within_tolerance(options) {
        // A minimum counts only with all second derivatives.
        state.iterate.curvature_weight = 1.0;
        if let Some(step) = step {
            state.kkt.reuse(step);
        }
        return Ok(None);
    }
    if state.is_stationary(options) {
        observe(&state.progress);
        return state.tighten_end(problem, options);
    }
    let taken = match step {
        Some(step) => {
            let taken = line_search(problem, state, &step, options)?;
            state.kkt.reuse(step);
            taken
        }
        None => None,
    };
    observe(&state.progress);
    let used = state.progress.regularisation;
    // Without a longest step hard rows alone may have made this one short.
    if !state.iterate.has_filter || options.longest_step.is_finite() {
        state.kkt.adapt(state.taken, used, options);
    }
    state.iterate.adapt_curvature_weight(used > 0.0, options);
    let at = BarrierState::after(state, taken.unwrap_or_default(), options);
    let solved = taken.is_none() || options.barrier.is_solved(&at);
    if solved && !state.is_last_barrier(options) {
        let before = state.iterate.barrier.mu;
        let barrier = Barrier::of_total(options.barrier.next(&at), state, options);
        if taken.is_none() {
            // Rounding hides the rest of the decrease with this barrier parameter.
            state.iterate.recentre(&state.h, barrier);
        }
        state.iterate.set_barrier(barrier, options.multiplier_range);
        // At most so large that it continues to decrease.
        if state.tighten(problem, 0.5 * before, options)? == Tightened::QuadratureTooCoarse {
            return Ok(Some(Status::QuadratureTooCoarse));
        }
    } else if taken.is_none() && is_part {
        state.iterate.curvature_weight = 1.0;
    } else if taken.is_none() && !state.accepts_rounding(options) {
        return Ok(Some(Status::NoDescent));
    }
    Ok(None)
}
