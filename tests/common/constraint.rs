//! Constraints of the tests.

use aghf::constraint::{Constraint, PlacedState, RowKind, RowLabel};
use aghf::model::Model;
use aghf::scalar::AlgebraOver;

/// The equality $x_0 = c$, with a name of its own.
#[derive(Clone, Debug)]
pub struct Held(pub f64);

impl Constraint for Held {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<f64>>(
        &self,
        at: &PlacedState<'_, f64, S>,
        g: &mut [S],
    ) -> aghf::Result<()> {
        g[0] = at.x[0] - S::from_f64(self.0);
        Ok(())
    }

    fn label(&self, row: usize, model: &Model) -> RowLabel {
        RowLabel {
            name: format!("row {row} of {}", model.name()),
            unit: "rad",
            kind: RowKind::Position(0),
        }
    }

    fn is_equality(&self, _: usize) -> bool {
        true
    }
}

/// The inequality $\sum_i v_i^2 \le c$, with a scale of its own.
#[derive(Clone, Debug)]
pub struct Slow(pub f64);

impl Constraint for Slow {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<f64>>(
        &self,
        at: &PlacedState<'_, f64, S>,
        g: &mut [S],
    ) -> aghf::Result<()> {
        g[0] = (at.v().iter()).fold(S::zero(), |sum, v| sum + *v * *v) - S::lift(self.0);
        Ok(())
    }

    fn row_scales(&self, scales: &mut [f64]) {
        scales.fill(2.0 * self.0.sqrt());
    }
}
