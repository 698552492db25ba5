//! The active pieces of rows that are maxima of many functions.

/// A piece of a row: the numbers of the two parts of the robot or its surroundings whose distance it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The row.
    pub row: usize,
    /// The numbers of the parts, as the constraint counts them.
    pub of: [usize; 2],
}

/// The active pieces of the rows of a constraint, in ascending order of the rows: those that are the largest at a
/// state. A constraint with them computes its rows from these alone, without a search for others.
#[derive(Clone, Copy, Debug)]
pub struct Pieces<'a> {
    all: &'a [Piece],
    /// The number that is subtracted from each row.
    first: usize,
}

impl<'a> Pieces<'a> {
    /// The pieces of a constraint, in ascending order of the rows.
    #[must_use]
    pub fn new(all: &'a [Piece]) -> Self {
        Self { all, first: 0 }
    }

    /// The pieces of the first `count` rows, and those of the others, whose rows are counted from there.
    #[must_use]
    pub fn split_at(self, count: usize) -> (Self, Self) {
        let end = self.first + count;
        let (own, rest) = self
            .all
            .split_at(self.all.partition_point(|piece| piece.row < end));
        let rest = Self {
            all: rest,
            first: end,
        };
        (Self { all: own, ..self }, rest)
    }

    /// The pieces in ascending order of the rows.
    pub fn iter(self) -> impl Iterator<Item = Piece> + use<'a> {
        self.all.iter().map(move |piece| Piece {
            row: piece.row - self.first,
            ..*piece
        })
    }
}
