//! The constrained flow (A4) and its Jacobian.

use super::jacobian::{ControlFormJacobian, NodeBlocks, NodeJacobian};
use super::raise::Raise;
use super::{
    ActuationWeights, ControlCost, ControlForm, ControlLagrangian, Node, Penalty, RightHandSide, TorquePenalty,
};
use crate::constraint::{Constraint, Constraints, Evaluator, Weights};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar, Tanh};
use nalgebra::DMatrix;

/// The penalties of the rows of [`Constraints`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PenaltyWeights<C: Scalar = f64> {
    /// The penalty of each row in the state.
    pub state: Penalty<C>,
    /// The penalty of each limit on the control, and of each row of a standing foot.
    pub torque: Penalty<C>,
}

/// The constraints of a motion as penalties in its Lagrangian, (A1).
#[derive(Clone, Debug)]
pub struct Penalised<K, C: Scalar = f64> {
    /// The constraints.
    pub constraints: Constraints<K, C>,
    /// Their penalties.
    pub weights: PenaltyWeights<C>,
}

/// The flow (A4) of the control form.
pub type Constrained<'a, C, S, K> = Sum<ControlForm<'a, C, S, TorquePenalty<C>>, StatePenalty<'a, C, S, K>, S>;

/// The flow (A4) of a [`ControlLagrangian`] with the cost `L`.
pub type GeneralConstrained<'a, C, S, L, K> =
    Sum<ControlForm<'a, C, S, (L, TorquePenalty<C>)>, StatePenalty<'a, C, S, K>, S>;

impl<K, C: Scalar> Penalised<K, C>
where
    K: Constraint<C>,
{
    /// The right-hand side of the constrained flow for `model`.
    #[must_use]
    pub fn right_hand_side<'a, S: AlgebraOver<C> + Tanh>(
        &'a self,
        model: &'a Model<C>,
    ) -> Constrained<'a, C, S, &'a K> {
        Sum::new(ControlForm::with_cost(model, self.torque_penalty()), self.state_penalty(model))
    }

    /// The right-hand side of the flow of `lagrangian` for `model` with the constraints as penalties, in the metric of
    /// `lagrangian`.
    #[must_use]
    pub fn right_hand_side_of<'a, S: AlgebraOver<C> + Tanh, L: ControlCost<C>>(
        &'a self,
        model: &'a Model<C>,
        lagrangian: ControlLagrangian<C, L>,
    ) -> GeneralConstrained<'a, C, S, L, &'a K> {
        let weights = lagrangian.weights.clone();
        Sum::new(
            ControlForm::of(model, lagrangian.and_cost(self.torque_penalty())),
            self.state_penalty(model).weighted(weights),
        )
    }

    /// The analytic Jacobian of [`right_hand_side_of`](Self::right_hand_side_of).
    #[must_use]
    pub fn jacobian_of<'a, S: AlgebraOver<C> + Tanh, L: ControlCost<C> + 'a>(
        &'a self,
        model: &'a Model<C>,
        lagrangian: ControlLagrangian<C, L>,
    ) -> impl NodeJacobian<C, S> + use<'a, K, C, S, L> {
        let weights = lagrangian.weights.clone();
        Sum::new(
            ControlFormJacobian::of(model, lagrangian.and_cost(self.torque_penalty())),
            self.state_penalty(model).weighted(weights),
        )
    }

    /// Refuses equalities in the state, which a penalty would treat as inequalities, and rows beside those of state,
    /// torque and a standing foot.
    pub(super) fn refuse_equalities(&self, model: &Model<C>) -> Result<()> {
        let stage = &self.constraints.stage;
        stage.refuse_in_a_flow(model.name(), stage.phases.is_empty())?;
        let state = &self.constraints.state;
        match (0..state.dim()).find(|row| state.row_set(*row).is_equality) {
            None => Ok(()),
            Some(row) => {
                let name = state.label(row, model).name;
                let condition = "it is an equality, the flow has penalties for inequalities only";
                Err(Error::input(model.name(), name, condition))
            }
        }
    }

    /// The limits on the control as a cost of the control.
    #[must_use]
    pub fn torque_penalty(&self) -> TorquePenalty<C> {
        TorquePenalty { limits: self.constraints.torque.clone(), penalty: self.weights.torque }
    }

    /// The terms of the constraints on the state in the flow for `model` and in its Jacobian; they can be added to any
    /// form of the flow.
    #[must_use]
    pub fn state_penalty<'a, S: AlgebraOver<C> + Tanh>(&'a self, model: &'a Model<C>) -> StatePenalty<'a, C, S, &'a K> {
        StatePenalty::new(model, &self.constraints.state, self.weights.state)
    }

    /// Adds the terms of all constraints to an analytic Jacobian of the flow of the paper's Lagrangian: those of the
    /// control, then those of the state. `paper` must be without constraints.
    #[must_use]
    pub fn with_penalties<'a, P: NodeJacobian<C, S> + 'a, S: AlgebraOver<C> + Tanh>(
        &'a self,
        model: &'a Model<C>,
        paper: P,
    ) -> impl NodeJacobian<C, S> + 'a {
        let of_torque = ControlFormJacobian::of_cost(model, self.torque_penalty());
        Sum::new(Sum::new(paper, of_torque), self.state_penalty(model))
    }
}

/// The terms of penalties on the state in the flow, (A4), and in its Jacobian:
///
/// $$ -G^{-1} \sum_j \frac{\partial b(g_j(x))}{\partial x} = -\begin{bmatrix} \tfrac1k\\, \gamma_{P1} \\\\
///    (H H)^{-1} \gamma_{P2} \end{bmatrix}, \qquad \gamma = \sum_j b^{\prime}(g_j) \frac{\partial g_j}{\partial x} . $$
///
/// The derivative in `x` contains
///
/// $$ \frac{\partial \gamma}{\partial x} = \sum_j b^{\prime}(g_j) \frac{\partial^2 g_j}{\partial x^2} +
///    b^{\prime\prime}(g_j)
///    \frac{\partial g_j}{\partial x} \frac{\partial g_j}{\partial x}^T . $$
///
/// Cost: that of the constraints, and O(N^3) for the factors of `H`.
#[derive(Clone, Debug)]
pub struct StatePenalty<'m, C: Scalar, S: Scalar, K> {
    model: &'m Model<C>,
    constraints: K,
    penalty: Penalty<C>,
    evaluator: Evaluator<'m, C, S>,
    g: Vec<S>,
    slopes: Vec<S>,
    curvatures: Vec<S>,
    raise: Raise<'m, C, S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C> + Tanh, K: Constraint<C>> StatePenalty<'m, C, S, K> {
    /// The terms for `model`, with the same penalty for each row.
    #[must_use]
    pub fn new(model: &'m Model<C>, constraints: K, penalty: Penalty<C>) -> Self {
        let zeros = vec![S::zero(); constraints.dim()];
        Self {
            model,
            constraints,
            penalty,
            evaluator: Evaluator::new(model),
            g: zeros.clone(),
            slopes: zeros.clone(),
            curvatures: zeros,
            raise: Raise::new(model, ActuationWeights::ones()),
        }
    }

    /// The same terms in the metric $\mathrm{blockdiag}(k I, H W H)$ with the weights of the actuation.
    #[must_use]
    pub fn weighted(self, weights: ActuationWeights<C>) -> Self {
        let raise = Raise::new(self.model, weights);
        Self { raise, ..self }
    }
}

impl<C: Scalar, S: AlgebraOver<C> + Tanh, K: Constraint<C>> RightHandSide<C, S> for StatePenalty<'_, C, S, K> {
    fn omega(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()> {
        let n = self.model.dof();
        node.check(n, omega.len())?;
        let mut here = self.evaluator.at(node.x)?;
        here.value(&self.constraints, &mut self.g)?;
        for (g, slope) in self.g.iter().zip(&mut self.slopes) {
            *slope = -self.penalty.derivatives(*g)[1];
        }
        let weights = Weights { first_order: &self.slopes, gauss_newton: None };
        let by_x = here.weighted_derivatives(&self.constraints, weights)?.gradient();
        omega.copy_from_slice(by_x.as_slice());
        self.raise.apply(node.x_p1(), k, omega)
    }
}

impl<C: Scalar, S: AlgebraOver<C> + Tanh, K: Constraint<C>> NodeJacobian<C, S> for StatePenalty<'_, C, S, K> {
    fn evaluate(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()> {
        let n = self.model.dof();
        out.check(n)?;
        node.check(n, 2 * n)?;
        let mut here = self.evaluator.at(node.x)?;
        here.value(&self.constraints, &mut self.g)?;
        let weights = self.slopes.iter_mut().zip(&mut self.curvatures);
        for (g, (slope, curvature)) in self.g.iter().zip(weights) {
            let [_, first, second, _] = self.penalty.derivatives(*g);
            (*slope, *curvature) = (-first, -second);
        }
        let weights = Weights { first_order: &self.slopes, gauss_newton: Some(&self.curvatures) };
        let sums = here.weighted_derivatives(&self.constraints, weights)?;
        out.dx.copy_from(sums.hessian());
        out.dxdot.fill(S::zero());
        out.dxddot.fill(S::zero());
        self.raise.differentiate(node.x_p1(), k, sums.gradient(), &mut out.dx)
    }
}

/// The sum or the difference of two right-hand sides, or of two Jacobians, such as a flow and a term of its Lagrangian.
#[derive(Clone, Debug)]
pub struct Sum<A, B, S: Scalar> {
    first: A,
    second: B,
    /// The factor of `second`, plus or minus one.
    sign: S,
    omega: Vec<S>,
    blocks: NodeBlocks<S>,
}

impl<A, B, S: Scalar> Sum<A, B, S> {
    /// `first + second`.
    #[must_use]
    pub fn new(first: A, second: B) -> Self {
        Self { first, second, sign: S::one(), omega: Vec::new(), blocks: NodeBlocks::new(0) }
    }

    /// `first - second`.
    #[must_use]
    pub fn difference(first: A, second: B) -> Self {
        Self { sign: -S::one(), ..Self::new(first, second) }
    }
}

impl<C, S: Scalar, A, B> RightHandSide<C, S> for Sum<A, B, S>
where
    C: Scalar,
    A: RightHandSide<C, S>,
    B: RightHandSide<C, S>,
{
    fn omega(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()> {
        self.first.omega(node, k, omega)?;
        self.omega.resize(omega.len(), S::zero());
        self.second.omega(node, k, &mut self.omega)?;
        omega.iter_mut().zip(&self.omega).for_each(|(a, b)| *a += self.sign * *b);
        Ok(())
    }
}

impl<C, S: Scalar, A, B> NodeJacobian<C, S> for Sum<A, B, S>
where
    C: Scalar,
    A: NodeJacobian<C, S>,
    B: NodeJacobian<C, S>,
{
    fn evaluate(&mut self, node: Node<'_, S>, k: C, out: &mut NodeBlocks<S>) -> Result<()> {
        self.first.evaluate(node, k, out)?;
        if self.blocks.check(out.dx.nrows() / 2).is_err() {
            self.blocks = NodeBlocks::new(out.dx.nrows() / 2);
        }
        self.second.evaluate(node, k, &mut self.blocks)?;
        let sum = |out: &mut DMatrix<S>, term: &DMatrix<S>| {
            out.zip_apply(term, |out, term| *out += self.sign * term);
        };
        sum(&mut out.dx, &self.blocks.dx);
        sum(&mut out.dxdot, &self.blocks.dxdot);
        sum(&mut out.dxddot, &self.blocks.dxddot);
        Ok(())
    }
}
