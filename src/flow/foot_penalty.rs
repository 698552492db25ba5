//! The rows of a standing foot as penalties in the flow.

use super::jacobian::{CentralDifference, ForwardDual, JacobianKind, NodeJacobian};
use super::raise::Raise;
use super::{ActuationWeights, Node, Penalty, RightHandSide};
use crate::constraint::{FootDerivatives, FootWeights, StandingFoot};
use crate::dynamics::Data;
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar, Tanh};

/// The terms of penalties on the rows of a [`StandingFoot`] in the flow: with
/// $l(z) = \sum_j b(g_j(z))$, $z = [x_{P1}; x_{P2}; \dot x_{P2}]$, they are those of a Lagrangian,
///
/// $$ G^{-1} \left( \frac{d}{dt} \frac{\partial l}{\partial \dot x} - \frac{\partial l}{\partial x} \right) =
///    G^{-1} \begin{bmatrix} -l_q \\\\ l_{az}\\, \dot z - l_v \end{bmatrix}, \qquad
///    \dot z = [\dot x_{P1}; \dot x_{P2}; \ddot x_{P2}] , $$
///
/// with the second derivatives $l_{zz} = \sum_j b^{\prime} \nabla^2 g_j + b^{\prime\prime} \nabla g_j \nabla g_j^T$.
/// Their Jacobian contains third derivatives of the wrench of the root, which dual numbers compute.
///
/// Cost: O(N d) for the wrench with its derivatives, O(N^2) for their products, and O(N^3) for the factors of `H`.
#[derive(Clone, Debug)]
pub struct FootPenalty<'m, C: Scalar = f64, S: Scalar = C> {
    model: &'m Model<C>,
    foot: &'m StandingFoot<C>,
    penalty: Penalty<C>,
    data: Data<S>,
    g: Vec<S>,
    slopes: Vec<S>,
    curvatures: Vec<S>,
    derivatives: FootDerivatives<S>,
    raise: Raise<'m, C, S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C> + Tanh> FootPenalty<'m, C, S> {
    /// The terms for `model`, with the same penalty for each row.
    #[must_use]
    pub fn new(model: &'m Model<C>, foot: &'m StandingFoot<C>, penalty: Penalty<C>) -> Self {
        let zeros = vec![S::zero(); foot.dim()];
        Self {
            model,
            foot,
            penalty,
            data: Data::new(model),
            g: zeros.clone(),
            slopes: zeros.clone(),
            curvatures: zeros,
            derivatives: FootDerivatives::new(model.dof()),
            raise: Raise::new(model, ActuationWeights::ones()),
        }
    }
}

impl<C: Scalar, S: AlgebraOver<C> + Tanh> RightHandSide<C, S> for FootPenalty<'_, C, S> {
    fn omega(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()> {
        let n = self.model.dof();
        node.check(n, omega.len())?;
        let z = [node.x_p1(), node.x_p2(), node.xdot_p2()];
        self.foot.value(self.model, &mut self.data, z, &mut self.g)?;
        let weights = self.slopes.iter_mut().zip(&mut self.curvatures);
        for (g, (slope, curvature)) in self.g.iter().zip(weights) {
            let [_, first, second, _] = self.penalty.derivatives(*g);
            (*slope, *curvature) = (first, second);
        }
        let weights = FootWeights { slopes: &self.slopes, multipliers: &self.slopes, curvatures: &self.curvatures };
        let (data, by_z) = (&mut self.data, &mut self.derivatives);
        self.foot.weighted_derivatives(self.model, data, z, weights, by_z)?;
        let rates = [node.xdot_p1(), node.xdot_p2(), node.xddot_p2()];
        for (i, omega) in omega.iter_mut().enumerate() {
            *omega = -by_z.gradient[i];
            if i >= n {
                let row = by_z.hessian.row(n + i);
                let rates = rates.iter().copied().flatten();
                *omega += row.iter().zip(rates).fold(S::zero(), |sum, (l, rate)| sum + *l * *rate);
            }
        }
        self.raise.apply(node.x_p1(), k, omega)
    }
}

/// The Jacobian of the terms, by differences for that kind, and by dual numbers for all others.
pub(super) fn jacobian<'a>(
    kind: JacobianKind,
    model: &'a Model,
    (foot, penalty): (&'a StandingFoot, Penalty),
) -> Box<dyn NodeJacobian + 'a> {
    let n = model.dof();
    match kind {
        JacobianKind::Difference => {
            let terms = FootPenalty::<f64, f64>::new(model, foot, penalty);
            Box::new(CentralDifference::of(terms, n))
        }
        _ => Box::new(ForwardDual::of(FootPenalty::new(model, foot, penalty), n)),
    }
}
