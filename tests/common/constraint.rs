//! Constraints of the tests.

use aghf::constraint::{AnyConstraint, Constraint, ConvexClearance, PlacedState, Quantity, RowLabel, RowSet};
use aghf::geometry::{CollisionGeometry, Convex, Obstacle, Scene, Shape, Solid};
use aghf::model::Model;
use aghf::scalar::AlgebraOver;
use aghf::spatial::Placement;
use nalgebra::{Rotation3, Vector3};

/// The equality $x_0 = c$, with a name of its own.
#[derive(Clone, Debug)]
pub struct Held(pub f64);

impl Constraint for Held {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> aghf::Result<()> {
        g[0] = at.x[0] - S::from_f64(self.0);
        Ok(())
    }

    fn label(&self, row: usize, model: &Model) -> RowLabel {
        let name = format!("row {row} of {}", model.name());
        RowLabel { joint: Some(0), ..RowLabel::new(name, "rad", Quantity::Position) }
    }

    fn row_set(&self, _: usize) -> RowSet {
        RowSet::zero()
    }
}

/// The inequality $\sum_i v_i^2 \le c$, with a scale of its own.
#[derive(Clone, Debug)]
pub struct Slow(pub f64);

impl Constraint for Slow {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> aghf::Result<()> {
        g[0] = (at.v().iter()).fold(S::zero(), |sum, v| sum + *v * *v) - S::lift(self.0);
        Ok(())
    }

    fn row_set(&self, _: usize) -> RowSet {
        RowSet::at_most_zero().scaled(2.0 * self.0.sqrt())
    }
}

/// An arm with a hull of nine points, a cylinder or a capsule on each body, which keep clear of solids and of each
/// other.
pub fn in_bodies(model: &Model, solids: Vec<Solid>) -> ConvexClearance {
    let mut robot = CollisionGeometry::default();
    for body in 0..model.dof() {
        let corner = |k: usize| 0.06 * Vector3::new(k as f64, 2.3 * k as f64, 4.1 * k as f64).map(f64::sin);
        let placement = Placement::new(Rotation3::new(corner(body) * 20.0).into_inner(), corner(body + 2));
        let solid = |shape| Convex::of_solid(&Solid { placement, shape }).expect("it has ends");
        let part = match body % 3 {
            0 => Convex::of_corners((9 * body..9 * body + 9).map(corner).collect(), 0.01),
            1 => solid(Shape::Cylinder { radius: 0.04, half_length: 0.06 }),
            _ => solid(Shape::Capsule { radius: 0.04, half_length: 0.05 }),
        };
        robot.add(&format!("link {body}"), Some(body), part);
    }
    let obstacle = |(i, solid): (usize, Solid)| Obstacle { name: format!("solid {i}"), solid };
    let obstacles = solids.into_iter().enumerate().map(obstacle).collect();
    let neighbours = (1..model.dof()).flat_map(|i| [[i - 1, i], [i.saturating_sub(2), i]]);
    let neighbours: Vec<_> = neighbours.map(|pair| pair.map(|i| format!("link {i}"))).collect();
    let scene = Scene::new(robot, obstacles, Some(&neighbours)).with_margins(|_| 0.02, |_| 0.01);
    match AnyConstraint::of_scene(&scene).pop() {
        Some(AnyConstraint::Convex(rows)) => rows,
        other => panic!("{other:?}"),
    }
}
