//! Constraints $g(x) \le 0$, some rows of which may be equalities $g_j(x) = 0$, implemented once for all scalars.
//!
//! A [`Constraint`] is defined by its value; the [guide](crate::guide::constraint) implements one in ten lines. An
//! optimiser needs only contractions of the derivatives, with one weight per row of `g`:
//!
//! $$ \sum_j w_j \frac{\partial g_j}{\partial x}, \qquad \sum_j \left( w_j \frac{\partial^2 g_j}{\partial x^2} +
//!    c_j \frac{\partial g_j}{\partial x} \frac{\partial g_j}{\partial x}^T \right) , $$
//!
//! with $w = b^{\prime}(g)$ and $c = b^{\prime\prime}(g)$ for penalties, or with multipliers and the weights of the
//! rows in the condensed equations. By default they come from dual numbers; all built-in constraints have
//! analytic ones. An [`Evaluator`] computes the placements of the bodies once per state for all constraints.

mod active_pair;
mod any;
mod autodiff;
mod bounds;
mod clearance;
mod composition;
mod convex_clearance;
mod dynamic;
mod evaluator;
mod frame_rows;
mod label;
mod pair_distance;
mod pair_loads;
mod phase;
mod point_speed;
mod power_limits;
mod row_set;
mod self_clearance;
mod solid_clearance;
mod stage;
mod standing_foot;
mod time_window;
mod torque_limits;
mod weighted_derivatives;

pub use active_pair::{ActivePair, ActivePairs};
pub use any::AnyConstraint;
pub use bounds::{Bound, Bounds, MAX_ORDER, RateLimit, Side};
pub use clearance::SphereClearance;
pub use convex_clearance::{ConvexClearance, ConvexPair, ConvexPart, Other};
pub use dynamic::{DynConstraint, Functions};
pub use evaluator::{Evaluator, Placed};
pub use frame_rows::{FrameRow, FrameRows};
pub use label::{Quantity, RowForm, RowLabel};
pub use pair_distance::{PairDistance, RowList};
pub use phase::Phase;
pub(crate) use phase::is_permutation;
pub use point_speed::PointSpeedLimit;
pub use power_limits::PowerLimits;
pub use row_set::RowSet;
pub use self_clearance::SelfClearance;
pub use solid_clearance::SolidClearance;
pub(crate) use stage::still;
pub use stage::{StageConstraint, StageConstraints, StageDerivatives, StageInput, StageRows};
pub use standing_foot::{FootContact, FootDerivatives, FootWeights, StandingFoot};
pub use time_window::TimeWindow;
pub(crate) use torque_limits::NONE;
pub use torque_limits::{Constraints, TorqueLimits};
pub use weighted_derivatives::WeightedDerivatives;

pub use crate::geometry::{CollisionSphere, Sphere};

use crate::error::{Error, Result, check_length};
use crate::model::{Frame, Model};
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::Placement;
use nalgebra::Vector3;

/// Constraints $g_j(x) \le 0$ on a state $x = [q; v]$, or $g_j(x) = 0$ for the rows that are an
/// [equality](RowSet::is_equality).
///
/// Pairs and triples, arrays, vectors and slices of constraints are a constraint with the rows of each in order; `()`
/// has no rows. `&K` delegates to `K`. A list of different constraints is a `Vec` of [`AnyConstraint`] or of
/// `Box<dyn`[`DynConstraint`]`>`.
pub trait Constraint<C: Scalar = f64> {
    /// The number of rows $g_j$.
    fn dim(&self) -> usize;

    /// Computes $g(x)$ at a state into `g`, [`dim`](Self::dim) entries. A positive value is a violation.
    ///
    /// # Errors
    /// The constraint refers to a joint or body that the robot does not have.
    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()>;

    /// The set of values that row `row` may have, and what is known of the row at every state. By default at most zero.
    fn row_set(&self, row: usize) -> RowSet<C> {
        let _ = row;
        RowSet::at_most_zero()
    }

    /// The [scales](RowSet::scale) of all rows, [`dim`](Self::dim) entries.
    fn row_scales(&self) -> Vec<C> {
        (0..self.dim()).map(|row| self.row_set(row).scale).collect()
    }

    /// The name of row `row` and the unit of its [excess](RowForm::excess), for reports. By default the number of the
    /// row, without a unit.
    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        let _ = model;
        RowLabel::numbered(row)
    }

    /// Computes [`value`](Self::value), or at least the rows of a list, and appends the [pairs](ActivePair) of bodies
    /// that are near each other, in ascending order of the rows, if they are asked for. By default all rows, none of
    /// which has any.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    fn value_of<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        rows: Option<RowList<'_>>,
        g: &mut [S],
        active_pairs: Option<&mut Vec<ActivePair<S>>>,
    ) -> Result<()> {
        let _ = (rows, active_pairs);
        self.value(at, g)
    }

    /// Appends the built-in constraints among those of a list to `parts`; returns false if there are others. A planner
    /// tests them without computing all of their rows. By default only a constraint without rows has no others.
    fn parts<'a>(&'a self, parts: &mut Vec<&'a AnyConstraint<C>>) -> bool {
        let _ = parts;
        self.dim() == 0
    }

    /// Adds the contractions with the weights of the rows to `out`. By default by dual numbers of the value: `N / 2`
    /// evaluations with four tangents for the gradient, about $N^2 / 2$ with nine numbers each for the Hessian.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        autodiff::add_weighted_derivatives(self, at, weights, out)
    }
}

/// The input of a constraint: a state and the placements of the bodies in it.
#[derive(Clone, Copy, Debug)]
pub struct PlacedState<'a, C: Scalar, S: Scalar> {
    /// The robot.
    pub model: &'a Model<C>,
    /// The state $x = [q; v]$, `2 N` entries.
    pub x: &'a [S],
    /// The placements of all bodies in the base frame.
    pub placements: &'a [Placement<S>],
    /// The pairs that were near each other at a state nearby, along a search. Rows beyond half of their cutoff then
    /// count as being at it.
    pub active_pairs: Option<ActivePairs<'a, S>>,
}

impl<'a, C: Scalar, S: AlgebraOver<C>> PlacedState<'a, C, S> {
    /// The same state for the first `count` rows of a constraint, and for the others.
    #[must_use]
    pub fn split_at(&self, count: usize) -> (Self, Self) {
        let (own, rest) = self.active_pairs.map(|active_pairs| active_pairs.split_at(count)).unzip();
        let [first, rest] = [own, rest].map(|active_pairs| Self { active_pairs, ..*self });
        (first, rest)
    }

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

    /// Computes the position of a point of a body in the base frame; without a body the point is fixed to the base.
    ///
    /// # Errors
    /// The robot has no such body.
    #[inline]
    pub fn point(&self, body: Option<usize>, in_body: &Vector3<C>) -> Result<Vector3<S>> {
        let Some(body) = body else {
            return Ok(in_body.map(S::lift));
        };
        Ok(self.body(body)?.point(in_body))
    }

    /// Computes the placement of a frame in the base frame.
    ///
    /// # Errors
    /// The robot does not have the body of the frame.
    pub fn frame(&self, frame: &Frame<C>) -> Result<Placement<S>> {
        let within = &frame.placement;
        let Some(body) = frame.body else {
            let (rotation, translation) = (within.rotation, within.translation);
            return Ok(Placement::new(rotation.map(S::lift), translation.map(S::lift)));
        };
        Ok(self.body(body)?.compose_constant(within))
    }

    /// The placement of a body.
    #[inline]
    fn body(&self, body: usize) -> Result<&'a Placement<S>> {
        self.placements.get(body).ok_or(Error::Length {
            what: "bodies of the robot of a constraint",
            expected: body + 1,
            found: self.placements.len(),
        })
    }
}

/// The weights of a contraction, one entry per row of the constraint.
#[derive(Clone, Copy, Debug)]
pub struct Weights<'a, S> {
    /// The weights $w$ of the first and second derivatives.
    pub first_order: &'a [S],
    /// The weights $c$ of the products of gradients; `None` if only the gradient is needed.
    pub gauss_newton: Option<&'a [S]>,
}

impl<'a, S> Weights<'a, S> {
    /// The weights of the first `rows` rows, and those of the rest.
    #[must_use]
    pub fn split_at(self, rows: usize) -> (Self, Self) {
        let (w, w_rest) = self.first_order.split_at(rows);
        let (c, c_rest) = self.gauss_newton.map(|c| c.split_at(rows)).unzip();
        let rest = Self { first_order: w_rest, gauss_newton: c_rest };
        let first = Self { first_order: w, gauss_newton: c };
        (first, rest)
    }

    /// Returns true if all weights of row `row` are zero.
    #[inline]
    fn vanish(&self, row: usize) -> bool
    where
        S: Scalar,
    {
        self.first_order[row].vanishes() && self.gauss_newton.is_none_or(|c| c[row].vanishes())
    }

    /// Checks that the number of weights is the number of rows.
    fn check(&self, rows: usize) -> Result<()> {
        check_length("weights w", rows, self.first_order.len())?;
        self.gauss_newton.map_or(Ok(()), |c| check_length("weights c", rows, c.len()))
    }
}
