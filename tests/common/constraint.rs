//! Constraints of the tests.

use aghf::constraint::{CollisionSphere, Constraint, CoverClearance, PlacedState, Quantity, RowLabel, RowSet};
use aghf::geometry::{BallTree, Solid};
use aghf::model::Model;
use aghf::scalar::AlgebraOver;
use nalgebra::Vector3;

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

/// An arm with nine balls in three sets on each body, which keeps clear of solids.
pub fn in_balls(model: &Model, solids: Vec<Solid>) -> CoverClearance {
    let ball = |k: usize| CollisionSphere {
        body: Some(k / 9),
        centre: 0.05 * Vector3::new(k as f64, 2.3 * k as f64, 4.1 * k as f64).map(f64::sin),
        radius: 0.03,
    };
    let balls: Vec<_> = (0..9 * model.dof()).map(ball).collect();
    let tree = |body: usize| BallTree::new(&balls, (9 * body..9 * body + 9).collect());
    let of = |link: usize| (0..solids.len()).map(move |solid| [link, solid]);
    CoverClearance {
        links: (0..model.dof()).map(tree).collect(),
        counts: vec![3; model.dof()],
        sets: (0..balls.len()).map(|k| k % 3).collect(),
        names: Vec::new(),
        solid_pairs: (0..model.dof()).flat_map(of).collect(),
        pairs: (3..model.dof()).flat_map(|j| (0..j - 2).map(move |i| [i, j])).collect(),
        margins: [0.0; 2],
        far: 0.1,
        solids,
    }
}
