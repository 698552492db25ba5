//! Costs of the control of each joint in the Lagrangian, which include torque limits and dual trajectories.

use super::{DualTrajectory, Penalty};
use crate::constraint::TorqueLimits;
use crate::scalar::{AlgebraOver, Jet, Scalar, Tanh};

/// A term $\sum_i \ell_i(t, u_i)$ of the Lagrangian, summed over the joints, with the control
/// $u = ID(x_{P1}, x_{P2}, \dot x_{P2})$ of (13).
pub trait ControlCost<C: Scalar = f64> {
    /// Computes $\ell_i(t, u)$ at the time `t`, in s, for the control `u` of joint `i`.
    fn value<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, u: S) -> S;

    /// Computes $\ell_i^{\prime}$, $\ell_i^{\prime\prime}$ and $\ell_i^{\prime\prime\prime}$, derivatives in `u`; by
    /// default by dual numbers from [`value`](Self::value).
    fn derivatives<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, u: S) -> [S; 3] {
        let (zero, one) = (S::zero(), S::one());
        let inner = Jet::new(Jet::new(u, [one]), [Jet::constant(one)]);
        let outer = Jet::constant(Jet::new(one, [zero]));
        let t = Jet::constant(Jet::constant(Jet::constant(t)));
        let moved = self.value(t, joint, Jet::new(inner, [outer]));
        let [by_u] = moved.eps;
        [by_u.re.re, by_u.re.eps[0], by_u.eps[0].eps[0]]
    }

    /// Computes $\partial \ell_i^{\prime} / \partial t$ and $\partial \ell_i^{\prime\prime} / \partial t$ at constant
    /// `u`; by default by dual numbers from [`derivatives`](Self::derivatives).
    fn rates<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, u: S) -> [S; 2] {
        let t = Jet::new(t, [S::one()]);
        let [first, second, _] = self.derivatives(t, joint, Jet::constant(u));
        [first.eps[0], second.eps[0]]
    }

    /// Returns true if the cost is identically zero, so that its evaluation can be skipped.
    fn is_zero(&self) -> bool {
        false
    }
}

impl<C: Scalar, L: ControlCost<C>> ControlCost<C> for &L {
    fn value<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, u: S) -> S {
        (**self).value(t, joint, u)
    }

    fn derivatives<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, u: S) -> [S; 3] {
        (**self).derivatives(t, joint, u)
    }

    fn rates<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, u: S) -> [S; 2] {
        (**self).rates(t, joint, u)
    }

    fn is_zero(&self) -> bool {
        (**self).is_zero()
    }
}

/// The sum of two costs.
impl<C: Scalar, A: ControlCost<C>, B: ControlCost<C>> ControlCost<C> for (A, B) {
    fn value<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, u: S) -> S {
        self.0.value(t, joint, u) + self.1.value(t, joint, u)
    }

    fn derivatives<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, u: S) -> [S; 3] {
        let (a, b) = (self.0.derivatives(t, joint, u), self.1.derivatives(t, joint, u));
        std::array::from_fn(|i| a[i] + b[i])
    }

    fn rates<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, u: S) -> [S; 2] {
        let (a, b) = (self.0.rates(t, joint, u), self.1.rates(t, joint, u));
        std::array::from_fn(|i| a[i] + b[i])
    }

    fn is_zero(&self) -> bool {
        self.0.is_zero() && self.1.is_zero()
    }
}

/// No cost beyond the effort.
impl<C: Scalar> ControlCost<C> for () {
    fn value<S: AlgebraOver<C> + Tanh>(&self, _: S, _: usize, _: S) -> S {
        S::zero()
    }

    fn is_zero(&self) -> bool {
        true
    }
}

/// The linear term of an augmented Lagrangian, $\ell_i(t, u) = \lambda_i(t)\\, u$, for joints whose torque should
/// vanish. The quadratic term, $\tfrac{\rho}2 u^2$, is their [weight](super::ActuationWeights). The term is zero for a
/// joint whose component is zero or missing.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlDual<C: Scalar = f64>(pub DualTrajectory<C>);

impl<C: Scalar> ControlCost<C> for ControlDual<C> {
    fn value<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, u: S) -> S {
        self.0.value(joint, t) * u
    }

    fn derivatives<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, _: S) -> [S; 3] {
        [self.0.value(joint, t), S::zero(), S::zero()]
    }

    fn rates<S: AlgebraOver<C> + Tanh>(&self, t: S, joint: usize, _: S) -> [S; 2] {
        let [_, rate] = self.0.value_and_rate(joint, t);
        [rate, S::zero()]
    }

    fn is_zero(&self) -> bool {
        self.0.coefficients().iter().all(C::is_zero)
    }
}

/// Torque limits as a penalty, $\ell_i(u) = b(u - \bar u_i) + b(-u - \bar u_i)$. For a passive joint, whose limit is
/// zero, this is $k_{cons} u^2$, because the activations of `u` and `-u` add up to one.
#[derive(Clone, Debug, PartialEq)]
pub struct TorquePenalty<C: Scalar = f64> {
    /// The limits.
    pub limits: TorqueLimits<C>,
    /// The penalty of one row.
    pub penalty: Penalty<C>,
}

impl<C: Scalar> TorquePenalty<C> {
    /// Computes the penalty and its derivatives; `None` without a limit.
    #[inline]
    fn derivatives_with_value<S: AlgebraOver<C> + Tanh>(&self, joint: usize, u: S) -> [S; 4] {
        let Some(limit) = self.limits.0.get(joint).copied().flatten() else {
            return [S::zero(); 4];
        };
        let limit = S::lift(limit);
        let above = self.penalty.derivatives(u - limit);
        let below = self.penalty.derivatives(-u - limit);
        [above[0] + below[0], above[1] - below[1], above[2] + below[2], above[3] - below[3]]
    }
}

impl<C: Scalar> ControlCost<C> for TorquePenalty<C> {
    fn value<S: AlgebraOver<C> + Tanh>(&self, _: S, joint: usize, u: S) -> S {
        self.derivatives_with_value(joint, u)[0]
    }

    fn derivatives<S: AlgebraOver<C> + Tanh>(&self, _: S, joint: usize, u: S) -> [S; 3] {
        let [_, first, second, third] = self.derivatives_with_value(joint, u);
        [first, second, third]
    }

    fn rates<S: AlgebraOver<C> + Tanh>(&self, _: S, _: usize, _: S) -> [S; 2] {
        [S::zero(); 2]
    }

    fn is_zero(&self) -> bool {
        self.limits.0.iter().all(Option::is_none)
    }
}
