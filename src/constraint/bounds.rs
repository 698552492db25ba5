//! Bounds on single numbers: positions, velocities, torques.

use super::{Constraint, PlacedState, Quantity, RowLabel, WeightedDerivatives, Weights};
use crate::error::{Error, Result};
use crate::model::{Limits, Model};
use crate::scalar::{AlgebraOver, Scalar};

/// The bounded side of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The number is at least the bound.
    Lower,
    /// The number is at most the bound.
    Upper,
}

impl Side {
    /// The side in words.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Lower => "lower",
            Self::Upper => "upper",
        }
    }

    /// The slope of a row in the bounded number.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Lower => -1.0,
            Self::Upper => 1.0,
        }
    }
}

/// A bound on one of several numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound<C: Scalar = f64> {
    /// The index of the number.
    pub entry: usize,
    /// The side that is bounded.
    pub side: Side,
    /// The bound.
    pub value: C,
}

impl<C: Scalar> Bound<C> {
    /// Computes $g$, linear in the bounded number `x`: $x - \bar x$ or $\bar x - x$.
    #[inline]
    #[must_use]
    pub fn row<S: AlgebraOver<C>>(&self, x: S) -> S {
        self.signed(x - S::lift(self.value))
    }

    /// Multiplies `y` by the slope of $g$, which is one for an upper bound and minus one for a lower bound.
    #[inline]
    #[must_use]
    pub fn signed<S: Scalar>(&self, y: S) -> S {
        match self.side {
            Side::Lower => -y,
            Side::Upper => y,
        }
    }
}

/// Bounds on entries of $x = [q; v]$, one linear row each.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds<C: Scalar = f64>(pub Vec<Bound<C>>);

/// The finite bounds among two for each joint, on the entries from `first` on.
pub(super) fn of_limits<C: Scalar>(model: &Model<C>, first: usize, pair: fn(&Limits) -> [f64; 2]) -> Vec<Bound<C>> {
    let both = |(i, limits): (usize, [f64; 2])| {
        [Side::Lower, Side::Upper].into_iter().zip(limits).map(move |(side, value)| (i, side, value))
    };
    let limits = model.joints().iter().map(|joint| pair(joint.limits()));
    let all = limits.enumerate().flat_map(both);
    all.filter(|(_, _, value)| value.is_finite())
        .map(|(i, side, value)| Bound { entry: first + i, side, value: C::from_f64(value) })
        .collect()
}

impl<C: Scalar> Bounds<C> {
    /// The finite limits of the joints on their positions, in rad or m.
    #[must_use]
    pub fn positions(model: &Model<C>) -> Self {
        Self(of_limits(model, 0, |l| [l.lower, l.upper]))
    }

    /// The finite limits of the joints on their speeds, in rad/s or m/s.
    #[must_use]
    pub fn velocities(model: &Model<C>) -> Self {
        Self(of_limits(model, model.dof(), |l| [-l.velocity, l.velocity]))
    }
}

/// Returns entry `i` of a slice.
pub(super) fn entry<S: Copy>(x: &[S], i: usize) -> Result<S> {
    x.get(i).copied().ok_or(Error::Length { what: "bounded numbers", expected: i + 1, found: x.len() })
}

impl<C: Scalar> Constraint<C> for Bounds<C> {
    fn dim(&self) -> usize {
        self.0.len()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        for (bound, g) in self.0.iter().zip(g) {
            *g = bound.row(entry(at.x, bound.entry)?);
        }
        Ok(())
    }

    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        let Some(bound) = self.0.get(row) else {
            return RowLabel::numbered(row);
        };
        let (joint, quantity) = match bound.entry.checked_sub(model.dof()) {
            None => (bound.entry, Quantity::Position),
            Some(joint) => (joint, Quantity::Velocity),
        };
        RowLabel::limit(quantity, (joint, Some(bound.side)), row, model)
    }

    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        for (row, bound) in self.0.iter().enumerate() {
            entry(at.x, bound.entry)?;
            let c = weights.gauss_newton.map_or(S::zero(), |c| c[row]);
            out.add_entry(bound.entry, bound.signed(weights.first_order[row]), c);
        }
        Ok(())
    }
}

/// The highest order of a derivative of a motion on which rows and costs may depend: the jerk.
pub const MAX_ORDER: usize = 3;

/// A limit of a derivative of the motion of one joint on one side, the row $\pm x / \bar x - 1 \le 0$.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateLimit {
    /// The number of the derivative in time: 2 for acceleration, 3 for jerk.
    pub order: usize,
    /// The index of the joint.
    pub joint: usize,
    /// The side that is bounded.
    pub side: Side,
    /// The largest absolute value on this side, in rad/s^2 or m/s^2, or rad/s^3 or m/s^3.
    pub limit: f64,
}

impl RateLimit {
    /// A limit on both sides.
    #[must_use]
    pub fn both(order: usize, joint: usize, limit: f64) -> [Self; 2] {
        [Side::Upper, Side::Lower].map(|side| Self { order, joint, side, limit })
    }
}
