//! Reference values: the dynamics, Theorem B3, the quantities that Theorem B4 differentiates, and $\Omega$ by its
//! definition, from the plain dynamics and dual numbers alone.
//!
//! No analytic derivative and no tensor of the library is used here: only `crba`, `rnea`, `bias`, `aba`, the Lagrangian
//! by its definition, and differentiation by dual numbers. The code is generic. Each number type determines its dual
//! numbers: over `f64` those of `num-dual`, over the prime field [`Jet`](crate::scalar::Jet). The two witnesses that
//! use it therefore differ in their numbers, not in a copy of the formulas.

mod differentiation;
mod flow;

pub use differentiation::{
    Differentiable, DifferentiableOver, DualNumber, SecondDual, constant, dual, entries, gradient, jacobian, rate,
    unit, vector,
};
pub use flow::{
    At, Variation, alpha_1, alpha_2, bias_force, bias_rate, capital_gamma, f_d, fd_0, gamma, gradient_and_rate,
    inverse_dynamics, mass, mass_rate, omega_by_definition, omega_by_theorem_b3, omega_terms, theorem_b3, variation,
    variation_of_effort,
};
