//! The pairs of bodies that are near each other at a state.

use crate::geometry::PlaneHint;
use crate::scalar::Scalar;

/// A row that is a distance of two bodies near each other, with the plane that separates them at a state: a search
/// for that at a state nearby begins there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActivePair<S: Scalar = f64> {
    /// The row.
    pub row: usize,
    /// The plane.
    pub plane: PlaneHint<S>,
}

/// The pairs that were near each other at a state nearby, in ascending order of their rows.
#[derive(Clone, Copy, Debug)]
pub struct ActivePairs<'a, S: Scalar = f64> {
    all: &'a [ActivePair<S>],
    /// The number that is subtracted from each row.
    first: usize,
    /// True if planes between bodies that overlap follow these.
    is_followed: bool,
}

impl<'a, S: Scalar> ActivePairs<'a, S> {
    /// The pairs of a constraint, in ascending order of their rows.
    #[must_use]
    pub fn new(all: &'a [ActivePair<S>]) -> Self {
        Self { all, first: 0, is_followed: true }
    }

    /// The same where the planes between bodies that overlap do not depend on these, so that a value is the same along
    /// any way to its state.
    #[must_use]
    pub fn independent(self) -> Self {
        Self { is_followed: false, ..self }
    }

    /// Those of the first `count` rows, and those of the others, whose rows are counted from there.
    #[must_use]
    pub fn split_at(self, count: usize) -> (Self, Self) {
        let end = self.first + count;
        let (own, rest) = self.all.split_at(self.all.partition_point(|pair| pair.row < end));
        (Self { all: own, ..self }, Self { all: rest, first: end, ..self })
    }

    /// The plane of the pair of a row, if it was near, and whether it is followed.
    #[must_use]
    pub fn plane(&self, row: usize) -> Option<(&'a PlaneHint<S>, bool)> {
        let at = self.all.binary_search_by_key(&(row + self.first), |pair| pair.row).ok()?;
        Some((&self.all[at].plane, self.is_followed))
    }
}
