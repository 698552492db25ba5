//! The flow of any Lagrangian in any metric from its definition, by dual numbers.

use super::lagrangian::Lagrangian;
use super::{ActuationMetric, Metric, Node, RightHandSide};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Jet, Scalar, Tanh};

/// The heat flow (7) of any [`Lagrangian`] in any [`Metric`], by default the paper's (11):
///
/// $$ \Omega =
///    G^{-1} \left( \frac{d}{dt} \frac{\partial L}{\partial \dot x} - \frac{\partial L}{\partial x} \right), \quad
///    \frac{d}{dt} = \frac{\partial}{\partial t} + \dot x^T \frac{\partial}{\partial x} +
///    \ddot x^T \frac{\partial}{\partial \dot x} . $$
///
/// Second derivatives of `L` come from nested dual numbers with `4 N` evaluations: slow and allocating, but correct for
/// any `L`. [`ForwardDual::of`](super::jacobian::ForwardDual::of) computes its Jacobian.
#[derive(Clone, Debug)]
pub struct LagrangianFlow<'m, L, C: Scalar = f64, M = ActuationMetric<C>> {
    model: &'m Model<C>,
    lagrangian: L,
    metric: M,
}

impl<'m, C: Scalar, L: Lagrangian<C>> LagrangianFlow<'m, L, C> {
    /// The flow of `lagrangian` for `model` in the metric of the paper.
    #[must_use]
    pub fn new(model: &'m Model<C>, lagrangian: L) -> Self {
        Self::in_metric(model, lagrangian, ActuationMetric::default())
    }
}

impl<'m, C: Scalar, L: Lagrangian<C>, M: Metric<C>> LagrangianFlow<'m, L, C, M> {
    /// The flow of `lagrangian` for `model` in `metric`.
    #[must_use]
    pub fn in_metric(model: &'m Model<C>, lagrangian: L, metric: M) -> Self {
        Self { model, lagrangian, metric }
    }

    /// Evaluates `L` with a rate along time and the curve in the inner tangent and along one coordinate of `[x; xdot]`
    /// in the outer one.
    fn along<S: AlgebraOver<C> + Tanh>(&self, node: Node<'_, S>, coordinate: usize, k: C) -> Result<Jet<Jet<S, 1>, 1>> {
        let m = node.x.len();
        let moving = |x: &[S], rate: &[S], first: usize| -> Vec<Jet<Jet<S, 1>, 1>> {
            let jet = |(i, (x, rate)): (usize, (&S, &S))| {
                let along = if first + i == coordinate { S::one() } else { S::zero() };
                Jet::new(Jet::new(*x, [*rate]), [Jet::constant(along)])
            };
            x.iter().zip(rate).enumerate().map(jet).collect()
        };
        let t = Jet::constant(Jet::new(node.t, [S::one()]));
        let x = moving(node.x, node.xdot, 0);
        let xdot = moving(node.xdot, node.xddot, m);
        self.lagrangian.value(self.model, t, &x, &xdot, k)
    }
}

impl<C: Scalar, S: AlgebraOver<C> + Tanh, L: Lagrangian<C>, M: Metric<C>> RightHandSide<C, S>
    for LagrangianFlow<'_, L, C, M>
{
    fn omega(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()> {
        let n = self.model.dof();
        node.check(n, omega.len())?;
        for i in 0..2 * n {
            let momentum_rate = self.along(node, 2 * n + i, k)?.eps[0].eps[0];
            let gradient = self.along(node, i, k)?.eps[0].re;
            omega[i] = momentum_rate - gradient;
        }
        self.metric.raise(self.model, node.t, node.x, k, omega)
    }
}
