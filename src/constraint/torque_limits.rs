//! Limits on the torque of each joint, and the bundle of all constraints of a motion.

use super::Constraint;
use crate::error::{Error, Result, check_length};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};

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

    /// The number of rows: two for each limit.
    #[must_use]
    pub fn dim(&self) -> usize {
        2 * self.0.iter().flatten().count()
    }

    /// The rows $u_i - \bar u_i$ and $-u_i - \bar u_i$ for each limit, into `g`. `u` has an entry a joint.
    ///
    /// # Errors
    /// The lengths are others.
    pub fn value<S: AlgebraOver<C>>(&self, u: &[S], g: &mut [S]) -> Result<()> {
        check_length("u", self.0.len(), u.len())?;
        check_length("g", self.dim(), g.len())?;
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

/// Everything that a motion has to keep at every time.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints<K, C: Scalar = f64> {
    /// Constraints on $x = [q; v]$.
    pub state: K,
    /// Limits on $u$; no entries where there are none.
    pub torque: TorqueLimits<C>,
}

impl<K: Constraint<C>, C: Scalar> Constraints<K, C> {
    /// The number of rows at each time: those of the state, then those of the control.
    #[must_use]
    pub fn dim(&self) -> usize {
        self.state.dim() + self.torque.dim()
    }
}

impl TorqueLimits {
    /// Checks the limits for `model`.
    ///
    /// # Errors
    /// There is not one entry per joint, or a limit is not positive and finite; it names the joint.
    pub fn check(&self, model: &Model) -> Result<()> {
        check_length("torque limits", model.dof(), self.0.len())?;
        for (joint, limit) in model.joints().iter().zip(&self.0) {
            if let Some(limit) = limit.filter(|limit| !(limit.is_finite() && *limit > 0.0)) {
                let element = format!("joint '{}': torque limit", joint.name());
                let condition = format!("it is {limit}, a positive number is needed");
                return Err(Error::input(model.name(), element, condition));
            }
        }
        Ok(())
    }
}
