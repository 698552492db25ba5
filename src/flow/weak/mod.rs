//! The weak form of the flow.
mod action;
mod augmented;
mod control;
mod grid;
mod lagrangian;
mod row_terms;

pub use action::{Action, ActionDerivatives};
pub use augmented::AugmentedLagrangian;
pub use control::{ControlLagrangian, ControlPoint};
pub use grid::StateGrid;
pub use lagrangian::{LagrangianDerivatives, PointLagrangian, StatePoints};
