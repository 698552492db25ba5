//! The active pairs of rows that are maxima of many functions.

use super::Constraint;

/// The share of its cutoff from which on a row is computed exactly along a motion.
const EXACT: f64 = 0.1;

/// A pair of a row: the numbers of the two parts of the robot or its surroundings whose distance it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActivePair {
    /// The row.
    pub row: usize,
    /// The numbers of the parts, as the constraint counts them.
    pub of: [usize; 2],
}

/// The active pairs of the rows of a constraint, in ascending order of the rows: those that are the largest at a
/// state. A constraint with them computes its rows from these alone, without a search for others, or from these and the
/// others [above](Self::and_above) a value.
#[derive(Clone, Copy, Debug)]
pub struct ActivePairs<'a> {
    all: &'a [ActivePair],
    /// The number that is subtracted from each row.
    first: usize,
    /// The value of a row from which on others are searched.
    from: f64,
}

impl<'a> ActivePairs<'a> {
    /// The active pairs of a constraint, in ascending order of the rows.
    #[must_use]
    pub fn new(all: &'a [ActivePair]) -> Self {
        Self { all, first: 0, from: f64::INFINITY }
    }

    /// These active pairs, and a search for others where they raise a row to `from` or above.
    #[must_use]
    pub fn and_above(self, from: f64) -> Self {
        Self { from, ..self }
    }

    /// The value of a row from which on other active pairs are searched; infinite without a search.
    #[must_use]
    pub fn searched_from(&self) -> f64 {
        self.from
    }

    /// The active pairs of the first `count` rows, and those of the others, whose rows are counted from there.
    #[must_use]
    pub fn split_at(self, count: usize) -> (Self, Self) {
        let end = self.first + count;
        let (own, rest) = self.all.split_at(self.all.partition_point(|pair| pair.row < end));
        let rest = Self { all: rest, first: end, ..self };
        (Self { all: own, ..self }, rest)
    }

    /// The active pairs in ascending order of the rows.
    pub fn iter(self) -> impl Iterator<Item = ActivePair> + use<'a> {
        self.all.iter().map(move |pair| ActivePair { row: pair.row - self.first, ..*pair })
    }
}

/// The value of rows from which on other active pairs than those active nearby are searched along a motion: a row that
/// is further from its bound is no larger than this.
pub(crate) fn searched_from<K: Constraint>(state: &K) -> f64 {
    let cutoffs = (0..state.dim()).filter_map(|row| state.row_set(row).cutoff);
    -EXACT * cutoffs.fold(f64::INFINITY, f64::min)
}
