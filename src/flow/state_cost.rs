//! A running cost of the time and the state as a term of the Lagrangian.

use super::jacobian::{NodeBlocks, NodeJacobian};
use super::raise::Raise;
use super::{ActuationWeights, Lagrangian, Node, RightHandSide};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Jet, Scalar, Tanh};
use nalgebra::DVector;

/// A running cost $\psi(t, x)$ as a term of a Lagrangian.
pub trait StateCost<C: Scalar = f64> {
    /// Computes $\psi$ at the time `t`, in s, and the state `x`, `2 N` entries.
    ///
    /// # Errors
    /// `x` does not have `2 N` entries, or the cost has another number of joints.
    fn value<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S]) -> Result<S>;
}

impl<C: Scalar, K: StateCost<C>> StateCost<C> for &K {
    fn value<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S]) -> Result<S> {
        (**self).value(model, t, x)
    }
}

/// The Lagrangian $L + \psi(t, x)$.
#[derive(Clone, Copy, Debug)]
pub struct WithStateCost<L, K> {
    /// The Lagrangian $L$.
    pub lagrangian: L,
    /// The cost $\psi$.
    pub cost: K,
}

impl<C: Scalar, L: Lagrangian<C>, K: StateCost<C>> Lagrangian<C> for WithStateCost<L, K> {
    fn value<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, t: S, x: &[S], xdot: &[S], k: C) -> Result<S> {
        Ok(self.lagrangian.value(model, t, x, xdot, k)? + self.cost.value(model, t, x)?)
    }
}

/// The term $-G^{-1} \partial \psi / \partial x$ that a [`StateCost`] adds to the flow in the metric
/// $G = \mathrm{blockdiag}(k I, H W H)$, and its Jacobian.
///
/// Dual numbers give the gradient and the Hessian of $\psi$: `2 N` evaluations, and `N (2 N + 1)` for the Jacobian.
#[derive(Clone, Debug)]
pub struct StateCostTerm<'m, C: Scalar, S: Scalar, K> {
    model: &'m Model<C>,
    cost: K,
    raise: Raise<'m, C, S>,
    force: DVector<S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C> + Tanh, K: StateCost<C>> StateCostTerm<'m, C, S, K> {
    /// The term for `model` in the metric with these weights.
    #[must_use]
    pub fn new(model: &'m Model<C>, weights: ActuationWeights<C>, cost: K) -> Self {
        Self { model, cost, raise: Raise::new(model, weights), force: DVector::zeros(2 * model.dof()) }
    }

    /// Computes $-\partial \psi / \partial x$.
    fn push(&mut self, node: Node<'_, S>) -> Result<()> {
        for i in 0..node.x.len() {
            let moved: Vec<_> = (node.x.iter().enumerate()).map(|(j, x)| Jet::new(*x, [unit(i == j)])).collect();
            let psi = self.cost.value(self.model, Jet::<S, 1>::constant(node.t), &moved)?;
            self.force[i] = -psi.eps[0];
        }
        Ok(())
    }

    /// Computes $-\partial^2 \psi / \partial x_i \partial x_j$.
    fn curvature(&self, node: Node<'_, S>, i: usize, j: usize) -> Result<S> {
        let t = Jet::constant(Jet::<S, 1>::constant(node.t));
        let moved: Vec<_> = (node.x.iter().enumerate())
            .map(|(l, x)| {
                let inner = Jet::new(*x, [unit(i == l)]);
                Jet::new(inner, [Jet::constant(unit(j == l))])
            })
            .collect();
        let psi: Jet<Jet<S, 1>, 1> = self.cost.value(self.model, t, &moved)?;
        Ok(-psi.eps[0].eps[0])
    }
}

/// One or zero.
fn unit<S: Scalar>(one: bool) -> S {
    if one { S::one() } else { S::zero() }
}

impl<C: Scalar, S: AlgebraOver<C> + Tanh, K: StateCost<C>> RightHandSide<C, S> for StateCostTerm<'_, C, S, K> {
    fn omega(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()> {
        node.check(self.model.dof(), omega.len())?;
        self.push(node)?;
        omega.copy_from_slice(self.force.as_slice());
        self.raise.apply(node.x_p1(), k, omega)
    }
}

impl<C: Scalar, S: AlgebraOver<C> + Tanh, K: StateCost<C>> NodeJacobian<C, S> for StateCostTerm<'_, C, S, K> {
    fn evaluate(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()> {
        out.check(self.model.dof())?;
        node.check(self.model.dof(), out.dx.nrows())?;
        self.push(node)?;
        for i in 0..node.x.len() {
            for j in 0..=i {
                out.dx[(i, j)] = self.curvature(node, i, j)?;
                out.dx[(j, i)] = out.dx[(i, j)];
            }
        }
        out.dxdot.fill(S::zero());
        out.dxddot.fill(S::zero());
        self.raise.differentiate(node.x_p1(), k, &self.force, &mut out.dx)
    }
}
