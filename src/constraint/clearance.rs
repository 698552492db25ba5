//! Clearances of balls on the robot from spheres.

use super::label::name_of;
use super::{
    ActivePair, CollisionSphere, Constraint, PairDistance, PlacedState, Quantity, RowLabel, RowList, RowSet,
    WeightedDerivatives, Weights,
};
use crate::error::Result;
use crate::geometry::Sphere;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{Matrix3, Vector3};

/// Each ball stays outside each sphere: $g = (r + \rho)^2 - |p - c|^2$ in m^2, with $\rho$ and `p` of the ball and `r`
/// and `c` of the sphere. Row `i m + j` is that of ball `i` and sphere `j` of `m`. The squares make it smooth
/// everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereClearance<C: Scalar = f64> {
    /// The balls on the robot.
    pub balls: Vec<CollisionSphere<C>>,
    /// The sphere obstacles.
    pub spheres: Vec<Sphere<C>>,
}

/// The row of a ball with its centre at `p` and a sphere.
#[inline]
fn row_of<C: Scalar, S: AlgebraOver<C>>(ball: &CollisionSphere<C>, p: &Vector3<S>, sphere: &Sphere<C>) -> S {
    let d = p - sphere.centre.map(S::lift);
    let reach = sphere.radius + ball.radius;
    S::lift(reach * reach) - d.dot(&d)
}

impl<C: Scalar> Constraint<C> for SphereClearance<C> {
    fn dim(&self) -> usize {
        self.balls.len() * self.spheres.len()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        let mut rows = g.iter_mut();
        for ball in &self.balls {
            let p = at.point(ball.body, &ball.centre)?;
            for (sphere, g) in self.spheres.iter().zip(&mut rows) {
                *g = row_of(ball, &p, sphere);
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
        rows.by_ball((&self.balls, self.spheres.len()), at, |row, j, ball, p| {
            g[row] = row_of(ball, p, &self.spheres[j]);
        })
    }

    /// Of scale $2 (r + \rho)$, because $g$ is about that times the depth.
    fn row_set(&self, row: usize) -> RowSet<C> {
        let m = self.spheres.len().max(1);
        let gap = |ball: &CollisionSphere<C>| {
            let reach = self.spheres[row % m].radius + ball.radius;
            PairDistance::new([Some(ball), None], Some(reach))
        };
        RowSet::clearance(self.balls.get(row / m).map(gap))
    }

    /// Spheres are counted from zero.
    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        // There is no row without a sphere.
        let spheres = self.spheres.len().max(1);
        let Some(ball) = self.balls.get(row / spheres) else {
            return RowLabel::numbered(row);
        };
        let (body, sphere) = (name_of(ball.body, model), row % spheres);
        distance(body, format!("sphere {sphere}"), Quantity::Obstacles)
    }

    /// With $d = p - c$ the gradient in `p` is $-2 d$ and the Hessian $-2 I$.
    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let (two, four) = (S::from_f64(2.0), S::from_f64(4.0));
        let mut rows = 0..;
        for ball in &self.balls {
            let p = at.point(ball.body, &ball.centre)?;
            let (mut pull, mut total) = (Vector3::zeros(), S::zero());
            let mut outer = Matrix3::zeros();
            for (sphere, row) in self.spheres.iter().zip(&mut rows) {
                let d = p - sphere.centre.map(S::lift);
                let w = weights.first_order[row];
                pull += d * w;
                total += w;
                if let Some(c) = weights.gauss_newton {
                    let scaled = d * c[row];
                    outer += scaled * d.transpose();
                }
            }
            let stiffness = outer * four - Matrix3::from_diagonal_element(total * two);
            out.add_point(ball.body, &p, &(-(pull * two)), &stiffness)?;
        }
        Ok(())
    }
}

/// The label of the distance of two bodies, the second of which may be an obstacle.
pub(super) fn distance(from: String, to: String, of: Quantity) -> RowLabel {
    RowLabel::new(format!("distance of {from} from {to}"), "m", of)
}
