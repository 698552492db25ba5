//! Constraints $g(x) \le 0$, some rows of which may be equalities $g_j(x) = 0$, written once for every scalar.
//!
//! A [`Constraint`] is its value; the [guide](crate::guide::constraint) writes one in ten lines. What an optimiser needs
//! of the derivatives are contractions with weights, one for each row of `g`:
//!
//! $$ \sum_j w_j \frac{\partial g_j}{\partial x}, \qquad \sum_j \left( w_j \frac{\partial^2 g_j}{\partial x^2} +
//!    c_j \frac{\partial g_j}{\partial x} \frac{\partial g_j}{\partial x}^T \right) , $$
//!
//! with $w = b^{\prime}(g)$ and $c = b^{\prime\prime}(g)$ for penalties, or with multipliers and the weight of the active rows for an
//! augmented Lagrangian. They come from dual numbers of the value unless a constraint knows better, as all do that are here. An
//! [`Evaluator`] places the bodies once at a state for all of them.

mod any;
mod autodiff;
mod bounds;
mod capsules;
mod clearance;
mod composition;
mod dynamic;
mod evaluator;
mod label;
mod pair_loads;
mod self_clearance;
mod solid_clearance;
mod torque_limits;
mod weighted_derivatives;

pub use any::AnyConstraint;
pub use bounds::{Bound, Bounds, Side};
pub use capsules::Capsule;
pub use clearance::{CollisionSphere, HalfSpace, HalfSpaceClearance, Sphere, SphereClearance};
pub use dynamic::{DynConstraint, Functions};
pub use evaluator::{Evaluator, Placed};
pub use label::{RowKind, RowLabel};
pub use self_clearance::SelfClearance;
pub use solid_clearance::SolidClearance;
pub use torque_limits::{Constraints, TorqueLimits};
pub use weighted_derivatives::WeightedDerivatives;

use crate::error::{Error, Result, check_length};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{Placement, apply_to_constant};
use nalgebra::Vector3;

/// Constraints $g_j(x) \le 0$ on a state $x = [q; v]$, or $g_j(x) = 0$ where [`is_equality`](Self::is_equality) says so.
///
/// Tuples of up to six, arrays, vectors and slices of constraints are one, with the rows of each in order; `()` has none. A `&K` is
/// what is behind it. Lists of different constraints are a `Vec` of [`AnyConstraint`] or of `Box<dyn`[`DynConstraint`]`>`.
pub trait Constraint<C: Scalar = f64> {
    /// The number of rows $g_j$.
    fn dim(&self) -> usize;

    /// $g(x)$ at a state, into `g`, which has [`dim`](Self::dim) entries. Positive where the constraint is violated.
    ///
    /// # Errors
    /// The constraint is for another robot.
    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()>;

    /// Writes the rate at which each row grows at its boundary with what it bounds, in rad, rad/s or m, to `scales`, which has
    /// [`dim`](Self::dim) entries: a row divided by it says in these units how far the boundary is. One unless overridden.
    fn row_scales(&self, scales: &mut [C]) {
        scales.fill(C::one());
    }

    /// The name of row `row` and the unit of the row divided by its [scale](Self::row_scales), for reports. The number of the
    /// row without a unit unless overridden.
    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        let _ = model;
        RowLabel::numbered(row)
    }

    /// Tells whether row `row` is an equality $g_j(x) = 0$, violated by $|g_j|$, and not an inequality $g_j(x) \le 0$. None is unless
    /// overridden.
    fn is_equality(&self, row: usize) -> bool {
        let _ = row;
        false
    }

    /// Adds to `out` the contractions with the weights of its rows. By dual numbers of the value unless overridden:
    /// `N / 2` evaluations with four tangents for the gradient, about $N^2 / 2$ with nine numbers each for the Hessian.
    ///
    /// # Errors
    /// As [`value`](Self::value).
    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        autodiff::add_weighted_derivatives(self, at, weights, out)
    }
}

/// The view that a constraint has of a state: its numbers and the placements of the bodies in it.
#[derive(Clone, Copy, Debug)]
pub struct PlacedState<'a, C: Scalar, S: Scalar> {
    /// The robot.
    pub model: &'a Model<C>,
    /// $x = [q; v]$, `2 N` entries.
    pub x: &'a [S],
    /// The placements of all bodies in the base frame.
    pub placements: &'a [Placement<S>],
}

impl<'a, C: Scalar, S: AlgebraOver<C>> PlacedState<'a, C, S> {
    /// The configuration.
    #[must_use]
    pub fn q(&self) -> &'a [S] {
        &self.x[..self.x.len() / 2]
    }

    /// The velocity.
    #[must_use]
    pub fn v(&self) -> &'a [S] {
        &self.x[self.x.len() / 2..]
    }

    /// The position of a point of a body in the base frame; without a body the point is fixed to the base.
    ///
    /// # Errors
    /// The robot has no such body.
    #[inline]
    pub fn point(&self, body: Option<usize>, in_body: &Vector3<C>) -> Result<Vector3<S>> {
        let Some(body) = body else {
            return Ok(in_body.map(S::lift));
        };
        match self.placements.get(body) {
            Some(placement) => {
                Ok(apply_to_constant(&placement.rotation, in_body) + placement.translation)
            }
            None => Err(Error::Length {
                what: "bodies of the robot of a constraint",
                expected: body + 1,
                found: self.placements.len(),
            }),
        }
    }
}

/// The weights of a contraction, one entry a row of the constraint.
#[derive(Clone, Copy, Debug)]
pub struct Weights<'a, S> {
    /// $w$, of the first and second derivatives.
    pub first_order: &'a [S],
    /// $c$, of the products of gradients; without it only the gradient is asked for.
    pub gauss_newton: Option<&'a [S]>,
}

impl<'a, S> Weights<'a, S> {
    /// Those of the first `rows` rows, and of the rest.
    #[must_use]
    pub fn split_at(self, rows: usize) -> (Self, Self) {
        let (w, w_rest) = self.first_order.split_at(rows);
        let (c, c_rest) = self.gauss_newton.map(|c| c.split_at(rows)).unzip();
        let rest = Self {
            first_order: w_rest,
            gauss_newton: c_rest,
        };
        let first = Self {
            first_order: w,
            gauss_newton: c,
        };
        (first, rest)
    }

    /// Tells whether nothing depends on row `row`.
    #[inline]
    fn vanish(&self, row: usize) -> bool
    where
        S: Scalar,
    {
        self.first_order[row].vanishes() && self.gauss_newton.is_none_or(|c| c[row].vanishes())
    }

    /// Checks that there are as many as rows.
    fn check(&self, rows: usize) -> Result<()> {
        check_length("weights w", rows, self.first_order.len())?;
        self.gauss_newton
            .map_or(Ok(()), |c| check_length("weights c", rows, c.len()))
    }
}
