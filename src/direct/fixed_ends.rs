//! The states between which a motion is searched for, if they are given.

use super::DirectSettings;
use crate::constraint::{Constraint, Evaluator, RowLabel};
use crate::error::{Error, Result};
use crate::motion::Problem;

/// Refuses a given start or end that violates a row of the state by more than the search accepts: no motion between
/// them keeps it.
pub(super) fn check_ends<K: Constraint>(problem: &Problem<'_>, settings: &DirectSettings, state: &K) -> Result<()> {
    if settings.period.is_some() {
        return Ok(());
    }
    let model = problem.model();
    let is_given = settings.goal.is_none() && !settings.free_final_velocity;
    let end = is_given.then_some(("goal", problem.goal()));
    for (element, x) in [("start", problem.start())].into_iter().chain(end) {
        let worst = Evaluator::new(model).at(x)?.worst_row(state)?;
        if let Some((by, RowLabel { name, unit, .. })) = worst
            && by > DirectSettings::FEASIBLE
        {
            let space = if unit.is_empty() { "" } else { " " };
            let condition = format!("it violates {name} by {by:.3e}{space}{unit}, so that no motion keeps it");
            return Err(Error::input("problem", element, condition));
        }
    }
    Ok(())
}
