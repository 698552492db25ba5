//! What the Lagrangian may charge for the control of each joint, and limits on the torque as such a cost.

use super::constraint::Penalty;
use crate::error::{Result, check_length};
use crate::model::Model;
use crate::scalar::{Jet, Over, Scalar};

/// A sum $\sum_i \ell_i(u_i)$ over the joints that the Lagrangian gains, with the control $u = ID(x_{P1}, x_{P2}, \dot x_{P2})$ of (13).
pub trait ControlCost<C: Scalar = f64> {
    /// $\ell_i(u)$ for the control `u` of joint `i`.
    fn value<S: Over<C>>(&self, joint: usize, u: S) -> S;

    /// $\ell_i^{\prime}$, $\ell_i^{\prime\prime}$ and $\ell_i^{\prime\prime\prime}$, by dual numbers of the value unless overridden.
    fn derivatives<S: Over<C>>(&self, joint: usize, u: S) -> [S; 3] {
        let (zero, one) = (S::zero(), S::one());
        let inner = Jet::new(Jet::new(u, [one]), [Jet::constant(one)]);
        let outer = Jet::constant(Jet::new(one, [zero]));
        let moved = self.value(joint, Jet::new(inner, [outer]));
        let [by_u] = moved.eps;
        [by_u.re.re, by_u.re.eps[0], by_u.eps[0].eps[0]]
    }

    /// Whether the cost is zero everywhere, so that nothing need be computed.
    fn is_zero(&self) -> bool {
        false
    }
}

/// No cost beyond the effort.
impl<C: Scalar> ControlCost<C> for () {
    fn value<S: Over<C>>(&self, _: usize, _: S) -> S {
        S::zero()
    }

    fn is_zero(&self) -> bool {
        true
    }
}

/// Limits $|u_i| \le \bar u_i$, in N m or N; `None` where there is none.
///
/// A limit is two linear rows, $u_i - \bar u_i$ and $-u_i - \bar u_i$, and not one in $u_i^2 - \bar u_i^2$: the slope of a row in the
/// excess is one for every joint, where that of the square is $2 \bar u_i$, so that a weight would mean something else for a strong
/// joint than for a weak one.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueLimits<C: Scalar = f64>(pub Vec<Option<C>>);

impl<C: Scalar> TorqueLimits<C> {
    /// The finite effort limits of the joints.
    #[must_use]
    pub fn of(model: &Model<C>) -> Self {
        let efforts = model.joints().iter().map(|joint| joint.limits().effort);
        Self(
            efforts
                .map(|effort| effort.is_finite().then(|| C::from_f64(effort)))
                .collect(),
        )
    }

    /// How many rows there are: two for each limit.
    #[must_use]
    pub fn rows(&self) -> usize {
        2 * self.0.iter().flatten().count()
    }

    /// The rows $u_i - \bar u_i$ and $-u_i - \bar u_i$ for each limit, into `g`. `u` has an entry a joint.
    ///
    /// # Errors
    /// The lengths are others.
    pub fn value<S: Over<C>>(&self, u: &[S], g: &mut [S]) -> Result<()> {
        check_length("u", self.0.len(), u.len())?;
        check_length("g", self.rows(), g.len())?;
        let limited = u
            .iter()
            .zip(&self.0)
            .filter_map(|(u, limit)| limit.map(|limit| (u, limit)));
        for ((u, limit), g) in limited.zip(g.chunks_exact_mut(2)) {
            g[0] = *u - S::lift(limit);
            g[1] = -*u - S::lift(limit);
        }
        Ok(())
    }
}

/// Torque limits as a penalty, $\ell_i(u) = b(u - \bar u_i) + b(-u - \bar u_i)$.
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
    fn derivatives_with_value<S: Over<C>>(&self, joint: usize, u: S) -> [S; 4] {
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
    fn value<S: Over<C>>(&self, joint: usize, u: S) -> S {
        self.derivatives_with_value(joint, u)[0]
    }

    fn derivatives<S: Over<C>>(&self, joint: usize, u: S) -> [S; 3] {
        let [_, first, second, third] = self.derivatives_with_value(joint, u);
        [first, second, third]
    }

    fn is_zero(&self) -> bool {
        self.limits.0.iter().all(Option::is_none)
    }
}
