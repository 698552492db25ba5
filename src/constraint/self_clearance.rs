//! Clearances between balls on the robot.

use super::clearance::distance;
use super::label::name_of;
use super::{
    ActivePair, CollisionSphere, Constraint, PairDistance, PlacedState, Quantity, RowLabel, RowList, RowSet,
    WeightedDerivatives, Weights,
};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::dot;
use nalgebra::Vector3;

/// The number of balls up to which their places are on the stack: more than those of most models of arms.
const MAX_ON_STACK: usize = 128;

/// The two balls of every pair do not overlap: $g = (r_1 + r_2)^2 - |p_1 - p_2|^2$ in m^2, one row per pair. The
/// squares make it smooth everywhere. Consecutive pairs on the same two bodies share their work.
#[derive(Clone, Debug, PartialEq)]
pub struct SelfClearance<C: Scalar = f64> {
    /// The balls on the robot, possibly some on its base.
    pub balls: Vec<CollisionSphere<C>>,
    /// The indices of the two balls of each pair.
    pub pairs: Vec<[usize; 2]>,
}

impl<C: Scalar> SelfClearance<C> {
    /// The balls of a pair.
    fn pair(&self, [i, j]: [usize; 2]) -> Result<[&CollisionSphere<C>; 2]> {
        let ball = |i: usize| {
            self.balls.get(i).ok_or_else(|| Error::Length {
                what: "balls of the pairs of a constraint",
                expected: i + 1,
                found: self.balls.len(),
            })
        };
        Ok([ball(i)?, ball(j)?])
    }
}

/// The row of two balls with their centres at these points.
#[inline]
fn row_of<C: Scalar, S: AlgebraOver<C>>([first, second]: [&CollisionSphere<C>; 2], [p, q]: [&Vector3<S>; 2]) -> S {
    let (reach, d) = (first.radius + second.radius, p - q);
    S::lift(reach * reach) - dot(&d, &d)
}

impl<C: Scalar> Constraint<C> for SelfClearance<C> {
    fn dim(&self) -> usize {
        self.pairs.len()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        let (mut few, mut many) = ([Vector3::zeros(); MAX_ON_STACK], Vec::new());
        let count = self.balls.len();
        let places = if count <= MAX_ON_STACK {
            &mut few[..count]
        } else {
            many.resize(count, Vector3::zeros());
            &mut many
        };
        for (place, ball) in places.iter_mut().zip(&self.balls) {
            *place = at.point(ball.body, &ball.centre)?;
        }
        for (pair, g) in self.pairs.iter().zip(g) {
            *g = row_of(self.pair(*pair)?, pair.map(|ball| &places[ball]));
        }
        Ok(())
    }

    fn value_of<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        rows: Option<RowList<'_>>,
        g: &mut [S],
        _: Option<&mut Vec<ActivePair<S>>>,
    ) -> Result<()> {
        let Some(rows) = rows else {
            return self.value(at, g);
        };
        for row in rows.iter() {
            let [first, second] = self.pair(self.pairs[row])?;
            let p = at.point(first.body, &first.centre)?;
            let q = at.point(second.body, &second.centre)?;
            g[row] = row_of([first, second], [&p, &q]);
        }
        Ok(())
    }

    fn row_set(&self, row: usize) -> RowSet<C> {
        let pair = self.pairs.get(row).and_then(|pair| self.pair(*pair).ok());
        RowSet::clearance(pair.map(|[first, second]| {
            let reach = first.radius + second.radius;
            PairDistance::new([Some(first), Some(second)], Some(reach))
        }))
    }

    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        let Some(Ok(pair)) = self.pairs.get(row).map(|pair| self.pair(*pair)) else {
            return RowLabel::numbered(row);
        };
        let [first, second] = pair.map(|ball| name_of(ball.body, model));
        distance(first, second, Quantity::SelfCollision)
    }

    /// As a function of $s = |p_1 - p_2|^2 / 2$ the row is linear with slope $-2$. Pairs with zero weights are skipped.
    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let (slope, square) = (S::from_f64(-2.0), S::from_f64(4.0));
        for (row, pair) in self.pairs.iter().enumerate() {
            if weights.vanish(row) {
                continue;
            }
            let [first, second] = self.pair(*pair)?;
            let p = at.point(first.body, &first.centre)?;
            let q = at.point(second.body, &second.centre)?;
            let c = weights.gauss_newton.map_or(S::zero(), |c| c[row]);
            let bodies = [first.body, second.body];
            out.add_pair(bodies, [&p, &q], weights.first_order[row] * slope, c * square)?;
        }
        Ok(())
    }
}
