//! The flow in its weak form: tested with the functions of a basis, in its own metric.
//!
//! For a curve $x(t) = \sum_m c_m \varphi_m(t)$ in the state $x = [q; v]$ and any Lagrangian, testing
//! $G\\, \partial x / \partial s = \frac{d}{dt} L_{\dot x} - L_x$ with each function and integrating by parts leaves
//!
//! $$ \sum_n \left( \int \varphi_m \varphi_n\\, G\\, dt \right) \frac{d c_n}{d s} = -\frac{\partial A}{\partial c_m}, \qquad
//!    A = \int L(t, x, \dot x)\\, dt . $$
//!
//! Nothing but $L$ and its derivatives in $(x, \dot x)$ is needed, not $\ddot x$, so the curve may be made of several polynomials that meet
//! continuously; what the control does where they meet is what makes the action least.
//!
//! [`StateGrid`] has the functions, [`PointLagrangian`] the Lagrangian at the points of the quadrature and [`Action`] the sums. The flow is
//! followed by [`rest`](super::rest).

mod action;
mod analytic;
mod augmented;
mod dual;
mod grid;
mod lagrangian;
mod row_terms;

pub use action::{Action, ActionDerivatives};
pub use analytic::{AnalyticLagrangian, ControlPoint};
pub use augmented::AugmentedLagrangian;
pub use dual::DualLagrangian;
pub use grid::StateGrid;
pub use lagrangian::{LagrangianDerivatives, PointLagrangian, StatePoints};
pub(in crate::flow) use row_terms::{RowDuals, RowTerms};
