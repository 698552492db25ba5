//! The built-in constraints and a variant for any other.

use super::{
    ActivePair, Bounds, Constraint, ConvexClearance, DynConstraint, FrameRows, PlacedState, PointSpeedLimit, RowLabel,
    RowList, RowSet, SelfClearance, SolidClearance, SphereClearance, WeightedDerivatives, Weights,
};
use crate::error::Result;
use crate::geometry::{CollisionSphere, Obstacle, Scene, Shape, Sphere};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};

/// One of the built-in constraints, or any other, so that a list can mix types. The built-in ones need no pointer and
/// can be evaluated over every scalar.
#[derive(Clone, Debug)]
pub enum AnyConstraint<C: Scalar = f64> {
    /// Balls outside spheres.
    Spheres(SphereClearance<C>),
    /// Balls outside solids of every shape.
    Solids(SolidClearance<C>),
    /// Balls of the robot outside each other.
    SelfCollision(SelfClearance<C>),
    /// Convex bodies outside solids and each other.
    Convex(ConvexClearance<C>),
    /// Bounds on positions and velocities.
    Bounds(Bounds<C>),
    /// The placement of a frame.
    Frame(FrameRows<C>),
    /// The speed of a point.
    Speed(PointSpeedLimit<C>),
    /// Any other constraint, evaluated over fewer scalars: see [`DynConstraint`].
    Other(Box<dyn DynConstraint<C>>),
}

/// Applies the same expression to each variant.
macro_rules! each {
    ($of:expr, $it:ident => $what:expr) => {
        match $of {
            AnyConstraint::Spheres($it) => $what,
            AnyConstraint::Solids($it) => $what,
            AnyConstraint::SelfCollision($it) => $what,
            AnyConstraint::Convex($it) => $what,
            AnyConstraint::Bounds($it) => $what,
            AnyConstraint::Frame($it) => $what,
            AnyConstraint::Speed($it) => $what,
            AnyConstraint::Other($it) => $what,
        }
    };
}

impl AnyConstraint {
    /// The constraints that keep the balls of a robot clear of obstacles and of each other: for each
    /// [margin](Scene::obstacle_margins) spheres by the squares of (A3), then all other obstacles; then for each margin
    /// the pairs of balls; or, if the robot has convex parts, all by these. Balls fixed to the base count for the pairs
    /// alone, because they never move. The balls are larger by the margins.
    #[must_use]
    pub fn of_scene(scene: &Scene) -> Vec<Self> {
        if scene.is_empty() {
            return Vec::new();
        }
        if !scene.robot().parts.is_empty() {
            return vec![Self::Convex(ConvexClearance::of_scene(scene))];
        }
        let larger = |by: f64| {
            let all = scene.robot().balls.iter();
            all.map(move |ball| CollisionSphere { radius: ball.radius + by, ..*ball })
        };
        let mut constraints = Vec::new();
        for margin in distinct(scene.obstacle_margins()) {
            let balls: Vec<_> = larger(margin).filter(|b| b.body.is_some()).collect();
            let (mut spheres, mut solids, mut names) = (Vec::new(), Vec::new(), Vec::new());
            let of_margin = scene.obstacles().iter().zip(scene.obstacle_margins());
            for (Obstacle { name, solid }, _) in of_margin.filter(|(_, own)| **own == margin) {
                if let Shape::Sphere { radius } = solid.shape {
                    let centre = solid.placement.translation;
                    spheres.push(Sphere { centre, radius });
                } else {
                    solids.push(*solid);
                    names.push(name.clone());
                }
            }
            if !spheres.is_empty() {
                let balls = balls.clone();
                constraints.push(Self::Spheres(SphereClearance { balls, spheres }));
            }
            if !solids.is_empty() {
                constraints.push(Self::Solids(SolidClearance { balls, solids, names }));
            }
        }
        for margin in distinct(scene.pair_margins()) {
            let pairs = scene.pairs_with_margin(margin);
            if !pairs.is_empty() {
                constraints.push(Self::SelfCollision(SelfClearance { balls: larger(0.5 * margin).collect(), pairs }));
            }
        }
        constraints
    }
}

/// The different numbers in a list, in the order of the first ones.
pub(super) fn distinct(numbers: &[f64]) -> Vec<f64> {
    let mut all = Vec::new();
    for number in numbers {
        if !all.contains(number) {
            all.push(*number);
        }
    }
    all
}

impl<C: Scalar> Constraint<C> for AnyConstraint<C> {
    fn dim(&self) -> usize {
        each!(self, it => it.dim())
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        each!(self, it => it.value(at, g))
    }

    fn row_set(&self, row: usize) -> RowSet<C> {
        each!(self, it => it.row_set(row))
    }

    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        each!(self, it => it.label(row, model))
    }

    fn value_of<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        rows: Option<RowList<'_>>,
        g: &mut [S],
        active_pairs: Option<&mut Vec<ActivePair<S>>>,
    ) -> Result<()> {
        each!(self, it => it.value_of(at, rows, g, active_pairs))
    }

    fn parts<'a>(&'a self, parts: &mut Vec<&'a Self>) -> bool {
        parts.push(self);
        !matches!(self, Self::Other(_))
    }

    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        each!(self, it => it.add_weighted_derivatives(at, weights, out))
    }
}
