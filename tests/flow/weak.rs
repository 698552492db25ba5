//! The weak form of the flow: Lagrangians and metrics at the points of a quadrature.

mod dual;
mod norm;
mod slip;
