//! What the Lagrangian may charge for the control of each joint, and limits on the torque as such a cost.

use super::Penalty;
use crate::constraint::TorqueLimits;
use crate::scalar::{AlgebraOver, Jet, Scalar, Tanh};

/// A sum $\sum_i \ell_i(u_i)$ over the joints that the Lagrangian gains, with the control $u = ID(x_{P1}, x_{P2}, \dot x_{P2})$ of (13).
pub trait ControlCost<C: Scalar = f64> {
    /// $\ell_i(u)$ for the control `u` of joint `i`.
    fn value<S: AlgebraOver<C> + Tanh>(&self, joint: usize, u: S) -> S;

    /// $\ell_i^{\prime}$, $\ell_i^{\prime\prime}$ and $\ell_i^{\prime\prime\prime}$, by dual numbers of the value unless overridden.
    fn derivatives<S: AlgebraOver<C> + Tanh>(&self, joint: usize, u: S) -> [S; 3] {
        let (zero, one) = (S::zero(), S::one());
        let inner = Jet::new(Jet::new(u, [one]), [Jet::constant(one)]);
        let outer = Jet::constant(Jet::new(one, [zero]));
        let moved = self.value(joint, Jet::new(inner, [outer]));
        let [by_u] = moved.eps;
        [by_u.re.re, by_u.re.eps[0], by_u.eps[0].eps[0]]
    }

    /// Tells whether the cost is zero everywhere, so that nothing need be computed.
    fn is_zero(&self) -> bool {
        false
    }
}

/// No cost beyond the effort.
impl<C: Scalar> ControlCost<C> for () {
    fn value<S: AlgebraOver<C> + Tanh>(&self, _: usize, _: S) -> S {
        S::zero()
    }

    fn is_zero(&self) -> bool {
        true
    }
}

/// Torque limits as a penalty, $\ell_i(u) = b(u - \bar u_i) + b(-u - \bar u_i)$. That of a passive joint, whose limit is zero, is
/// $k_{cons} u^2$, since the activations of `u` and `-u` add up to one.
#[derive(Clone, Debug, PartialEq)]
pub struct TorquePenalty<C: Scalar = f64> {
    /// The limits.
    pub limits: TorqueLimits<C>,
    /// The penalty of one row.
    pub penalty: Penalty<C>,
}

impl<C: Scalar> TorquePenalty<C> {
    /// The penalty and its derivatives where there is a limit.
    #[inline]
    fn derivatives_with_value<S: AlgebraOver<C> + Tanh>(&self, joint: usize, u: S) -> [S; 4] {
        let Some(limit) = self.limits.0.get(joint).copied().flatten() else {
            return [S::zero(); 4];
        };
        let limit = S::lift(limit);
        let above = self.penalty.derivatives(u - limit);
        let below = self.penalty.derivatives(-u - limit);
        [
            above[0] + below[0],
            above[1] - below[1],
            above[2] + below[2],
            above[3] - below[3],
        ]
    }
}

impl<C: Scalar> ControlCost<C> for TorquePenalty<C> {
    fn value<S: AlgebraOver<C> + Tanh>(&self, joint: usize, u: S) -> S {
        self.derivatives_with_value(joint, u)[0]
    }

    fn derivatives<S: AlgebraOver<C> + Tanh>(&self, joint: usize, u: S) -> [S; 3] {
        let [_, first, second, third] = self.derivatives_with_value(joint, u);
        [first, second, third]
    }

    fn is_zero(&self) -> bool {
        self.limits.0.iter().all(Option::is_none)
    }
}
