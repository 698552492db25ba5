//! Theorem B4, (B37) to (B80).

mod by_x;
mod by_xdot;
mod composition;

use super::Identity;

/// The identities of the theorem, in the order of its labels.
pub(super) fn identities() -> Vec<Identity> {
    let mut all = composition::identities();
    all.extend(by_x::identities());
    all.extend(by_xdot::identities());
    all
}

/// An identity whose rows are those of the differentiated quantity.
fn law(
    label: &'static str,
    statement: &'static str,
    claims: fn(&super::RandomInstance) -> crate::error::Result<Vec<super::Equality>>,
) -> Identity {
    Identity {
        label,
        statement,
        convention: "rows are those of what is differentiated; the derivative index of a tensor comes last",
        claims,
    }
}
