//! The end of a search at a point that is stationary and no minimum.

use super::line_search::Trial;
use super::{Nlp, Options, State};
use crate::error::Result;
use nalgebra::DVector;

/// Moves along a direction of negative curvature, either way, to a smaller barrier function, with the terms of the
/// Lagrangian for equalities; returns false if there is none.
pub(super) fn leave_saddle<P: Nlp>(
    problem: &mut P,
    state: &mut State,
    direction: &DVector<f64>,
    options: &Options,
) -> Result<bool> {
    let before = state.merit(problem) + state.iterate.lagrangian_terms(&state.h, state.measure);
    let mut length = options.saddle_step;
    for _ in 0..options.max_backtracks {
        for sign in [1.0, -1.0] {
            let mut trial = Trial::default();
            trial.iterate.clone_from(&state.iterate);
            let f = trial.evaluate(problem, state, direction, sign * length)?;
            for row in &mut trial.iterate.working {
                row.meet(trial.h[row.row.at]);
            }
            let terms = state.iterate.lagrangian_terms(&trial.h, state.measure);
            if trial.merit(problem, f) + terms < before {
                state.forget_merits();
                state.move_to(problem, f, trial, options);
                return Ok(true);
            }
        }
        length *= options.backtracking;
    }
    Ok(false)
}
