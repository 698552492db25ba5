//! The flow of Lagrangians beyond the paper's: weights of the actuation, dual trajectories, running costs, any metric
//! and drift.

mod control_form;
pub(super) mod made_up;
mod multipliers;
mod weak_form;

use super::Identity;

/// The identities of this folder.
pub(super) fn identities() -> Vec<Identity> {
    let mut all = control_form::identities();
    all.extend(multipliers::identities());
    all.extend(weak_form::identities());
    all
}
