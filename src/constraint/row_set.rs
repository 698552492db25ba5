//! The sets of values that rows may have.

use super::PairDistance;
use crate::scalar::Scalar;

/// The set of values that a row of a [constraint](super::Constraint) may have, and what is known of the row at every
/// state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowSet<C: Scalar = f64> {
    /// Whether the row is an equality $g_j(x) = 0$, violated by $|g_j|$, and not an inequality $g_j(x) \le 0$.
    pub is_equality: bool,
    /// The slope of the row at its boundary with respect to the bounded quantity, in rad, rad/s or m: the row divided
    /// by it is the distance from the boundary in these units.
    pub scale: C,
    /// Whether the row is a distance that is far from its bound most of the time.
    pub is_clearance: bool,
    /// The distance from its bound, in units of the scaled row, from which on the row is constant; `None` if it depends
    /// on the state everywhere.
    pub cutoff: Option<C>,
    /// The distance of which the row is a function; `None` if it is not known to be one of a single distance.
    pub distance: Option<PairDistance<C>>,
}

impl<C: Scalar> RowSet<C> {
    /// An inequality of scale one of which nothing else is known.
    #[must_use]
    pub fn at_most_zero() -> Self {
        Self { is_equality: false, scale: C::one(), is_clearance: false, cutoff: None, distance: None }
    }

    /// An equality of scale one.
    #[must_use]
    pub fn zero() -> Self {
        Self { is_equality: true, ..Self::at_most_zero() }
    }

    /// The same with another scale.
    #[must_use]
    pub fn scaled(self, scale: C) -> Self {
        Self { scale, ..self }
    }

    /// A clearance that is a function of a distance, of the slope $2 R$ if it is one of squares.
    pub(super) fn clearance(distance: Option<PairDistance<C>>) -> Self {
        let squared = distance.and_then(|distance| distance.squared);
        let scale = squared.map_or(C::one(), |reach| reach + reach);
        Self { is_clearance: true, distance, ..Self::at_most_zero() }.scaled(scale)
    }
}
