//! A search in progress.

use super::filter::Filter;
use super::leave_saddle::leave_saddle;
use super::line_search::Trial;
use super::{Barrier, Iterate, Kkt, Nlp, Options, Progress, Row, RowState, Solution, Status, Tightened};
use crate::error::Result;
use nalgebra::DVector;

/// A search in progress.
pub(crate) struct State {
    pub x: DVector<f64>,
    pub f: f64,
    pub h: Vec<f64>,
    pub iterate: Iterate,
    pub kkt: Kkt,
    pub progress: Progress,
    pub measure: f64,
    /// The multipliers with which the search began.
    pub(super) known: Option<Vec<f64>>,
    /// The given [size of the objective](Options::scale).
    given_scale: Option<f64>,
    /// The fraction of the last step that was taken, of the one that the quadratic model is to hold for.
    pub(super) taken: f64,
    /// The numbers of iterations, and of times that rows were tightened at the last barrier parameter.
    pub(super) iterations: usize,
    rounds: usize,
    /// The weighted sum of all violations when the penalty was last raised.
    excess: f64,
    /// True at a local minimum of that sum, at which it is not zero.
    is_infeasible: bool,
    /// The length of the gradient of the Lagrangian, relative to the objective, at the last iterate within the
    /// tolerance.
    residual: f64,
    /// The barrier function at the last iterates with this barrier and working set.
    pub(super) merits: std::collections::VecDeque<f64>,
    pub(super) filter: Filter,
    /// The barrier function when it last decreased by more than the barrier parameter summed over all rows, and the
    /// number of iterations since then.
    pub(super) decreased: f64,
    pub(super) stalled: usize,
    /// Memory of a line search, of the rows of the working set, and of values of rows.
    pub(super) trial: Trial,
    pub(super) longer: Trial,
    pub(crate) rows: Vec<Row>,
    before: Vec<f64>,
}

impl State {
    pub(crate) fn new<P: Nlp>(
        problem: &mut P,
        x: DVector<f64>,
        multipliers: Option<&[f64]>,
        kkt: Kkt,
        options: &Options,
    ) -> Result<Self> {
        let mut state = Self::idle(x, kkt);
        state.begin(problem, multipliers, options)?;
        Ok(state)
    }

    /// The memory of a search that has not [begun](Self::begin).
    pub(crate) fn idle(x: DVector<f64>, kkt: Kkt) -> Self {
        Self {
            x,
            f: f64::NAN,
            h: Vec::new(),
            iterate: Iterate::default(),
            kkt,
            progress: Progress::default(),
            measure: f64::NAN,
            known: None,
            given_scale: None,
            taken: 0.0,
            iterations: 0,
            rounds: 0,
            excess: f64::INFINITY,
            is_infeasible: false,
            residual: f64::INFINITY,
            merits: Default::default(),
            filter: Filter::default(),
            decreased: f64::INFINITY,
            stalled: 0,
            trial: Trial::default(),
            longer: Trial::default(),
            rows: Vec::new(),
            before: Vec::new(),
        }
    }

    /// Begins a search at the unknowns, and keeps the memory of the one before.
    pub(crate) fn begin<P: Nlp>(
        &mut self,
        problem: &mut P,
        multipliers: Option<&[f64]>,
        options: &Options,
    ) -> Result<()> {
        self.given_scale = options.scale;
        self.f = problem.value(&self.x, &mut self.h)?;
        problem.working_set(&self.h, &mut self.rows);
        self.measure = problem.measure(&self.x);
        let measure = self.measure;
        let scale = self.scale();
        let known = multipliers.iter().copied().flatten();
        let largest = known.fold(0.0_f64, |most, z| most.max(z.abs()));
        let penalty = options.penalty * scale / measure;
        let nu = penalty.max(options.penalty_of_multipliers * largest);
        let equalities = problem.equalities();
        self.iterate.restart(Barrier { mu: 0.0, nu }, equalities);
        self.iterate.has_filter = problem.has_filter();
        self.iterate.compliance = options.compliance * measure / scale;
        // In the memory of the search before.
        match (multipliers, &mut self.known) {
            (Some(given), Some(known)) => given.clone_into(known),
            (given, known) => *known = given.map(<[f64]>::to_vec),
        }
        let first = match self.known {
            Some(_) => options.min_warm_barrier.min(options.warm_barrier),
            None => options.first_barrier,
        };
        self.set_first_barrier(first, options);
        self.progress = Progress::default();
        (self.iterations, self.rounds) = (0, 0);
        (self.excess, self.residual) = (f64::INFINITY, f64::INFINITY);
        self.is_infeasible = false;
        self.forget_merits();
        Ok(())
    }

    /// Sets the first barrier parameter, summed over all rows and relative to the objective, and the rows with it.
    pub(super) fn set_first_barrier(&mut self, total: f64, options: &Options) {
        let weight: f64 = self.rows.iter().map(|row| self.measure * row.weight).sum();
        // Without rows any value is sufficient.
        let weight = if weight > 0.0 { weight } else { 1.0 };
        self.iterate.barrier.mu = total.max(options.last_barrier) * self.scale() / weight;
        self.iterate.working.clear();
        self.iterate.set_working(&self.rows, &self.h);
        if let Some(lambda) = &self.known {
            self.iterate.set_multipliers(lambda, &self.h, options);
        }
    }

    /// Allocates memory for a working set of all rows.
    pub(crate) fn allocate(&mut self, rows: usize) {
        self.rows.reserve(rows);
        let trials = [&mut self.trial, &mut self.longer];
        let iterates = trials.map(|trial| &mut trial.iterate).into_iter();
        for iterate in iterates.chain([&mut self.iterate]) {
            iterate.allocate(rows);
        }
    }

    /// Adapts the working set to the rows.
    pub(super) fn list_rows<P: Nlp>(&mut self, problem: &mut P) {
        problem.working_set(&self.h, &mut self.rows);
        self.iterate.set_working(&self.rows, &self.h);
    }

    /// Computes the derivatives at the current iterate.
    pub(super) fn derive<P: Nlp>(&mut self, problem: &mut P) -> Result<()> {
        self.measure = problem.measure(&self.x);
        problem.derivatives(&self.x, &self.iterate, &mut self.kkt)?;
        let values = self.iterate.equalities.iter().map(|held| self.h[held.row.at]);
        self.kkt.equalities.values = DVector::from_iterator(self.iterate.equalities.len(), values);
        self.iterations += 1;
        let working = self.iterate.working.iter();
        self.progress = Progress {
            objective: self.f,
            measure: self.measure,
            stationarity: f64::INFINITY,
            complementarity: self.complementarity(),
            infeasibility: working
                .map(|of| of.row.violation(self.h[of.row.at]))
                .chain(self.kkt.equalities.values.iter().map(|value| value.abs()))
                .fold(0.0, f64::max),
            ..Progress::default()
        };
        Ok(())
    }

    /// The reason to stop before the end.
    pub(super) fn stop<P: Nlp>(&self, problem: &P, options: &Options) -> Option<Status> {
        if problem.is_stopped() {
            Some(Status::Stopped)
        } else if self.is_infeasible {
            Some(Status::Infeasible)
        } else {
            (self.iterations > options.iterations).then_some(Status::Iterations)
        }
    }

    /// Returns true if the Newton decrement and the gradient of the Lagrangian are within the tolerance at the last
    /// barrier parameter, or if another step would no longer halve that gradient, because of rounding.
    pub(super) fn is_stationary(&mut self, options: &Options) -> bool {
        if !self.is_within_tolerance(options) {
            self.residual = f64::INFINITY;
            return false;
        }
        let residual = self.kkt.dual_length() / self.scale();
        let before = std::mem::replace(&mut self.residual, residual);
        residual <= options.tolerance || residual > 0.5 * before
    }

    /// Returns true if the Newton decrement is within the tolerance at the last barrier parameter, and the equalities
    /// and hard rows are kept.
    pub(super) fn is_within_tolerance(&self, options: &Options) -> bool {
        let hard = self.iterate.working.iter().filter(|of| of.row.is_hard).map(|of| self.h[of.row.at]);
        let held = self.kkt.equalities.values.iter().map(|value| value.abs());
        let are_kept = hard.chain(held).all(|value| value <= options.feasible);
        self.is_last_barrier(options) && self.progress.stationarity <= options.tolerance && are_kept
    }

    /// Returns true if the search may continue after no fraction of a step decreased the barrier function: to the end,
    /// within the tolerance, where rounding hides the decrease.
    pub(super) fn accepts_rounding(&mut self, options: &Options) -> bool {
        self.residual = 0.0;
        self.is_within_tolerance(options)
    }

    pub(super) fn is_last_barrier(&self, options: &Options) -> bool {
        // The objective and with it the last parameter change a little from step to step.
        self.complementarity() <= 1.1 * options.last_barrier
    }

    /// Adapts the margins of the rows at the current point, and raises the barrier parameter up to `most` if they
    /// change more than it can follow.
    pub(super) fn tighten<P: Nlp>(&mut self, problem: &mut P, most: f64, options: &Options) -> Result<Tightened> {
        if self.is_last_barrier(options) {
            self.rounds += 1;
        }
        let found = problem.tighten(&self.x, &mut self.h, self.rounds)?;
        if let Tightened::Violation(violation) = found
            && violation > options.feasible
        {
            self.raise_penalties(options);
        }
        self.follow(problem, most, options)?;
        Ok(found)
    }

    /// Raises the penalties of violated rows whose multipliers have reached them, and those of all rows if the
    /// violations have decreased too little since the last raise; returns true if one is raised.
    ///
    /// Violations that cost more than the objective and have decreased too little are a local minimum of the violation
    /// (Byrd, Curtis and Nocedal, *Infeasibility detection and SQP methods for nonlinear optimization*, 2010).
    fn raise_penalties(&mut self, options: &Options) -> bool {
        if !self.iterate.is_at_penalty(&self.h, options.feasible) {
            return false;
        }
        let [mut sum, mut cost] = [0.0; 2];
        for of in &self.iterate.working {
            let excess = self.measure * of.row.weight * of.row.violation(self.h[of.row.at]);
            sum += excess;
            cost += if excess > 0.0 { of.penalty * excess } else { 0.0 };
        }
        let most = options.largest_penalty * self.scale() / self.measure;
        let Barrier { mu, nu } = self.iterate.barrier;
        let stalled = sum > options.infeasible_progress * self.excess;
        self.is_infeasible = stalled && cost > options.infeasible_cost * self.scale();
        self.excess = sum;
        let raised = stalled && nu < most;
        if raised {
            let nu = (options.penalty_factor * nu).min(most);
            self.iterate.set_barrier(Barrier { mu, nu }, options.multiplier_range);
        }
        self.iterate.raise_penalties(&self.h, options, most) || raised
    }

    /// Evaluates the rows between the points at a stationary point. Returns the status if the search is over; otherwise
    /// margins or the penalty have changed.
    pub(super) fn tighten_end<P: Nlp>(&mut self, problem: &mut P, options: &Options) -> Result<Option<Status>> {
        self.rounds += 1;
        let range = options.multiplier_range;
        self.iterate.update_multipliers(&self.h, range);
        let violation = match problem.tighten(&self.x, &mut self.h, self.rounds)? {
            Tightened::QuadratureTooCoarse => return Ok(Some(Status::QuadratureTooCoarse)),
            Tightened::Beyond if self.rounds <= options.rounds && self.progress.infeasibility <= options.feasible => {
                self.follow(problem, f64::INFINITY, options)?;
                return Ok(None);
            }
            Tightened::Beyond => 0.0,
            Tightened::Violation(violation) => violation,
        };
        if violation > options.feasible {
            // Between the points margins help, at them only the penalty.
            let elastic = self.progress.infeasibility > options.feasible;
            let raised = self.raise_penalties(options);
            if self.rounds > options.rounds || (elastic && !raised) {
                return Ok(Some(Status::Infeasible));
            }
            self.follow(problem, f64::INFINITY, options)?;
            return Ok(None);
        }
        self.reset(problem, options)?;
        let gap = self.measure * self.iterate.gap() / self.scale();
        if gap > options.tolerance && self.rounds <= options.rounds {
            // Margins were too large: the barrier parameter follows, so that the rows can.
            let total = gap.min(options.warm_barrier);
            let mu = total * self.scale() / self.total_weight();
            let nu = self.iterate.barrier.nu;
            self.iterate.set_barrier(Barrier { mu, nu }, options.multiplier_range);
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

    /// Evaluates the rows again after a change of margins, and raises the barrier parameter to the change of the
    /// objective that this makes to first order, at most to `most`: with a smaller one the rows cannot follow.
    fn follow<P: Nlp>(&mut self, problem: &mut P, most: f64, options: &Options) -> Result<()> {
        let mut before = std::mem::take(&mut self.before);
        before.clone_from(&self.h);
        self.reset(problem, options)?;
        // Rows at their penalty are violated with any margin.
        let change = |of: &RowState| {
            if of.is_at_penalty() {
                0.0
            } else {
                let moved = (self.h[of.row.at] - before[of.row.at]).abs();
                of.row.weight * of.multiplier.abs() * moved
            }
        };
        let change = self.measure * self.iterate.working.iter().map(change).sum::<f64>();
        self.before = before;
        let change = change.min(options.warm_barrier * self.scale());
        let Barrier { mu, nu } = self.iterate.barrier;
        let total = self.total_weight();
        if change > mu * total {
            let barrier = Barrier { mu: (change / total).min(most).max(mu), nu };
            self.iterate.set_barrier(barrier, options.multiplier_range);
        }
        Ok(())
    }

    /// Evaluates the rows again after a change of margins.
    pub(super) fn reset<P: Nlp>(&mut self, problem: &mut P, options: &Options) -> Result<()> {
        self.forget_merits();
        self.f = problem.value(&self.x, &mut self.h)?;
        problem.working_set(&self.h, &mut self.rows);
        if !self.f.is_finite() {
            // Rows of the new working set were not in the last one.
            self.f = problem.value(&self.x, &mut self.h)?;
        }
        self.iterate.set_working(&self.rows, &self.h);
        self.iterate.reset(&self.h, options.multiplier_range);
        Ok(())
    }

    /// The end of the search.
    pub(super) fn end(mut self, status: Status) -> Solution {
        self.progress.complementarity = self.complementarity();
        // Other users of its terms want those of the Lagrangian.
        self.iterate.curvature_weight = 1.0;
        Solution { x: self.x, iterate: self.iterate, status, progress: self.progress }
    }

    /// The size of the objective, relative to which gradients and barriers are measured.
    pub fn scale(&self) -> f64 {
        self.given_scale.unwrap_or(self.f.abs().max(f64::EPSILON))
    }

    /// The sum of the weights of the working set.
    pub fn total_weight(&self) -> f64 {
        let sum: f64 = self.iterate.working.iter().map(|of| of.row.weight).sum();
        self.measure * sum
    }

    /// The barrier parameter summed over all rows, relative to the objective.
    pub fn complementarity(&self) -> f64 {
        self.iterate.barrier.mu * self.total_weight() / self.scale()
    }

    /// The barrier function.
    pub(super) fn merit<P: Nlp>(&self, problem: &P) -> f64 {
        let measure = |row| problem.row_measure(&self.x, row);
        self.f + self.iterate.barrier_terms(measure)
    }
}
