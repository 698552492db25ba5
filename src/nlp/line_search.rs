//! Backtracking on the barrier function.

use super::filter::Accepted;
use super::iterate::MeasuredSum;
use super::kkt::Step;
use super::{Iterate, Nlp, Options, Row, RowStep, State};
use crate::error::Result;
use crate::linalg::assign;
use nalgebra::DVector;

/// The relative part of the barrier function that rounding can hide.
const ROUNDING: f64 = 1e-13;

/// The largest increase of the barrier function that a decrease of the violation is worth, in multiples of the
/// multipliers: those of a step are an estimate. Without a bound a motion on a free horizon may shrink to no time, as
/// each step decreases a small violation of its goal.
const MAX_PRICE: f64 = 3.0;

/// Takes a fraction of a step that decreases the barrier function sufficiently (NW 3.4) below the largest of its last
/// values, or that the filter accepts. Returns the predicted decrease of the whole step, or `None` if there is no such
/// fraction.
///
/// The change of a row along the step is that to the end of the tried fraction, relative to the fraction, so that
/// slacks follow the rows to second order. Multipliers take the Newton step of the linearised rows.
pub(super) fn line_search<P: Nlp>(
    problem: &mut P,
    state: &mut State,
    step: &Step,
    options: &Options,
) -> Result<Option<f64>> {
    let mut trial = std::mem::take(&mut state.trial);
    trial.iterate.clone_from(&state.iterate);
    let allowed = problem.max_step_fraction(&state.x, &step.x);
    trial.set_tangent(problem, state, step, (options.tangent / state.progress.step).min(allowed))?;
    let start = Start::new(problem, state, (step, &trial.tangent), options);
    let whole = options.longest_step / state.progress.step;
    let allowed = allowed.min(state.to_boundary(&trial.tangent, options));
    let first = allowed.min(whole);
    // Without a longest step only bounds limit a step, which say nothing about the quadratic model.
    let model = if whole.is_finite() { 1.0 } else { allowed };
    let (mut alpha, mut predicted) = (first, f64::NAN);
    for _ in 0..options.max_backtracks {
        let f = trial.evaluate(problem, state, &step.x, alpha)?;
        if f.is_finite() {
            let mut end = start.end(problem, state, step, (alpha, f), trial, options);
            if predicted.is_nan() {
                predicted = if state.iterate.has_filter { start.gap } else { -end.slope };
            }
            let mut accepted = start.accepts(state, &end, options);
            if (P::HAS_ROW_GRADIENTS || state.iterate.has_filter) && accepted.is_none() && alpha == first {
                // The Maratos effect (NW 15.6, WB 2.4).
                if let Some(f) = end.trial.correct(problem, state, alpha, options)? {
                    end = start.end(problem, state, step, (alpha, f), end.trial, options);
                    accepted = start.accepts(state, &end, options);
                }
            }
            if let Some(accepted) = accepted {
                if accepted == Accepted::Progress {
                    state.filter.add([start.violation, start.merit]);
                }
                if alpha == first {
                    let mut longer = std::mem::take(&mut state.longer);
                    end.extend(problem, (state, step), &mut longer, options)?;
                    state.longer = longer;
                }
                state.progress.alpha = end.alpha;
                state.taken = end.alpha / model;
                state.move_to(problem, end.f, end.trial, options);
                return Ok(Some(predicted));
            }
            trial = end.trial;
        }
        alpha *= options.backtracking;
    }
    state.trial = trial;
    (state.progress.alpha, state.taken) = (0.0, 0.0);
    Ok(None)
}

/// The start of a line search.
struct Start {
    /// The barrier function, and the largest of its last values.
    merit: f64,
    highest: f64,
    /// The violation that a filter bounds.
    violation: f64,
    /// The slope of the barrier function without the terms of the rows.
    slope: f64,
    /// The larger ones of the multipliers before and after the step, with their weights: those of the equalities, then
    /// of hard rows.
    prices: Vec<f64>,
    /// The error of the equations at the start, in the unit of the objective.
    gap: f64,
}

impl Start {
    fn new<P: Nlp>(problem: &P, state: &mut State, (step, tangent): (&Step, &[f64]), options: &Options) -> Self {
        let merit = state.merit(problem);
        let [equalities, gap] = state.terms_of_equalities(problem);
        let measure = |row: &Row| problem.row_measure(&state.x, row.at) * row.weight;
        let held = state.iterate.equalities.iter().zip(&step.multipliers);
        let held = held.map(|(of, change)| {
            let before = measure(&of.row) * of.multiplier;
            before.abs().max((before + change).abs())
        });
        let hard = state.iterate.working.iter().zip(tangent).filter(|(of, _)| of.row.is_hard);
        let hard = hard.map(|(of, change)| {
            let step = state.iterate.step(of, state.h[of.row.at], *change);
            measure(&of.row) * (of.multiplier + step.multiplier.max(0.0))
        });
        let prices = held.chain(hard).collect();
        Self {
            merit,
            prices,
            highest: state.remember(merit, options.memory),
            violation: state.iterate.violation(&state.h),
            slope: step.slope + equalities,
            gap: state.progress.stationarity.powi(2) * state.scale() + gap,
        }
    }

    /// The end of a fraction of a step with this objective.
    fn end<P: Nlp>(
        &self,
        problem: &P,
        state: &State,
        step: &Step,
        (alpha, f): (f64, f64),
        mut trial: Trial,
        options: &Options,
    ) -> End {
        let slope = self.slope + trial.take(problem, state, step, alpha, options);
        let merit = trial.merit(problem, f);
        End { alpha, f, trial, merit, slope }
    }

    /// Accepts an end that decreases the barrier function sufficiently, or that a filter accepts.
    fn accepts(&self, state: &mut State, end: &End, options: &Options) -> Option<Accepted> {
        let rounding = ROUNDING * self.merit.abs().max(end.f.abs());
        let expected = end.alpha * end.slope;
        if state.iterate.has_filter {
            let [before, after] = [(&state.iterate, &state.h), (&end.trial.iterate, &end.trial.h)];
            let gained = before.0.violations(before.1).zip(after.0.violations(after.1)).zip(&self.prices);
            let gained: f64 = gained.map(|((before, after), price)| price * (before - after)).sum();
            if end.merit > self.highest + MAX_PRICE * gained.max(0.0) + rounding {
                return None;
            }
            let after = [end.trial.iterate.violation(&end.trial.h), end.merit];
            let rule = (options.sufficient_decrease, rounding);
            return state.filter.test([self.violation, self.highest], after, (end.alpha, end.slope), rule);
        }
        let gained = self.highest - end.merit;
        let hidden = gained.abs() <= rounding && expected.abs() <= rounding;
        (hidden || gained >= -options.sufficient_decrease * expected).then_some(Accepted::Descent)
    }
}

/// The end of a fraction of a step.
struct End {
    alpha: f64,
    f: f64,
    trial: Trial,
    merit: f64,
    /// The slope of the barrier function along the whole step.
    slope: f64,
}

impl End {
    /// Doubles the fraction of a whole step along negative curvature while that decreases the barrier function, up to
    /// the longest step if there is one: the length of such a step is arbitrary, as the multiple of the norm determines
    /// it.
    fn extend<P: Nlp>(
        &mut self,
        problem: &mut P,
        (state, step): (&State, &Step),
        longer: &mut Trial,
        options: &Options,
    ) -> Result<()> {
        let most = options.longest_step / state.progress.step;
        if state.progress.curvature() >= 0.0 || most.is_infinite() {
            return Ok(());
        }
        loop {
            let alpha = 2.0 * self.alpha;
            assign(&mut longer.x, &step.x);
            longer.x *= alpha;
            if alpha > most || problem.max_step_fraction(&state.x, &longer.x) < 1.0 {
                return Ok(());
            }
            longer.iterate.clone_from(&state.iterate);
            longer.tangent.clone_from(&self.trial.tangent);
            let f = longer.evaluate(problem, state, &step.x, alpha)?;
            let merit = if f.is_finite() {
                longer.take(problem, state, step, alpha, options);
                longer.merit(problem, f)
            } else {
                f64::INFINITY
            };
            if merit.is_nan() || merit >= self.merit {
                // The derivatives are those at the last evaluated point.
                self.f = problem.value(&self.trial.x, &mut self.trial.h)?;
                return Ok(());
            }
            std::mem::swap(&mut self.trial, longer);
            (self.alpha, self.f, self.merit) = (alpha, f, merit);
        }
    }
}

/// The unknowns and the rows at the end of a fraction of a step.
#[derive(Default)]
pub(super) struct Trial {
    x: DVector<f64>,
    pub h: Vec<f64>,
    /// The changes of the linearised rows of the working set along the whole step.
    tangent: Vec<f64>,
    pub iterate: Iterate,
}

impl Trial {
    /// Evaluates the objective and the rows at the end of a fraction of a step; returns the objective.
    pub(super) fn evaluate<P: Nlp>(
        &mut self,
        problem: &mut P,
        state: &State,
        step: &DVector<f64>,
        alpha: f64,
    ) -> Result<f64> {
        assign(&mut self.x, &state.x);
        self.x.axpy(alpha, step, 1.0);
        problem.value(&self.x, &mut self.h)
    }

    /// Moves the end of a fraction of a step by a second-order correction for the change of the rows beyond the linear
    /// one; returns the objective there, or `None` if the problem or the slacks of hard rows do not allow that end.
    fn correct<P: Nlp>(
        &mut self,
        problem: &mut P,
        state: &State,
        alpha: f64,
        options: &Options,
    ) -> Result<Option<f64>> {
        let from = &state.iterate;
        let rows = from.working.iter().zip(&self.tangent);
        let weights: Vec<_> = rows
            .map(|(of, tangent)| {
                let at = of.row.at;
                let beyond = self.h[at] - state.h[at] - alpha * tangent;
                let weight = problem.row_measure(&state.x, at) * of.row.weight;
                (at, weight * from.curvature(of) * beyond)
            })
            .collect();
        let mut correction = DVector::zeros(self.x.len());
        problem.add_row_gradients(&weights, &mut correction);
        let values = state.kkt.equalities.values.iter().zip(&from.equalities);
        // The linearised equalities vanish at the end of the whole step.
        let beyond = values.map(|(value, of)| self.h[of.row.at] - (1.0 - alpha) * value);
        let mut beyond = DVector::from_iterator(state.kkt.equalities.values.len(), beyond);
        state.kkt.solve(&mut correction, &mut beyond);
        self.x -= correction;
        let is_allowed =
            self.x.iter().all(|x| x.is_finite()) && problem.max_step_fraction(&state.x, &(&self.x - &state.x)) >= 1.0;
        if !is_allowed {
            return Ok(None);
        }
        let f = problem.value(&self.x, &mut self.h)?;
        Ok((f.is_finite() && self.keeps_slacks(state, alpha, options)).then_some(f))
    }

    /// Returns true if the slacks of hard rows can follow the rows.
    fn keeps_slacks(&self, state: &State, alpha: f64, options: &Options) -> bool {
        let mut hard = state.iterate.working.iter().filter(|of| of.row.is_hard);
        hard.all(|of| {
            let rest = (1.0 - alpha) * of.elastic;
            rest - self.h[of.row.at] >= (1.0 - options.fraction_to_boundary) * of.slack
        })
    }

    /// Sets the changes of the linearised rows along a step: those over a short part of it, relative to that.
    fn set_tangent<P: Nlp>(&mut self, problem: &mut P, state: &State, step: &Step, part: f64) -> Result<()> {
        let working = &state.iterate.working;
        if working.is_empty() {
            return Ok(());
        }
        assign(&mut self.x, &state.x);
        self.x.axpy(part, &step.x, 1.0);
        problem.value(&self.x, &mut self.h)?;
        self.tangent.clear();
        let rows = working.iter().map(|of| of.row.at);
        self.tangent.extend(rows.map(|at| (self.h[at] - state.h[at]) / part));
        Ok(())
    }

    /// The barrier function for an objective.
    pub(super) fn merit<P: Nlp>(&self, problem: &P, f: f64) -> f64 {
        let measure = |row| problem.row_measure(&self.x, row);
        f + self.iterate.barrier_terms(measure)
    }

    /// Takes this fraction of the steps of the rows, whose values at its end are known. Returns the difference between
    /// the slope of the barrier function along the step and that of the condensed equations.
    fn take<P: Nlp>(&mut self, problem: &P, state: &State, of: &Step, alpha: f64, options: &Options) -> f64 {
        let (from, mut slope) = (&state.iterate, MeasuredSum::default());
        let measure = |row| problem.row_measure(&state.x, row);
        let rows = from.working.iter().zip(&mut self.iterate.working);
        for ((before, after), tangent) in rows.zip(&self.tangent) {
            let at = before.row.at;
            let change = (self.h[at] - state.h[at]) / alpha;
            // With the change of the row itself, a row that curves beyond its bound would get the multiplier of a
            // violation, and with its second derivative the Hessian would make the next steps short.
            let step = RowStep {
                multiplier: from.step(before, state.h[at], *tangent).multiplier,
                ..from.step(before, state.h[at], change)
            };
            let [bend, condensed] = from.bend(before, &step, change);
            let mut difference = condensed - bend;
            if before.row.is_hard {
                difference += (before.multiplier + step.multiplier) * before.elastic;
            }
            slope.add(measure(at), before.row.weight * difference);
            *after = before.take(&step, alpha, options.fraction_to_boundary);
            after.meet(self.h[at]);
        }
        let held = from.equalities.iter().zip(&mut self.iterate.equalities);
        for ((before, after), change) in held.zip(&of.multipliers) {
            let weight = measure(before.row.at) * before.row.weight;
            after.multiplier = before.multiplier + alpha.min(1.0) * change / weight;
        }
        slope.total()
    }
}

impl State {
    /// The difference between the slope of the objective along a step and that of the Lagrangian of the equalities, and
    /// the sum of the sizes of its terms with those of hard rows.
    fn terms_of_equalities<P: Nlp>(&self, problem: &P) -> [f64; 2] {
        let measure = |row: &Row| problem.row_measure(&self.x, row.at) * row.weight;
        let [mut sum, mut sizes] = [0.0; 2];
        for (held, value) in self.iterate.equalities.iter().zip(&self.kkt.equalities.values) {
            let term = measure(&held.row) * held.term(*value).cost;
            sum += term;
            sizes += term.abs();
        }
        for of in self.iterate.working.iter().filter(|of| of.row.is_hard) {
            sizes += measure(&of.row) * of.multiplier * of.elastic;
        }
        [sum, sizes]
    }

    /// The fraction of a step up to which the slacks of hard rows keep a part of their value (WB 15).
    fn to_boundary(&self, tangent: &[f64], options: &Options) -> f64 {
        let hard = self.iterate.working.iter().zip(tangent).filter(|(of, _)| of.row.is_hard);
        let fractions = hard.map(|(of, change)| {
            let step = self.iterate.step(of, self.h[of.row.at], *change).slack;
            if step < 0.0 { -options.fraction_to_boundary * of.slack / step } else { 1.0 }
        });
        fractions.fold(1.0, f64::min)
    }

    /// Forgets the barrier function at the last iterates, for another barrier or working set.
    pub(super) fn forget_merits(&mut self) {
        self.merits.clear();
        self.filter.clear();
        self.decreased = f64::INFINITY;
    }

    /// Notes the barrier function at the current iterate; returns the largest of the last values.
    fn remember(&mut self, merit: f64, memory: usize) -> f64 {
        let most = self.decreased - self.complementarity() * self.scale();
        if merit < most {
            (self.decreased, self.stalled) = (merit, 0)
        } else {
            self.stalled += 1
        }
        self.merits.push_back(merit);
        while self.merits.len() > memory {
            self.merits.pop_front();
        }
        self.merits.iter().copied().fold(merit, f64::max)
    }

    /// Moves to a trial, and adapts the working set.
    pub(super) fn move_to<P: Nlp>(&mut self, problem: &mut P, f: f64, mut trial: Trial, options: &Options) {
        std::mem::swap(&mut self.x, &mut trial.x);
        std::mem::swap(&mut self.h, &mut trial.h);
        std::mem::swap(&mut self.iterate, &mut trial.iterate);
        (self.f, self.trial) = (f, trial);
        let largest = options.largest_penalty * self.scale() / self.measure;
        if options.steers && self.iterate.steer(&self.trial.h, &self.h, options, largest) {
            self.forget_merits();
        }
        self.iterate.safeguard_all(options.multiplier_range);
        self.list_rows(problem);
    }
}
