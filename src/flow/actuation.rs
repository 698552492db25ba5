//! The weights of the joints in the control effort.

use crate::error::{Error, Result, check_length};
use crate::scalar::{AlgebraOver, Scalar};

/// The diagonal of `W` in the control effort $u^T W u$: one or another weight for an actuated joint, and a large number
/// for a passive joint, whose torque should vanish. The default is the paper's $W = I$.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuationWeights<C: Scalar = f64>(Option<Vec<C>>);

impl<C: Scalar> Default for ActuationWeights<C> {
    fn default() -> Self {
        Self::ones()
    }
}

impl<C: Scalar> ActuationWeights<C> {
    /// $W = I$, for any number of joints.
    #[must_use]
    pub fn ones() -> Self {
        Self(None)
    }

    /// Builds $W$ from one weight per joint. The flow is a descent if all are positive; this is not checked, because a
    /// scalar has no order.
    ///
    /// # Errors
    /// A weight is zero, so that the metric would be singular.
    pub fn diagonal(weights: Vec<C>) -> Result<Self> {
        match weights.iter().position(C::is_zero) {
            None => Ok(Self(Some(weights))),
            Some(joint) => {
                let condition = "it is zero, the metric would be singular";
                Err(Error::input("weights", format!("weight of joint {joint}"), condition))
            }
        }
    }

    /// Returns true if $W = I$ by construction, so that the products can be skipped.
    #[must_use]
    pub fn is_one(&self) -> bool {
        self.0.is_none()
    }

    /// The weight of a joint.
    pub(crate) fn of(&self, joint: usize) -> C {
        self.0.as_ref().map_or_else(C::one, |weights| weights[joint])
    }

    /// Replaces `x`, whose columns have `N` entries each, by $W x$.
    pub(crate) fn multiply<S: AlgebraOver<C>>(&self, x: &mut [S]) {
        if let Some(weights) = &self.0 {
            for column in x.chunks_exact_mut(weights.len()) {
                let pairs = column.iter_mut().zip(weights);
                pairs.for_each(|(x, w)| *x = x.scale(*w));
            }
        }
    }

    /// Replaces `x`, whose columns have `N` entries each, by $W^{-1} x$.
    pub(crate) fn divide<S: AlgebraOver<C>>(&self, x: &mut [S]) {
        if let Some(weights) = &self.0 {
            for column in x.chunks_exact_mut(weights.len()) {
                let pairs = column.iter_mut().zip(weights);
                pairs.for_each(|(x, w)| *x = x.scale(C::one() / *w));
            }
        }
    }

    /// Checks that the number of weights is `n`.
    pub(crate) fn check(&self, n: usize) -> Result<()> {
        let count = self.0.as_ref().map_or(n, Vec::len);
        check_length("weights", n, count)
    }
}
