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
//! A Lagrangian is a [cost](crate::cost::PointCost) of the curve in the state, $2 N$ numbers and their rates, and its
//! action an [integral](crate::transcription::Objective) as that of any other cost: [`WithSlip`] makes one of a running
//! cost $l(q, v, a)$, and [`DualLagrangian`] of any [`Lagrangian`](crate::flow::Lagrangian). [`Norm`] is the metric.
//! [`rest`](super::rest) follows the flow.

mod dual;
mod norm;
mod slip;

pub use dual::DualLagrangian;
pub use norm::{Norm, RestMetric};
pub use slip::WithSlip;
