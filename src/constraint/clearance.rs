//! Clearances of balls on the robot from spheres and half-spaces.

use super::label::name_of;
use super::{Constraint, PlacedState, RowKind, RowLabel, WeightedDerivatives, Weights};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{Matrix3, Vector3};

/// A ball on a body, in m; with radius zero it is a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionSphere<C: Scalar = f64> {
    /// The body; `None` is the base.
    pub body: Option<usize>,
    /// Its centre in the body.
    pub centre: Vector3<C>,
    /// Its radius.
    pub radius: C,
}

impl<C: Scalar> CollisionSphere<C> {
    /// The origins of all joint frames as points: the paper's collision model.
    #[must_use]
    pub fn joint_frames(model: &Model<C>) -> Vec<Self> {
        let origin = |body| Self {
            body: Some(body),
            centre: Vector3::zeros(),
            radius: C::zero(),
        };
        (0..model.dof()).map(origin).collect()
    }

    /// A ball about the origin of the frame of a link.
    ///
    /// # Errors
    /// The model has no link of that name.
    pub fn at_link(model: &Model<C>, link: &str, radius: C) -> Result<Self> {
        let frame = model.frames().iter().find(|f| f.name == link);
        let frame = frame.ok_or_else(|| {
            Error::input(
                model.name(),
                format!("link '{link}'"),
                "there is no such link",
            )
        })?;
        Ok(Self {
            body: frame.body,
            centre: frame.placement.translation,
            radius,
        })
    }
}

/// A ball fixed in the base frame as an obstacle, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere<C: Scalar = f64> {
    /// Its centre.
    pub centre: Vector3<C>,
    /// Its radius.
    pub radius: C,
}

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

impl<C: Scalar> Constraint<C> for SphereClearance<C> {
    fn dim(&self) -> usize {
        self.balls.len() * self.spheres.len()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        let mut rows = g.iter_mut();
        for ball in &self.balls {
            let p = at.point(ball.body, &ball.centre)?;
            for (sphere, g) in self.spheres.iter().zip(&mut rows) {
                let d = p - sphere.centre.map(S::lift);
                let reach = sphere.radius + ball.radius;
                *g = S::lift(reach * reach) - d.dot(&d);
            }
        }
        Ok(())
    }

    /// $2 (r + \rho)$, because $g$ is about that times the depth.
    fn row_scales(&self, scales: &mut [C]) {
        let balls = self.balls.iter();
        let reaches = balls.flat_map(|b| self.spheres.iter().map(|s| s.radius + b.radius));
        for (scale, reach) in scales.iter_mut().zip(reaches) {
            *scale = reach + reach;
        }
    }

    /// Spheres are counted from zero.
    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        // There is no row without a sphere.
        let spheres = self.spheres.len().max(1);
        let Some(ball) = self.balls.get(row / spheres) else {
            return RowLabel::numbered(row);
        };
        let (body, sphere) = (name_of(ball.body, model), row % spheres);
        clearance(format!("distance of {body} from sphere {sphere}"))
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

/// The half-space $n \cdot p \ge \delta$ of the base frame, such as the space above a floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace<C: Scalar = f64> {
    /// The unit normal `n`, pointing into the free half-space.
    pub normal: Vector3<C>,
    /// The offset $\delta$, in m.
    pub offset: C,
}

/// Each ball stays in a half-space: $g = \rho + \delta - n \cdot p$ in m, one row per ball.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfSpaceClearance<C: Scalar = f64> {
    /// The balls on the robot.
    pub balls: Vec<CollisionSphere<C>>,
    /// The half-space that the balls must stay in.
    pub half_space: HalfSpace<C>,
}

impl<C: Scalar> Constraint<C> for HalfSpaceClearance<C> {
    fn dim(&self) -> usize {
        self.balls.len()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        let HalfSpace { normal, offset } = &self.half_space;
        for (ball, g) in self.balls.iter().zip(g) {
            let p = at.point(ball.body, &ball.centre)?;
            let height = p.x.scale(normal.x) + p.y.scale(normal.y) + p.z.scale(normal.z);
            *g = S::lift(ball.radius + *offset) - height;
        }
        Ok(())
    }

    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        let Some(ball) = self.balls.get(row) else {
            return RowLabel::numbered(row);
        };
        let HalfSpace { normal, offset } = &self.half_space;
        let body = name_of(ball.body, model);
        let [x, y, z] = [normal.x, normal.y, normal.z];
        clearance(format!(
            "distance of {body} from the plane ({x:.3?}, {y:.3?}, {z:.3?}) . p = {offset:.3?}"
        ))
    }

    /// The gradient in `p` is $-n$.
    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let n = self.half_space.normal.map(S::lift);
        let square = n * n.transpose();
        for (row, ball) in self.balls.iter().enumerate() {
            let p = at.point(ball.body, &ball.centre)?;
            let c = weights.gauss_newton.map_or(S::zero(), |c| c[row]);
            out.add_point(
                ball.body,
                &p,
                &(n * -weights.first_order[row]),
                &(square * c),
            )?;
        }
        Ok(())
    }
}

/// The label of a distance.
pub(super) fn clearance(name: String) -> RowLabel {
    RowLabel {
        name,
        unit: "m",
        kind: RowKind::Clearance,
    }
}
