//! Any Lagrangian at quadrature points, by dual numbers.

use crate::cost::{Point, PointCost, PointDerivatives};
use crate::error::{Result, check_length};
use crate::flow::Lagrangian;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Jet, Scalar, Tanh};

/// The number of entries of $[x; \dot x]$ in which one evaluation differentiates, apart from one more.
const WIDTH: usize = 4;
/// A number with a tangent along one entry, and along several more.
type Moving<S> = Jet<Jet<S, WIDTH>, 1>;

/// Any [`Lagrangian`] as a cost of a curve in the state. Gradient and Hessian come from nested dual numbers,
/// `2 N (N + 1)` evaluations per point: slow, but correct for any `L`. It has no metric of its own; see
/// [`Norm`](super::Norm).
#[derive(Clone, Debug)]
pub struct DualLagrangian<'m, L, C: Scalar = f64> {
    model: &'m Model<C>,
    lagrangian: L,
    k: C,
}

impl<'m, C: Scalar, L: Lagrangian<C>> DualLagrangian<'m, L, C> {
    /// The Lagrangian `lagrangian` for `model` under the penalty `k`.
    #[must_use]
    pub fn new(model: &'m Model<C>, lagrangian: L, k: C) -> Self {
        Self { model, lagrangian, k }
    }
}

impl<C: Scalar, L: Lagrangian<C>, S: AlgebraOver<C> + Tanh> PointCost<S> for DualLagrangian<'_, L, C> {
    fn value(&mut self, point: Point<'_, S>) -> Result<S> {
        let (x, xdot) = (point.q, point.v);
        check_length("states", 2 * self.model.dof(), x.len())?;
        self.lagrangian.value(self.model, point.time, x, xdot, self.k)
    }

    fn derivatives(&mut self, point: Point<'_, S>, out: &mut PointDerivatives<S>) -> Result<S> {
        let (x, size) = (point.q, 2 * self.model.dof());
        check_length("states", size, x.len())?;
        out.gradient.fill(S::zero());
        out.hessian.fill(S::zero());
        out.metric.fill(S::zero());
        let t = Jet::constant(Jet::constant(point.time));
        let mut value = S::zero();
        for row in 0..2 * size {
            for first in (0..=row).step_by(WIDTH) {
                let moving: Vec<Moving<S>> = x
                    .iter()
                    .chain(point.v)
                    .enumerate()
                    .map(|(i, y)| {
                        let several = std::array::from_fn(|lane| unit(first + lane == i));
                        Jet::new(Jet::new(*y, several), [Jet::constant(unit(row == i))])
                    })
                    .collect();
                let (x, xdot) = moving.split_at(size);
                let l = self.lagrangian.value(self.model, t, x, xdot, self.k)?;
                value = l.re.re;
                let [slope] = l.eps;
                out.gradient[row] = slope.re;
                for (column, second) in (first..=row).zip(slope.eps) {
                    out.hessian[(row, column)] = second;
                    out.hessian[(column, row)] = second;
                }
            }
        }
        Ok(value)
    }
}

/// One or zero.
fn unit<S: Scalar>(one: bool) -> S {
    if one { S::one() } else { S::zero() }
}
