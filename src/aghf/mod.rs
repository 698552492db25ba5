//! The right-hand side of the Affine Geometric Heat Flow and its Jacobian.
//!
//! A state is $x = [x_{P1}; x_{P2}] = [q; v]$, `2 N` entries. At one time of a curve the flow reads `x`, `xdot` and
//! `xddot`, together a [`Node`]; off the solution `xdot_P1` differs from `x_P2`.

mod algorithm_b1;
pub mod check;
mod constrained;
pub mod constraint;
mod control_cost;
mod control_form;
mod definition;
pub mod guide;
pub mod jacobian;
mod lagrangian;
mod node;
mod theorem_b3;

pub use algorithm_b1::AlgorithmB1;
pub use constrained::{Constrained, Penalised, StatePenalty, Sum};
pub use constraint::{
    activation, activation_slope, constrained_lagrangian, penalty, penalty_curvature, penalty_slope,
};
pub use control_cost::{ControlCost, TorqueLimits, TorquePenalty};
pub use control_form::ControlForm;
pub use definition::{ControlEffort, Definition, Lagrangian};
pub use lagrangian::{lagrangian, lagrangian_of_control};
pub use node::Node;
pub use theorem_b3::TheoremB3;

use crate::error::Result;

/// A way to compute $\Omega(x, \dot x, \ddot x, k)$, the right-hand side of the flow (15), over the scalar `S` for a
/// model with constants `C`.
pub trait RightHandSide<C, S> {
    /// $\Omega$ at `node` with penalty `k`, `2 N` entries, into `omega`.
    ///
    /// # Errors
    /// `node` or `omega` does not have `2 N` entries throughout.
    fn omega(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()>;
}
