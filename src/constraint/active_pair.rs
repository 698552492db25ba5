//! The pairs of bodies that are near each other at a state.

use crate::scalar::Scalar;
use nalgebra::Vector3;

/// A row that is a distance of two bodies near each other, with the normal of the plane that separates them at a state:
/// a search for that at a state nearby begins there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActivePair<S: Scalar = f64> {
    /// The row.
    pub row: usize,
    /// The unit normal, from the second body to the first one.
    pub normal: Vector3<S>,
}

/// The pairs that were near each other at a state nearby, in ascending order of their rows.
#[derive(Clone, Copy, Debug)]
pub struct ActivePairs<'a, S: Scalar = f64> {
    all: &'a [ActivePair<S>],
    /// The number that is subtracted from each row.
    first: usize,
    /// True if only rows near their bounds are needed.
    is_rough: bool,
}

impl<'a, S: Scalar> ActivePairs<'a, S> {
    /// The pairs of a constraint, in ascending order of their rows.
    #[must_use]
    pub fn new(all: &'a [ActivePair<S>]) -> Self {
        Self { all, first: 0, is_rough: false }
    }

    /// The same where only rows near their bounds are needed: others count as far as their
    /// [cutoff](super::RowSet::cutoff).
    #[must_use]
    pub fn near_bounds(self) -> Self {
        Self { is_rough: true, ..self }
    }

    /// True if only rows near their bounds are needed.
    #[must_use]
    pub fn is_near_bounds(&self) -> bool {
        self.is_rough
    }

    /// Those of the first `count` rows, and those of the others, whose rows are counted from there.
    #[must_use]
    pub fn split_at(self, count: usize) -> (Self, Self) {
        let end = self.first + count;
        let (own, rest) = self.all.split_at(self.all.partition_point(|pair| pair.row < end));
        (Self { all: own, ..self }, Self { all: rest, first: end, ..self })
    }

    /// The normal of the pair of a row, if it was near.
    #[must_use]
    pub fn normal(&self, row: usize) -> Option<Vector3<S>> {
        let at = self.all.binary_search_by_key(&(row + self.first), |pair| pair.row).ok()?;
        Some(self.all[at].normal)
    }
}
