//! Clearances of balls on the robot from solids of every shape.

use super::clearance::distance;
use super::label::name_of;
use super::{
    ActivePair, CollisionSphere, Constraint, PairDistance, PlacedState, Quantity, RowLabel, RowList, RowSet,
    WeightedDerivatives, Weights,
};
use crate::error::Result;
use crate::geometry::Solid;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::outer;
use nalgebra::{Matrix3, Vector3};

/// Each ball stays outside each solid: $g = \rho - d(p)$ in m, with $\rho$ and `p` of the ball and the [signed
/// distance](Solid::distance) `d` of the solid. Row `i m + j` is that of ball `i` and solid `j` of `m`.
///
/// A ball with a positive radius touches a solid at a point where the distance is smooth enough; see
/// [`geometry`](crate::geometry) for edges and the interior.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidClearance<C: Scalar = f64> {
    /// The balls on the robot.
    pub balls: Vec<CollisionSphere<C>>,
    /// The solid obstacles, placed in the base frame.
    pub solids: Vec<Solid<C>>,
    /// The names of the solids for reports; a solid without one is called by its shape and number.
    pub names: Vec<String>,
}

/// The name of a solid with this index.
pub(super) fn name_of_solid<C: Scalar>(names: &[String], solids: &[Solid<C>], solid: usize) -> String {
    match names.get(solid) {
        Some(name) => format!("'{name}'"),
        None => format!("{} {solid}", solids[solid].shape.name()),
    }
}

impl<C: Scalar> Constraint<C> for SolidClearance<C> {
    fn dim(&self) -> usize {
        self.balls.len() * self.solids.len()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        let mut rows = g.iter_mut();
        for ball in &self.balls {
            let p = at.point(ball.body, &ball.centre)?;
            let radius = S::lift(ball.radius);
            for (solid, g) in self.solids.iter().zip(&mut rows) {
                *g = radius - solid.distance(&p);
            }
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
        rows.by_ball((&self.balls, self.solids.len()), at, |row, j, ball, p| {
            g[row] = S::lift(ball.radius) - self.solids[j].distance(p);
        })
    }

    fn row_set(&self, row: usize) -> RowSet<C> {
        let ball = self.balls.get(row / self.solids.len().max(1));
        RowSet::clearance(ball.map(|ball| PairDistance::new([Some(ball), None], None)))
    }

    /// Solids are counted from zero.
    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        // There is no row without a solid.
        let solids = self.solids.len().max(1);
        let Some(ball) = self.balls.get(row / solids) else {
            return RowLabel::numbered(row);
        };
        let body = name_of(ball.body, model);
        let solid = name_of_solid(&self.names, &self.solids, row % solids);
        distance(body, solid, Quantity::Obstacles)
    }

    /// The gradient in `p` is $-n$ and the Hessian is minus the curvature. Balls and rows with zero weights are
    /// skipped.
    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let m = self.solids.len();
        for (i, ball) in self.balls.iter().enumerate() {
            let rows = i * m..(i + 1) * m;
            if rows.clone().all(|row| weights.vanish(row)) {
                continue;
            }
            let p = at.point(ball.body, &ball.centre)?;
            let (mut force, mut stiffness) = (Vector3::zeros(), Matrix3::zeros());
            for (solid, row) in self.solids.iter().zip(rows) {
                if weights.vanish(row) {
                    continue;
                }
                let near = solid.distance_derivatives(&p);
                let w = weights.first_order[row];
                force -= near.normal * w;
                if let Some(c) = weights.gauss_newton {
                    let scaled = near.normal * c[row];
                    stiffness += outer(&scaled, &near.normal) - near.curvature * w;
                }
            }
            out.add_point(ball.body, &p, &force, &stiffness)?;
        }
        Ok(())
    }
}
