//! Curves, integrators, the right-hand side of the flow, its Jacobians and its runs.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod any_to_rest;
mod constrained_flow;
mod constrained_run;
mod curve;
mod dual_trajectory;
mod extension;
mod general_flow;
mod integrate;
mod integrate_failures;
mod jacobian;
mod rest;
mod rest_settings;
mod right_hand_side;
mod row_terms;
mod run;
mod theorem_b4;
mod weak;
