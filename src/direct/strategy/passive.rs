//! Residuals between the collocated points: the torque of passive joints, and equalities of the state.

use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::direct::Iteration;
use crate::direct::minimise::{Candidate, Context, Stage, minimise};
use crate::error::Result;

/// Minimises in the last basis, then with more segments and then with higher degrees, as long as a passive joint has
/// more residual torque, or an equality a larger deviation, than is accepted, and the motion costs less than `least` by
/// more than the tolerance for equal minima.
pub(crate) fn minimise_to_the_end<K: Constraint, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    candidate: Candidate,
    stage: Stage,
    least: f64,
    observe: &mut dyn FnMut(Iteration),
) -> Result<Candidate> {
    let search = &context.settings.search;
    let mut found = minimise(context, candidate, stage, observe)?;
    while (found.passive_share > search.passive_share || found.deviation > search.deviation)
        && found.violation <= stage.feasible
        && (1.0 + search.same_minimum) * found.objective < least
        && context.watch.stopped().is_none()
    {
        let Some(basis) = found.path.basis.finer(search.largest_passive_size) else {
            break;
        };
        found.path = found.path.in_basis(basis);
        found = minimise(context, found, stage, observe)?;
    }
    Ok(found)
}
