//! Backtracking on the barrier function.

use super::iterate::{RowStep, meet};
use super::kkt::Step;
use super::{Nlp, Options, State};
use crate::error::Result;
use nalgebra::DVector;

/// The relative part of the barrier function that rounding can hide.
const ROUNDING: f64 = 1e-13;

/// Takes a fraction of a step that decreases the barrier function sufficiently (NW 3.4). Returns the predicted decrease
/// of the whole step, or `None` if no fraction does.
///
/// The change of a row along the step is that to the end of the tried fraction, relative to the fraction, so that slacks
/// follow the rows to second order.
pub(super) fn line_search<P: Nlp>(
    problem: &mut P,
    state: &mut State,
    step: &Step,
    options: &Options,
) -> Result<Option<f64>> {
    let rows = state.iterate.working.len();
    let before = state.merit(problem);
    state.merits.push_back(before);
    while state.merits.len() > options.memory {
        state.merits.pop_front();
    }
    let highest = state.merits.iter().copied().fold(before, f64::max);
    let tau = options.fraction_to_boundary;
    let split = std::env::var("AGHF_SPLIT").is_ok();
    let mut h = vec![0.0; state.h.len()];
    let mut steps = vec![
        RowStep {
            slack: 0.0,
            elastic: 0.0,
            multiplier: 0.0
        };
        rows
    ];
    let mut trial = state.iterate.clone();
    let (mut fraction, mut predicted) = (problem.longest(&state.x, &step.x).min(options.longest_step / state.progress.step), f64::NAN);
    for cut in 0..options.cuts {
        let x = &state.x + &step.x * fraction;
        let f = problem.value(&x, &mut h)?;
        if !f.is_finite() {
            fraction *= options.backtracking;
            continue;
        }
        let measure = problem.measure(&state.x);
        let mut slope = step.slope;
        for (row, own) in state.iterate.working.iter().zip(&mut steps) {
            let change = (h[row.at] - state.h[row.at]) / fraction;
            *own = state.iterate.step(row, state.h[row.at], change);
            let [bend, condensed] = state.iterate.bend(row, own, change);
            slope += measure * row.weight * (condensed - bend);
            trial.take(&state.iterate, row, own, fraction, tau);
            let (s, t) = (&mut trial.slack[row.at], &mut trial.elastic[row.at]);
            [*s, *t] = if split { state.iterate.split(row, h[row.at]) } else { meet(h[row.at], *s, *t) };
        }
        if cut == 0 {
            predicted = -slope;
        }
        let (alpha, at) = (fraction, x);
        let after = f + problem.measure(&at) * trial.barrier_terms(&h);
        let (gained, rounding) = (highest - after, ROUNDING * before.abs().max(f.abs()));
        let hidden = gained.abs() <= rounding && (alpha * slope).abs() <= rounding;
        if hidden || gained >= -options.sufficient_decrease * alpha * slope {
            for row in &state.iterate.working {
                trial.safeguard(row, options.multiplier_range);
            }
            state.progress.alpha = [alpha, 1.0];
            state.progress.alpha = [alpha, 1.0];
            state.iterate = trial;
            (state.x, state.f) = (at, f);
            std::mem::swap(&mut state.h, &mut h);
            let working = problem.working_set(&state.h);
            state.iterate.set_working(working, &state.h);
            return Ok(Some(predicted));
        }
        fraction = alpha * options.backtracking;
    }
    Ok(None)
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
    let (mut h, mut trial) = (vec![0.0; state.h.len()], state.iterate.clone());
    let mut length = options.saddle_step;
    for _ in 0..options.cuts {
        for sign in [1.0, -1.0] {
            let x = &state.x + direction * (sign * length);
            let f = problem.value(&x, &mut h)?;
            trial.slack.copy_from_slice(&state.iterate.slack);
            trial.elastic.copy_from_slice(&state.iterate.elastic);
            for row in &state.iterate.working {
                let (s, t) = (&mut trial.slack[row.at], &mut trial.elastic[row.at]);
                [*s, *t] = meet(h[row.at], *s, *t);
            }
            if f + problem.measure(&x) * trial.barrier_terms(&h) < before {
                (state.x, state.f, state.iterate) = (x, f, trial);
                std::mem::swap(&mut state.h, &mut h);
                let working = problem.working_set(&state.h);
                state.iterate.set_working(working, &state.h);
                return Ok(true);
            }
        }
        length *= options.backtracking;
    }
    Ok(false)
}
