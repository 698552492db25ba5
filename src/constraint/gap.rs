//! Rows that are functions of one distance, and lists of rows.

use super::CollisionSphere;
use crate::scalar::Scalar;

/// The distance of two balls on the robot, or of one from an obstacle, of which a row is a function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap<C: Scalar = f64> {
    /// The balls: one, or both.
    pub balls: [Option<CollisionSphere<C>>; 2],
    /// The sum `R` of the radii if the row is $R^2 - d^2$ for a distance `d` of the centres, scaled by `2 R`; `None` if
    /// it is minus the distance of the surfaces.
    pub squared: Option<C>,
}

impl Gap {
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

    /// The number of balls on moving bodies.
    #[must_use]
    pub fn moving(&self) -> usize {
        let balls = self.balls.iter().flatten();
        balls.filter(|ball| ball.body.is_some()).count()
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
        let (own, rest) = self
            .rows
            .split_at(self.rows.partition_point(|row| *row < end));
        let rest = Self {
            rows: rest,
            first: end,
        };
        (Self { rows: own, ..self }, rest)
    }

    /// The rows in ascending order.
    pub fn iter(self) -> impl Iterator<Item = usize> + use<'a> {
        self.rows.iter().map(move |row| row - self.first)
    }
}
