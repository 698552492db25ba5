//! The search on one quadrature.

use super::barrier::Barrier;
use super::barrier_cost::BarrierCost;
use super::iterate::Iterate;
use super::newton::{Merit, Newton, move_by};
use super::{Candidate, Context, Multipliers, Stage};
use crate::constraint::Constraint;
use crate::error::Result;
use crate::motion::Watch;
use crate::relax::transcription::{Grid, Peak, Scan};
use crate::relax::tuning::{
    CONSTRAINED_STEPS, FINE, FIRST_PRICE, FLOOR, GROWTH, LATE, LEAVE, LEAVE_FACTOR, LEAVE_TRIES,
    LOOK, MOST_POINTS, ON_THE_WAY, ROOM, SCAN, SMALLEST_COST,
};
use crate::relax::{CostWithControl, Iteration, Objective, horizon_slope};
use nalgebra::{DMatrix, DVector};

/// The end of a search on one quadrature.
pub(super) enum End {
    /// No further decrease is possible.
    Done,
    /// The quadrature is too coarse.
    Coarse,
    /// At a saddle point, with a curve of lower cost known.
    Saddle,
}

/// A search in progress.
pub(super) struct Search<'g, 'a, K, P> {
    pub(super) grid: &'g Grid<f64>,
    /// The times between the points at which rows are evaluated, during the search and at its end.
    scans: [&'g Scan; 2],
    /// The cost alone by a finer quadrature.
    finer: Objective<'g, f64, P>,
    pub(super) objective: Merit<'g, 'a, K, P>,
    newton: Newton,
    pub(super) stage: Stage,
    /// True if the number of points may increase.
    refinable: bool,
    pub(super) horizon: f64,
    /// The derivatives of the coefficients with respect to the horizon, if requested.
    rates: Option<DMatrix<f64>>,
    constrained: bool,
    /// The norm of the gradient in the metric of the Hessian, rows included: the decrease predicted by the last step,
    /// if that was a full one.
    decrement: f64,
    /// Curves that appear to satisfy the constraints.
    kept: &'g mut Vec<DMatrix<f64>>,
    watch: &'g Watch,
}

/// Minimises from a candidate with its number of points.
pub(super) fn search<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    candidate: &mut Candidate,
    kept: &mut Vec<DMatrix<f64>>,
    stage: Stage,
    observe: &mut dyn FnMut(Iteration),
) -> Result<End> {
    let Context {
        problem,
        grids,
        rows,
        watch,
    } = context;
    let (n, horizon, points) = (problem.model().dof(), problem.horizon(), candidate.points);
    let basis = candidate.path.basis.clone();
    let grid = if rows.of().equalities.contains(&true) {
        grids.collocated(&basis, points, horizon)
    } else if rows.count() > 0 {
        grids.with_ends(&basis, points, horizon)
    } else {
        grids.get(&basis, points, horizon)
    };
    // Not a multiple, so that it sees between the points.
    let finer = grids.get(&basis, points * 3 / 2 + 7, horizon);
    let looks = SCAN * points;
    let last = if stage.last {
        looks.max(FINE / basis.segments())
    } else {
        looks
    };
    let scans = [looks, last].map(|times| grids.scan(&basis, times, horizon));
    let barrier = Barrier { mu: 1.0, nu: 1.0 };
    let cost = BarrierCost::new(rows.clone(), barrier, &grid);
    let objective = Objective::new(&grid, cost, n);
    let kind = usize::from(rows.count() > 0);
    let mut newton = Newton::new(&objective);
    if rows.count() > 0 {
        newton.region.growth = GROWTH;
    }
    Search {
        grid: &grid,
        scans: scans.each_ref().map(|scan| &**scan),
        finer: Objective::new(&finer, rows.cost.clone(), n),
        newton,
        objective,
        stage,
        refinable: points < MOST_POINTS[kind] * basis.degree(),
        horizon,
        rates: stage.slope.then(|| candidate.path.rates(problem)),
        constrained: rows.count() > 0,
        decrement: f64::INFINITY,
        kept,
        watch,
    }
    .run(candidate, observe)
}

impl<K: Constraint, P: CostWithControl> Search<'_, '_, K, P> {
    fn run(
        &mut self,
        candidate: &mut Candidate,
        observe: &mut dyn FnMut(Iteration),
    ) -> Result<End> {
        let stage = self.stage;
        if self.constrained {
            self.start(candidate)?;
            if stage.last && self.kept.is_empty() {
                self.kept.push(candidate.path.coefficients.clone());
            }
        }
        let mut trial = candidate.path.coefficients.clone();
        let mut now = Iterate::new(candidate.path.coefficients.clone());
        let (mut steps, mut end) = (0_usize, None);
        while end.is_none() {
            let out = self.is_over(steps);
            self.evaluate(&mut now, steps, out)?;
            let stationary = now.at_last_barrier && now.iteration.gradient_norm <= stage.tolerance;
            let done = stationary || out;
            if (done || steps % LOOK == LOOK - 1) && self.is_coarse(&mut now, done)? {
                end = Some(End::Coarse);
            } else if done {
                // Rows may be broken between the points, or because the price of that is low.
                let peaks = self.look_between(&mut now)?;
                let broken = now.violation > stage.feasible;
                if broken && !out && self.mend(&peaks) {
                    self.objective.cost_mut().list_those_near();
                    self.decrement = f64::INFINITY;
                } else {
                    end = Some(End::Done);
                }
            } else if let Some(promised) = self.newton.step(
                &mut self.objective,
                &now.coefficients,
                &mut trial,
                now.merit,
                &mut now.iteration,
            )? {
                std::mem::swap(&mut now.coefficients, &mut trial);
                self.update_list(&now.coefficients)?;
                self.after_step(&now, promised)?;
            } else {
                // Rounding hides what is left to gain with this barrier.
                self.objective.value(&now.coefficients)?;
                let weaker = self.constrained && !now.at_last_barrier && self.reduce_barrier(0.0);
                if !weaker {
                    self.is_coarse(&mut now, true)?;
                    self.look_between(&mut now)?;
                    end = Some(End::Done);
                }
            }
            observe(now.iteration);
            steps += 1;
        }
        let mut end = end.unwrap_or(End::Done);
        let mut fell_back = false;
        if stage.last && matches!(end, End::Done) && now.violation > stage.feasible {
            fell_back = self.fall_back(&mut now)?;
        }
        candidate.violation = now.violation;
        candidate.converged = matches!(end, End::Done)
            && !fell_back
            && now.at_last_barrier
            && now.iteration.gradient_norm <= stage.tolerance
            && now.violation <= stage.feasible
            && now.finer[1] <= stage.quadrature_tolerance;
        candidate.kept =
            self.constrained && !candidate.converged && now.violation <= stage.feasible;
        if stage.last && matches!(end, End::Done) {
            let (curvature, direction) = self.newton.smallest_curvature();
            candidate.smallest_curvature = curvature;
            if curvature < 0.0 && candidate.converged && self.leave_saddle(&mut now, &direction)? {
                end = End::Saddle;
            }
        }
        self.leave_in(candidate, now);
        // Last, since point by point it leaves no integral behind.
        if let (true, End::Done, Some(rates)) = (stage.last, &end, &self.rates) {
            let (grid, cost) = (self.grid, self.objective.cost_mut());
            let coefficients = &candidate.path.coefficients;
            candidate.horizon_slope = horizon_slope(grid, cost, coefficients, rates, self.horizon)?;
        }
        Ok(end)
    }

    /// Evaluates the merit function and its derivatives at the current point, with an updated metric when that matters.
    fn evaluate(&mut self, now: &mut Iterate, steps: usize, out: bool) -> Result<()> {
        let stage = self.stage;
        let mut fresh = steps.is_multiple_of(stage.fresh);
        loop {
            now.merit = self
                .newton
                .derive(&mut self.objective, &now.coefficients, fresh)?;
            let cost = self.objective.cost_mut().cost;
            let gradient_norm = self.newton.gradient_norm(cost).min(self.decrement);
            now.at_last_barrier = !self.constrained || self.is_last_barrier(cost);
            now.iteration = Iteration {
                start: None,
                horizon: self.horizon,
                segments: self.grid.segments,
                degree: self.grid.table.nrows() - 1,
                points: self.grid.points(),
                cost,
                gradient_norm,
                damping: 0.0,
                step: 0.0,
                factorisations: usize::from(fresh),
                violation: self.objective.cost_mut().largest_violation(),
            };
            let ends = now.at_last_barrier && (gradient_norm <= stage.tolerance || out);
            if fresh || !stage.last || !ends {
                return Ok(());
            }
            fresh = true;
        }
    }

    /// Returns true after the last step: at the limit, or when rows are still relaxed so late that another start is
    /// better.
    fn is_over(&mut self, steps: usize) -> bool {
        let late = self.constrained && steps >= CONSTRAINED_STEPS;
        let stuck = late && self.objective.cost_mut().largest_relaxation() > 0.0;
        stuck || steps >= self.stage.iterations || self.watch.stopped().is_some()
    }

    /// Checks, after a step that predicted `promised`, how near the minimum of this barrier is; reduces it if near.
    fn after_step(&mut self, now: &Iterate, promised: f64) -> Result<()> {
        self.decrement = f64::INFINITY;
        if !self.constrained {
            return Ok(());
        }
        let cost = now.iteration.cost.max(SMALLEST_COST);
        if self.newton.share == 1.0 && self.newton.region.damping == 0.0 {
            self.decrement = (2.0 * promised.max(0.0) / cost).sqrt();
        }
        // A damped step promises less than the next ones together may gain, which the gradient tells.
        let promised = if self.newton.region.damping > 0.0 {
            promised.max(0.5 * now.iteration.gradient_norm.powi(2) * cost)
        } else {
            promised
        };
        if !now.at_last_barrier && self.reduce_barrier(promised) {
            self.decrement = f64::INFINITY;
            let peaks = self.peaks(&now.coefficients, 0)?;
            if self.stage.last && peaks.iter().all(|peak| peak.height <= 0.0) {
                self.kept.push(now.coefficients.clone());
            }
            let late = self.total_barrier() < LATE * cost;
            // What is broken because that is cheap says nothing of what is between the points.
            if !(late && self.is_priced() && self.raise_price()) {
                self.set_margins(&peaks, late);
            }
        }
        Ok(())
    }

    /// Returns true if a finer quadrature gives a different cost. The tolerance is larger before the search is `done`.
    fn is_coarse(&mut self, now: &mut Iterate, done: bool) -> Result<bool> {
        let exact = self.finer.value(&now.coefficients)?;
        let error = (exact - now.iteration.cost).abs() / exact.max(SMALLEST_COST);
        now.finer = [exact, error];
        let on_the_way = if done { 0.0 } else { ON_THE_WAY };
        Ok(self.refinable && error > self.stage.quadrature_tolerance.max(on_the_way))
    }

    /// The largest violation at the current point, between the points too, and the peaks of the rows.
    fn look_between(&mut self, now: &mut Iterate) -> Result<Vec<Peak>> {
        now.violation = 0.0;
        if !self.constrained {
            return Ok(Vec::new());
        }
        self.objective.cost_mut().rows.unlisted_highest = f64::NEG_INFINITY;
        let mut peaks = self.peaks(&now.coefficients, 1)?;
        if self.objective.cost_mut().is_list_old() {
            self.objective.cost_mut().list_all();
            self.objective.value(&now.coefficients)?;
            peaks = self.peaks(&now.coefficients, 1)?;
        }
        let cost = self.objective.cost_mut();
        let excesses = peaks
            .iter()
            .map(|peak| peak.height * cost.rows.of().units[peak.row]);
        now.violation = excesses.fold(cost.largest_equality(), f64::max);
        Ok(peaks)
    }

    /// Returns to the last curve that satisfied the constraints; returns false if there is none.
    fn fall_back(&mut self, now: &mut Iterate) -> Result<bool> {
        let left = (now.coefficients.clone(), now.violation);
        while let Some(coefficients) = self.kept.pop() {
            now.coefficients = coefficients;
            self.look_between(now)?;
            if now.violation <= self.stage.feasible {
                self.is_coarse(now, true)?;
                now.iteration.cost = now.finer[0];
                return Ok(true);
            }
        }
        (now.coefficients, now.violation) = left;
        self.objective.value(&now.coefficients)?;
        Ok(false)
    }

    /// Sets the first barrier, margins and multipliers.
    fn start(&mut self, candidate: &Candidate) -> Result<()> {
        self.objective.value(&candidate.path.coefficients)?;
        let (horizon, times) = (self.horizon, &self.grid.times);
        let cost = self.objective.cost_mut();
        let (rows, near) = (cost.rows.count(), cost.mean_count());
        let density = cost.cost.max(SMALLEST_COST) / horizon;
        let scaled = |[mu, nu]: [f64; 2]| Barrier {
            mu: mu * density,
            nu: nu * density,
        };
        let first = scaled([candidate.first_barrier / near, FIRST_PRICE]);
        cost.barrier = candidate.barrier.map_or(first, scaled);
        cost.equalities.start(density);
        if let Some(known) = &candidate.penalties {
            cost.equalities.penalties.clone_from(known);
        }
        let known = candidate.multipliers.at(times, rows);
        let warm = known.is_some();
        if let Some(known) = known {
            cost.equalities.take(&known, &cost.kinds);
            cost.multipliers = known;
        }
        cost.relax();
        if warm && cost.largest_relaxation() <= ROOM {
            cost.set_barrier(cost.barrier);
        } else {
            // A weak barrier holds a curve that breaks its rows where it is.
            cost.barrier = first;
            cost.reset_multipliers();
        }
        cost.list_those_near();
        Ok(())
    }

    /// Updates the list of active rows if an unlisted one has come near.
    fn update_list(&mut self, coefficients: &DMatrix<f64>) -> Result<()> {
        if self.constrained && self.objective.cost_mut().is_list_old() {
            self.objective.cost_mut().list_all();
            self.objective.value(coefficients)?;
            self.objective.cost_mut().list_those_near();
        }
        Ok(())
    }

    /// The local maxima of rows near their bounds, between the points too.
    fn peaks(&mut self, coefficients: &DMatrix<f64>, scan: usize) -> Result<Vec<Peak>> {
        let cost = self.objective.cost_mut();
        self.scans[scan].peaks(&mut cost.rows, coefficients, FLOOR)
    }

    /// Moves along a direction of negative curvature, either way, to a smaller merit; returns false if there is none.
    fn leave_saddle(&mut self, now: &mut Iterate, direction: &DVector<f64>) -> Result<bool> {
        let mut trial = now.coefficients.clone();
        let mut length = LEAVE * now.iteration.cost.max(0.0).sqrt();
        for _ in 0..LEAVE_TRIES {
            for sign in [1.0, -1.0] {
                let from = &now.coefficients;
                move_by(&self.objective, from, direction, sign * length, &mut trial);
                if self.objective.value(&trial)? < now.merit {
                    now.coefficients = trial;
                    return Ok(true);
                }
            }
            length *= LEAVE_FACTOR;
        }
        Ok(false)
    }

    /// Stores the end of the search in the candidate.
    fn leave_in(&mut self, candidate: &mut Candidate, now: Iterate) {
        let (horizon, times) = (self.horizon, &self.grid.times);
        if self.constrained {
            let cost = self.objective.cost_mut();
            let density = cost.cost.max(SMALLEST_COST) / horizon;
            candidate.barrier = Some([cost.barrier.mu / density, cost.barrier.nu / density]);
            candidate.penalties = Some(cost.equalities.penalties.clone());
            cost.list_all();
            candidate.multipliers = Multipliers::new(times, &cost.multipliers, &cost.kinds);
        }
        candidate.path.coefficients = now.coefficients;
        candidate.gradient_norm = now.iteration.gradient_norm;
        [candidate.cost, candidate.quadrature_error] = now.finer;
    }
}
