//! Curves, integrators, motions, the right-hand side of the flow, its Jacobians and its runs.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod collocation;
mod constrained;
mod constrained_run;
mod dual_trajectory;
mod foot_penalty;
mod jacobian;
mod lagrangian_flow;
mod omega;
mod rest;
mod run;
mod weak;

#[path = "../curve"]
mod curve {
    mod bracket;
    mod chebyshev;
    mod hermite;
    mod legendre;
    mod piecewise;
}

#[path = "../motion"]
mod motion {
    mod problem;
    mod simulate;
    mod violations;
}

#[path = "../ode"]
mod ode {
    mod adapter;
    mod failures;
}
