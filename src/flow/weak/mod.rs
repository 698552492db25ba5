//! The weak form of the flow: tested with the functions of a basis, in its own metric.
//!
//! For a curve $x(t) = \sum_m c_m \varphi_m(t)$ in the state $x = [q; v]$ and any Lagrangian, testing
//! $G\\, \partial x / \partial s = \frac{d}{dt} L_{\dot x} - L_x$ with each function and integrating by parts gives
//!
//! $$ \sum_n \left( \int \varphi_m \varphi_n\\, G\\, dt \right) \frac{d c_n}{d s} = -\frac{\partial A}{\partial c_m}, \qquad
//!    A = \int L(t, x, \dot x)\\, dt . $$
//!
//! Only $L$ and its derivatives in $(x, \dot x)$ are needed, not $\ddot x$, so that the curve may consist of several
//! polynomials that join continuously; the jump of the control between them is the one that minimises the action.
//!
//! [`StateGrid`] has the functions, [`PointLagrangian`] the Lagrangian at the quadrature points and [`Action`] the
//! sums. [`rest`](super::rest) follows the flow.

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
#[doc(hidden)]
pub use row_terms::{RowDuals, RowTerms};
