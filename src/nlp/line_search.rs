//! Backtracking on the barrier function.

use super::kkt::Step;
use super::{Iterate, Nlp, Options, State};
use crate::error::Result;
use nalgebra::DVector;

/// The relative part of the barrier function that rounding can hide.
const ROUNDING: f64 = 1e-13;

/// Takes a fraction of a step that decreases the barrier function sufficiently (NW 3.4) below the largest of its last
/// values. Returns the predicted decrease of the whole step, or `None` if no fraction does.
///
/// The change of a row along the step is that to the end of the tried fraction, relative to the fraction, so that
/// slacks follow the rows to second order.
pub(super) fn line_search<P: Nlp>(
    problem: &mut P,
    state: &mut State,
    step: &Step,
    options: &Options,
) -> Result<Option<f64>> {
    let before = state.merit(problem);
    let highest = state.remember(before, options.memory);
    let mut trial = Trial {
        h: Vec::with_capacity(state.h.len()),
        iterate: state.iterate.clone(),
    };
    let whole = options.longest_step / state.progress.step;
    let mut alpha = problem.longest(&state.x, &step.x).min(whole);
    let mut predicted = f64::NAN;
    for _ in 0..options.cuts {
        let x = &state.x + &step.x * alpha;
        let f = problem.value(&x, &mut trial.h)?;
        if f.is_finite() {
            let slope = step.slope + problem.measure(&state.x) * trial.take(state, alpha, options);
            if predicted.is_nan() {
                predicted = -slope;
            }
            let after = f + problem.measure(&x) * trial.iterate.barrier_terms(&trial.h);
            let (gained, rounding) = (highest - after, ROUNDING * before.abs().max(f.abs()));
            let hidden = gained.abs() <= rounding && (alpha * slope).abs() <= rounding;
            if hidden || gained >= -options.sufficient_decrease * alpha * slope {
                state.progress.alpha = alpha;
                state.move_to(problem, x, f, trial, options);
                return Ok(Some(predicted));
            }
        }
        alpha *= options.backtracking;
    }
    state.progress.alpha = 0.0;
    Ok(None)
}

/// The rows at the end of a fraction of a step.
struct Trial {
    h: Vec<f64>,
    iterate: Iterate,
}

impl Trial {
    /// Takes this fraction of the steps of the rows, whose values at its end are known. Returns the difference between
    /// the slope of the barrier function along the step and that of the condensed equations, without the measure.
    fn take(&mut self, state: &State, alpha: f64, options: &Options) -> f64 {
        let (from, mut slope) = (&state.iterate, 0.0);
        for (before, after) in from.working.iter().zip(&mut self.iterate.working) {
            let at = before.row.at;
            let change = (self.h[at] - state.h[at]) / alpha;
            let step = from.step(before, state.h[at], change);
            let [bend, condensed] = from.bend(before, &step, change);
            slope += before.row.weight * (condensed - bend);
            *after = before.take(&step, alpha, options.fraction_to_boundary);
            after.meet(self.h[at]);
        }
        slope
    }
}

impl State {
    /// Notes the barrier function at the current iterate; returns the largest of the last values.
    fn remember(&mut self, merit: f64, memory: usize) -> f64 {
        self.merits.push_back(merit);
        while self.merits.len() > memory {
            self.merits.pop_front();
        }
        self.merits.iter().copied().fold(merit, f64::max)
    }

    /// Moves to a trial, and adapts the working set.
    fn move_to<P: Nlp>(
        &mut self,
        problem: &mut P,
        x: DVector<f64>,
        f: f64,
        trial: Trial,
        options: &Options,
    ) {
        (self.x, self.f, self.h, self.iterate) = (x, f, trial.h, trial.iterate);
        self.iterate.safeguard_all(options.multiplier_range);
        let working = problem.working_set(&self.h);
        self.iterate.set_working(&working, &self.h);
    }
}

/// Moves along a direction of negative curvature, either way, to a smaller barrier function; returns false if there is
/// none.
pub(super) fn leave_saddle<P: Nlp>(
    problem: &mut P,
    state: &mut State,
    direction: &DVector<f64>,
    options: &Options,
) -> Result<bool> {
    let before = state.merit(problem);
    let mut length = options.saddle_step;
    for _ in 0..options.cuts {
        for sign in [1.0, -1.0] {
            let x = &state.x + direction * (sign * length);
            let mut trial = Trial {
                h: Vec::with_capacity(state.h.len()),
                iterate: state.iterate.clone(),
            };
            let f = problem.value(&x, &mut trial.h)?;
            for row in &mut trial.iterate.working {
                row.meet(trial.h[row.row.at]);
            }
            if f + problem.measure(&x) * trial.iterate.barrier_terms(&trial.h) < before {
                state.move_to(problem, x, f, trial, options);
                return Ok(true);
            }
        }
        length *= options.backtracking;
    }
    Ok(false)
}
