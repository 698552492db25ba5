//! The right-hand side of the Affine Geometric Heat Flow and its Jacobian.
//!
//! A state is $x = [x_{P1}; x_{P2}] = [q; v]$, `2 N` entries. The input of the flow at one time of a curve, `t`, `x`,
//! `xdot` and `xddot`, is a [`Node`]; along the flow, `xdot_P1` differs from `x_P2`, at
//! its end by a slip of order $1/k$.

mod action;
mod actuation;
mod collocation;
mod constrained;
mod control_penalty;
mod dual_trajectory;
mod foot_penalty;
pub mod jacobian;
mod lagrangian;
mod lagrangian_flow;
mod metric;
mod node;
mod omega;
mod penalty;
mod raise;
pub mod rest;
mod run;
mod settings;
mod state_cost;
pub mod weak;

pub use action::{EffortSummary, effort_of};
pub use actuation::ActuationWeights;
pub use collocation::{Collocation, assemble_jacobian};
pub use constrained::{Constrained, GeneralConstrained, Penalised, PenaltyWeights, StatePenalty, Sum};
pub use control_penalty::{ControlCost, ControlDual, TorquePenalty};
pub use dual_trajectory::DualTrajectory;
pub use foot_penalty::FootPenalty;
pub use lagrangian::{AghfLagrangian, ControlLagrangian, Lagrangian, lagrangian, lagrangian_of_control};
pub use lagrangian_flow::LagrangianFlow;
pub use metric::{ActuationMetric, AffineLagrangian, Drift, FreeDynamics, Metric};
pub use node::Node;
pub use omega::{AlgorithmB1, ControlForm, TheoremB3};
pub use penalty::{
    Penalty, activation, activation_slope, constrained_lagrangian, penalty, penalty_curvature, penalty_slope,
};
pub use run::{Flow, FlowRecord, FlowSolution, output_count};
pub use settings::FlowSettings;
pub use state_cost::{StateCost, StateCostTerm, WithStateCost};

use crate::error::Result;

/// A method of computing $\Omega(t, x, \dot x, \ddot x, k)$, the right-hand side of the flow (15), over the scalar `S`
/// for a model with constants `C`.
pub trait RightHandSide<C = f64, S = C> {
    /// Computes $\Omega$ at `node` with penalty `k`, `2 N` entries, into `omega`.
    ///
    /// # Errors
    /// A slice of `node`, or `omega`, does not have `2 N` entries.
    fn omega(&mut self, node: Node<'_, S>, k: C, omega: &mut [S]) -> Result<()>;
}
