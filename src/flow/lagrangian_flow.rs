//! The flow of any Lagrangian straight from its definition, by dual numbers.

use super::lagrangian::Lagrangian;
use super::{Node, RightHandSide};
use crate::dynamics::{Data, crba};
use crate::error::Result;
use crate::linalg::Ldlt;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Jet, Scalar, Tanh};
use nalgebra::DMatrix;

/// The heat flow (7) of any [`Lagrangian`] in the metric (11):
///
/// $$ \Omega = G^{-1} \left( \frac{d}{dt} \frac{\partial L}{\partial \dot x} - \frac{\partial L}{\partial x} \right), \quad
///    G = \mathrm{blockdiag}(k I, H H). $$
///
/// Second derivatives of `L` come from nested dual numbers, `4 N` evaluations of it: slow, allocating, and right for
/// whatever `L` is. With [`ForwardDual::of`](super::jacobian::ForwardDual::of) around it the Jacobian is right as well.
#[derive(Clone, Debug)]
pub struct LagrangianFlow<'m, L, C: Scalar = f64> {
    model: &'m Model<C>,
    lagrangian: L,
}

impl<'m, C: Scalar, L: Lagrangian<C>> LagrangianFlow<'m, L, C> {
    /// The flow of `lagrangian` for `model`.
    #[must_use]
    pub fn new(model: &'m Model<C>, lagrangian: L) -> Self {
        Self { model, lagrangian }
    }

    /// `L`, moving with the curve in the inner tangent and along one coordinate of `[x; xdot]` in the outer one.
    fn along<S: AlgebraOver<C> + Tanh>(
        &self,
        node: Node<'_, S>,
        coordinate: usize,
        k: C,
    ) -> Result<Jet<Jet<S, 1>, 1>> {
        let m = node.x.len();
        let moving = |x: &[S], rate: &[S], first: usize| -> Vec<Jet<Jet<S, 1>, 1>> {
            let jet = |(i, (x, rate)): (usize, (&S, &S))| {
                let along = if first + i == coordinate {
                    S::one()
                } else {
                    S::zero()
                };
                Jet::new(Jet::new(*x, [*rate]), [Jet::constant(along)])
            };
            x.iter().zip(rate).enumerate().map(jet).collect()
        };
        let x = moving(node.x, node.xdot, 0);
        let xdot = moving(node.xdot, node.xddot, m);
        self.lagrangian.value(self.model, &x, &xdot, k)
    }
}

impl<C: Scalar, S: AlgebraOver<C> + Tanh, L: Lagrangian<C>> RightHandSide<C, S>
    for LagrangianFlow<'_, L, C>
{
    fn omega(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()> {
        let n = self.model.dof();
        node.check(n, omega.len())?;
        for i in 0..2 * n {
            let momentum_rate = self.along(node, 2 * n + i, k)?.eps[0].eps[0];
            let gradient = self.along(node, i, k)?.eps[0].re;
            omega[i] = momentum_rate - gradient;
        }
        let mut h = DMatrix::zeros(n, n);
        crba(self.model, &mut Data::new(self.model), node.x_p1(), &mut h)?;
        let mut ldlt = Ldlt::new(n);
        ldlt.factorise(&h);
        let (p1, p2) = omega.split_at_mut(n);
        let per_k = C::one() / k;
        p1.iter_mut().for_each(|o| *o = o.scale(per_k));
        ldlt.solve(p2);
        ldlt.solve(p2);
        Ok(())
    }
}
