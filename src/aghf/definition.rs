//! The flow of any Lagrangian straight from its definition, by dual numbers.

use super::{Node, RightHandSide};
use crate::dynamics::{Data, crba, rnea};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{Jet, Ldlt, Over};
use nalgebra::DMatrix;

/// A function $L(x, \dot x)$ whose integral over time a flow makes smaller.
///
/// It is written once for every scalar; nothing else is asked for, since derivatives come from dual numbers. A page of
/// the [guide](super::guide::your_own_lagrangian) walks through an example.
pub trait Lagrangian {
    /// $L$ at `x` and `xdot`, `2 N` entries each, under the penalty `k`.
    ///
    /// # Errors
    /// The lengths are not those of the robot.
    fn value<S: Over<f64>>(&self, model: &Model, x: &[S], xdot: &[S], k: f64) -> Result<S>;
}

/// The Lagrangian of the paper in its control form, $k\, |\dot x_{P1} - x_{P2}|^2 + |u|^2$.
#[derive(Clone, Copy, Debug, Default)]
pub struct ControlEffort;

impl Lagrangian for ControlEffort {
    fn value<S: Over<f64>>(&self, model: &Model, x: &[S], xdot: &[S], k: f64) -> Result<S> {
        let n = model.dof();
        let mut u = vec![S::zero(); n];
        let ((q, v), (qdot, vdot)) = (split(x), split(xdot));
        rnea(model, &mut Data::new(model), q, v, vdot, &mut u)?;
        super::lagrangian_of_control(qdot, v, &u, k)
    }
}

/// The two halves of a state.
fn split<S>(x: &[S]) -> (&[S], &[S]) {
    x.split_at(x.len() / 2)
}

/// The heat flow (7) of any [`Lagrangian`] in the metric (11):
///
/// $$ \Omega = G^{-1} \left( \frac{d}{dt} \frac{\partial L}{\partial \dot x} - \frac{\partial L}{\partial x} \right), \quad
///    G = \mathrm{blockdiag}(k I, H H). $$
///
/// Second derivatives of `L` come from nested dual numbers, `4 N` evaluations of it: slow, allocating, and right for
/// whatever `L` is. With [`ForwardDual::of`](super::jacobian::ForwardDual::of) around it the Jacobian is right as well.
#[derive(Clone, Debug)]
pub struct Definition<'m, L> {
    model: &'m Model,
    lagrangian: L,
}

impl<'m, L: Lagrangian> Definition<'m, L> {
    /// The flow of `lagrangian` for `model`.
    #[must_use]
    pub fn new(model: &'m Model, lagrangian: L) -> Self {
        Self { model, lagrangian }
    }

    /// `L`, moving with the curve in the inner tangent and along one coordinate of `[x; xdot]` in the outer one.
    fn along<S: Over<f64>>(
        &self,
        node: Node<'_, S>,
        coordinate: usize,
        k: f64,
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

impl<S: Over<f64>, L: Lagrangian> RightHandSide<f64, S> for Definition<'_, L> {
    fn omega(&mut self, node: Node<'_, S>, k: f64, omega: &mut [S]) -> Result<()> {
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
        p1.iter_mut().for_each(|o| *o = o.scale(1.0 / k));
        ldlt.solve(p2);
        ldlt.solve(p2);
        Ok(())
    }
}
