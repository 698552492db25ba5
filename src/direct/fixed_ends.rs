//! The states between which a motion is searched for, if they are given.

use super::DirectSettings;
use crate::constraint::{Constraint, Evaluator};
use crate::error::{Error, Result};
use crate::motion::Problem;

/// Refuses a given start or end that violates a row of the state by more than the search accepts: no motion between
/// them keeps it.
pub(super) fn check_ends<K: Constraint>(
    problem: &Problem<'_>,
    settings: &DirectSettings,
    state: &K,
) -> Result<()> {
    if settings.period.is_some() {
        return Ok(());
    }
    let model = problem.model();
    let is_given = settings.goal.is_none() && !settings.free_final_velocity;
    let end = is_given.then_some(("goal", problem.goal()));
    let (mut values, mut scales) = (vec![0.0; state.dim()], vec![1.0; state.dim()]);
    state.row_scales(&mut scales);
    for (element, x) in [("start", problem.start())].into_iter().chain(end) {
        Evaluator::new(model).at(x)?.value(state, &mut values)?;
        for (row, (value, scale)) in values.iter().zip(&scales).enumerate() {
            let scaled = match state.is_equality(row) {
                true => value.abs() / scale,
                false => value / scale,
            };
            let label = state.label(row, model);
            let by = label.kind.excess(scaled, *scale);
            if by > DirectSettings::FEASIBLE {
                let space = if label.unit.is_empty() { "" } else { " " };
                let condition = format!(
                    "it violates {} by {by:.3e}{space}{}, so that no motion keeps it",
                    label.name, label.unit
                );
                return Err(Error::input("problem", element, condition));
            }
        }
    }
    Ok(())
}
