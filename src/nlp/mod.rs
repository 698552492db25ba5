//! A primal-dual interior-point method for nonlinear programs with many rows, most of them far from active.
//!
//! $$ \min_x f(x) \quad \text{subject to} \quad h_j(x) \le 0 \ \text{or} \ h_j(x) = 0 . $$
//!
//! Each row has a slack $s_j > 0$ and an elastic variable $t_j > 0$, and an exact $\ell_1$ penalty $\nu$ bounds its
//! multiplier (Gould, Orban and Toint, *An interior-point l1-penalty method for nonlinear optimization*, 2015). With
//! the weights $w_j$ of the rows, which are those of a quadrature, the barrier problem is
//!
//! $$ \min_{x, s, t} f(x) + \sum_j w_j (\nu t_j - \mu \log s_j - \mu \log t_j)
//!    \quad \text{subject to} \quad h_j(x) + s_j = t_j , $$
//!
//! and equalities have the terms of an augmented Lagrangian. It has feasible points whatever `x` is, so no start has to
//! keep the rows and no restoration phase is needed; rows with elastic variables that do not vanish are those that
//! cannot be kept. The loop of [`solve`] is that of Nocedal and Wright, *Numerical Optimization*, algorithm 19.2, and
//! of Wächter and Biegler, *On the implementation of an interior-point filter line-search algorithm*, 2006 (WB):
//!
//! 1. `kkt`: the Newton step of the primal-dual equations, condensed to `x`; multiples of a norm are added to the
//!    Hessian until the condensed matrix is positive definite (WB 3.1).
//! 2. `line_search`: backtracking until the barrier function is sufficiently below the largest of its last values; each
//!    slack and each multiplier keeps a part of its distance from its bounds, row by row (WB 2.2).
//! 3. `barrier`: the barrier parameter is reduced when the predicted decrease of its problem is small
//!    (`BarrierUpdate`).
//! 4. [`Nlp::tighten`]: after each reduction the rows are evaluated between the points of the quadrature.

mod barrier;
mod iterate;
mod kkt;
mod line_search;
mod options;

pub use barrier::Barrier;
pub(crate) use barrier::{BarrierUpdate, Monotone};
pub use iterate::{Equality, Iterate, Row, Term};
pub use kkt::{Bordered, Kkt};
pub use options::Options;

use crate::error::Result;
use line_search::{leave_saddle, line_search};
use nalgebra::DVector;

/// A nonlinear program.
pub trait Nlp {
    /// Evaluates the objective at `x`, and all rows into `h`; the objective is infinite where a row outside the working
    /// set is violated.
    ///
    /// # Errors
    /// Those of the functions of the user.
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64>;

    /// Computes gradient and Hessian of the objective plus the weighted rows at `x`, with the weights of `iterate`.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    fn derivatives(&mut self, x: &DVector<f64>, iterate: &Iterate, out: &mut Kkt) -> Result<()>;

    /// The factor of the weights of all rows at `x`: the horizon.
    fn measure(&self, x: &DVector<f64>) -> f64;

    /// The equalities, with their first penalties for an objective of this density.
    fn equalities(&self, density: f64) -> Vec<Equality>;

    /// The inequalities of the working set, for values of all rows.
    fn working_set(&mut self, h: &[f64]) -> Vec<Row>;

    /// The largest fraction of a step from `x` that may be tried, at most 1.
    fn longest(&self, x: &DVector<f64>, step: &DVector<f64>) -> f64;

    /// Evaluates rows between the points at `x`, the last evaluated one, and adapts their margins; at the `end` of the
    /// search margins only grow.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    fn tighten(&mut self, x: &DVector<f64>, end: bool) -> Result<Tightened>;

    /// The largest violation of a row at `x`, between the points too, in its unit.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    fn violation(&mut self, x: &DVector<f64>) -> Result<f64>;

    /// Returns true if the search is to stop.
    fn is_stopped(&self) -> bool;
}

/// The result of a look at the rows between the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tightened {
    /// The largest violation of a row, in its unit.
    Violation(f64),
    /// The points are too few for the objective.
    Coarse,
}

/// The reason of the end of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All tolerances are met.
    Converged,
    /// No step decreases the barrier function.
    NoDescent,
    /// Rows are violated although the penalty is at its largest value.
    Infeasible,
    /// The largest number of iterations.
    Iterations,
    /// The points are too few for the objective.
    Coarse,
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
    /// The length of the step in the norm, and the fraction of it that was taken.
    pub step: f64,
    pub alpha: f64,
    pub factorisations: usize,
}

/// The end of a search.
pub struct Solution {
    pub x: DVector<f64>,
    pub iterate: Iterate,
    pub status: Status,
    pub progress: Progress,
    pub violation: f64,
}

/// A search in progress.
pub(crate) struct State {
    pub x: DVector<f64>,
    pub f: f64,
    pub h: Vec<f64>,
    pub iterate: Iterate,
    pub kkt: Kkt,
    pub progress: Progress,
    pub measure: f64,
    /// The numbers of iterations, and of times that rows were tightened at the end.
    iterations: usize,
    rounds: usize,
    /// The barrier function at the last iterates with this barrier and working set.
    merits: std::collections::VecDeque<f64>,
}

/// Solves a nonlinear program from `x`, with known multipliers if there are any.
///
/// # Errors
/// Those of the problem.
pub fn solve<P: Nlp>(
    problem: &mut P,
    x: DVector<f64>,
    multipliers: Option<&[f64]>,
    kkt: Kkt,
    options: &Options,
    observe: &mut dyn FnMut(&Progress),
) -> Result<Solution> {
    let mut state = State::new(problem, x, multipliers, kkt, options)?;
    let update = Monotone::new(options);
    loop {
        state.derive(problem)?;
        if let Some(status) = state.stop(problem, options) {
            observe(&state.progress);
            return state.end(problem, status);
        }
        let step = state.kkt.step(state.scale(), &mut state.progress, options);
        if state.is_stationary(options) {
            observe(&state.progress);
            match state.tighten_end(problem, options)? {
                Some(status) => return state.end(problem, status),
                None => continue,
            }
        }
        let taken = match step {
            Some(step) => line_search(problem, &mut state, &step, options)?,
            None => None,
        };
        observe(&state.progress);
        let (alpha, used) = (state.progress.alpha, state.progress.regularisation);
        state.kkt.adapt(alpha, used, options);
        let solved = taken.is_none_or(|decrease| update.is_solved(&state, decrease));
        if solved && !state.is_last_barrier(options) {
            let barrier = update.next(&state);
            if taken.is_none() {
                // Rounding hides the rest of the decrease with this barrier parameter.
                state.iterate.recentre(&state.h, barrier);
            }
            state.iterate.set_barrier(barrier, options.multiplier_range);
            if state.tighten(problem, options)? == Tightened::Coarse {
                return state.end(problem, Status::Coarse);
            }
        } else if taken.is_none() {
            return state.end(problem, Status::NoDescent);
        }
    }
}

impl State {
    fn new<P: Nlp>(
        problem: &mut P,
        x: DVector<f64>,
        multipliers: Option<&[f64]>,
        kkt: Kkt,
        options: &Options,
    ) -> Result<Self> {
        let mut h = Vec::new();
        let f = problem.value(&x, &mut h)?;
        let (working, measure) = (problem.working_set(&h), problem.measure(&x));
        let weight: f64 = working.iter().map(|row| measure * row.weight).sum();
        let scale = f.abs().max(f64::EPSILON);
        let first = match multipliers {
            Some(_) => options.warm_barrier,
            None => options.first_barrier,
        };
        let barrier = Barrier {
            // Without rows any will do.
            mu: first.max(options.last_barrier) * scale / if weight > 0.0 { weight } else { 1.0 },
            nu: options.penalty * scale / measure,
        };
        let mut iterate = Iterate::new(h.len(), barrier, problem.equalities(scale / measure));
        iterate.set_working(working, &h);
        if let Some(lambda) = multipliers {
            iterate.set_multipliers(lambda, &h, options.room, options.multiplier_range);
        }
        Ok(Self {
            x,
            f,
            h,
            iterate,
            kkt,
            progress: Progress::default(),
            measure,
            iterations: 0,
            rounds: 0,
            merits: Default::default(),
        })
    }

    /// Computes the derivatives at the current iterate.
    fn derive<P: Nlp>(&mut self, problem: &mut P) -> Result<()> {
        self.measure = problem.measure(&self.x);
        problem.derivatives(&self.x, &self.iterate, &mut self.kkt)?;
        self.iterations += 1;
        let working = self.iterate.working.iter();
        self.progress = Progress {
            objective: self.f,
            measure: self.measure,
            stationarity: f64::INFINITY,
            complementarity: self.complementarity(),
            infeasibility: working.fold(0.0, |most, row| self.h[row.at].max(most)),
            ..Progress::default()
        };
        Ok(())
    }

    /// The reason to stop before the end.
    fn stop<P: Nlp>(&self, problem: &P, options: &Options) -> Option<Status> {
        if problem.is_stopped() {
            Some(Status::Stopped)
        } else {
            (self.iterations > options.iterations).then_some(Status::Iterations)
        }
    }

    fn is_stationary(&self, options: &Options) -> bool {
        self.is_last_barrier(options) && self.progress.stationarity <= options.tolerance
    }

    fn is_last_barrier(&self, options: &Options) -> bool {
        // The objective and with it the last parameter change a little from step to step.
        self.complementarity() <= 1.1 * options.last_barrier
    }

    /// Adapts the margins of the rows at the current point.
    fn tighten<P: Nlp>(&mut self, problem: &mut P, options: &Options) -> Result<Tightened> {
        let found = problem.tighten(&self.x, false)?;
        if let Tightened::Violation(violation) = found
            && violation > options.feasible
        {
            self.raise_penalty(options);
        }
        self.update_equalities(options);
        self.reset(problem, options)?;
        Ok(found)
    }

    fn update_equalities(&mut self, options: &Options) {
        let most = options.largest_penalty * self.scale() / self.measure;
        self.iterate
            .update_equalities(&self.h, options.equality_factor, most);
    }

    /// Raises the penalty if a multiplier has reached it, up to the largest one; returns true if it is raised.
    fn raise_penalty(&mut self, options: &Options) -> bool {
        let Barrier { mu, nu } = self.iterate.barrier;
        if !self.iterate.is_at_penalty() {
            return false;
        }
        let most = options.largest_penalty * self.scale() / self.measure;
        let raised = (nu * options.penalty_factor).min(most);
        self.iterate
            .set_barrier(Barrier { mu, nu: raised }, options.multiplier_range);
        raised > nu
    }

    /// Looks at the rows between the points at a stationary point. Returns the status if the search is over; otherwise
    /// margins or the penalty have changed.
    fn tighten_end<P: Nlp>(
        &mut self,
        problem: &mut P,
        options: &Options,
    ) -> Result<Option<Status>> {
        let violation = match problem.tighten(&self.x, true)? {
            Tightened::Coarse => return Ok(Some(Status::Coarse)),
            Tightened::Violation(violation) => violation,
        };
        self.rounds += 1;
        if violation > options.feasible {
            self.update_equalities(options);
            // Between the points margins help, at them only the penalty.
            let elastic = self.progress.infeasibility > options.feasible;
            let raised = self.raise_penalty(options);
            if self.rounds > options.rounds || (elastic && !raised) {
                return Ok(Some(Status::Infeasible));
            }
            self.reset(problem, options)?;
            return Ok(None);
        }
        self.reset(problem, options)?;
        let gap = self.measure * self.iterate.gap() / self.scale();
        if gap > options.tolerance && self.rounds <= options.rounds {
            // Margins were too large: the barrier parameter follows, so that the rows can.
            let total = gap.min(options.warm_barrier);
            let mu = total * self.scale() / self.total_weight();
            let nu = self.iterate.barrier.nu;
            self.iterate
                .set_barrier(Barrier { mu, nu }, options.multiplier_range);
            return Ok(None);
        }
        if self.rounds <= options.rounds
            && self.progress.regularisation > 0.0
            && let Some(direction) = self.kkt.negative_curvature(self.scale())
            && leave_saddle(problem, self, &direction, options)?
        {
            return Ok(None);
        }
        Ok(Some(Status::Converged))
    }

    /// Evaluates the rows again after a change of margins.
    fn reset<P: Nlp>(&mut self, problem: &mut P, options: &Options) -> Result<()> {
        self.merits.clear();
        self.f = problem.value(&self.x, &mut self.h)?;
        let working = problem.working_set(&self.h);
        self.iterate.set_working(working, &self.h);
        self.iterate.reset(&self.h, options.multiplier_range);
        Ok(())
    }

    /// The end of the search, with the violation between the points.
    fn end<P: Nlp>(mut self, problem: &mut P, status: Status) -> Result<Solution> {
        let violation = problem.violation(&self.x)?;
        self.progress.complementarity = self.complementarity();
        Ok(Solution {
            x: self.x,
            iterate: self.iterate,
            status,
            progress: self.progress,
            violation,
        })
    }

    /// The size of the objective, in which gradients and barriers are measured.
    pub fn scale(&self) -> f64 {
        self.f.abs().max(f64::EPSILON)
    }

    /// The sum of the weights of the working set.
    pub fn total_weight(&self) -> f64 {
        let sum: f64 = self.iterate.working.iter().map(|row| row.weight).sum();
        self.measure * sum
    }

    /// The barrier parameter summed over all rows, relative to the objective.
    pub fn complementarity(&self) -> f64 {
        self.iterate.barrier.mu * self.total_weight() / self.scale()
    }

    /// The barrier function.
    fn merit<P: Nlp>(&self, problem: &P) -> f64 {
        self.f + problem.measure(&self.x) * self.iterate.barrier_terms(&self.h)
    }
}
