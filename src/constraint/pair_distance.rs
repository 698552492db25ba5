//! Rows that are functions of one distance, and lists of rows.

use super::{CollisionSphere, PlacedState};
use crate::error::Result;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::dot;
use nalgebra::Vector3;
use std::ops::Range;

/// The distance of two balls, or of one from an obstacle, of which a row is a function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairDistance<C: Scalar = f64> {
    /// The body of each ball that is on one, with the distance of its centre from the origin of the body, in m.
    pub bodies: [Option<(usize, C)>; 2],
    /// The sum `R` of the radii if the row is $R^2 - d^2$ for a distance `d` of the centres, scaled by `2 R`; `None` if
    /// it is minus the distance of the surfaces.
    pub squared: Option<C>,
}

impl<C: Scalar> PairDistance<C> {
    pub(super) fn new(balls: [Option<&CollisionSphere<C>>; 2], squared: Option<C>) -> Self {
        let body = |ball: &CollisionSphere<C>| {
            let r = dot(&ball.centre, &ball.centre).sqrt();
            ball.body.map(|body| (body, r))
        };
        Self { bodies: balls.map(|ball| ball.and_then(body)), squared }
    }
}

impl PairDistance {
    /// The least distance of the surfaces, in m, for a value of the scaled row.
    #[must_use]
    pub fn distance(&self, value: f64) -> f64 {
        match self.squared {
            None => -value,
            Some(reach) => (reach * (reach - 2.0 * value)).sqrt() - reach,
        }
    }

    /// The value of the scaled row at a distance of the surfaces, in m: the inverse of [`distance`](Self::distance).
    #[must_use]
    pub fn value(&self, distance: f64) -> f64 {
        match self.squared {
            None => -distance,
            Some(reach) => -distance * (1.0 + 0.5 * distance / reach),
        }
    }
}

/// Some rows of a constraint in ascending order.
#[derive(Clone, Copy, Debug)]
pub struct RowList<'a> {
    rows: &'a [usize],
    /// The number that is subtracted from each.
    first: usize,
}

impl<'a> RowList<'a> {
    /// The rows with these indices, in ascending order.
    #[must_use]
    pub fn new(rows: &'a [usize]) -> Self {
        Self { rows, first: 0 }
    }

    /// The rows among the first `count` ones, and the others, counted from there.
    #[must_use]
    pub fn split_at(self, count: usize) -> (Self, Self) {
        let end = self.first + count;
        let (own, rest) = self.rows.split_at(self.rows.partition_point(|row| *row < end));
        let rest = Self { rows: rest, first: end };
        (Self { rows: own, ..self }, rest)
    }

    /// Returns true if one of the rows is in a range.
    #[must_use]
    pub fn has_any(self, range: &Range<usize>) -> bool {
        let at = |row: usize| self.rows.partition_point(|own| *own < self.first + row);
        at(range.start) < at(range.end)
    }

    /// The rows in ascending order.
    pub fn iter(self) -> impl Iterator<Item = usize> + use<'a> {
        self.rows.iter().map(move |row| row - self.first)
    }

    /// Calls `visit` for each of these rows of balls with `count` rows each: with the row, its number among those of
    /// its ball, the ball and the position of its centre, which is computed once.
    #[inline]
    pub(super) fn by_ball<C: Scalar, S: AlgebraOver<C>>(
        self,
        (balls, count): (&[CollisionSphere<C>], usize),
        at: &PlacedState<'_, C, S>,
        mut visit: impl FnMut(usize, usize, &CollisionSphere<C>, &Vector3<S>),
    ) -> Result<()> {
        let mut rows = self.iter().peekable();
        for (ball, first) in balls.iter().zip((0..).step_by(count.max(1))) {
            let own = |row: &usize| *row < first + count;
            if rows.peek().is_none_or(|row| !own(row)) {
                continue;
            }
            let p = at.point(ball.body, &ball.centre)?;
            while let Some(row) = rows.next_if(own) {
                visit(row, row - first, ball, &p);
            }
        }
        Ok(())
    }
}
