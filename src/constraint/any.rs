//! The constraints that a scenario can ask for.

use super::{Bounds, Constraint, Contraction, HalfSpaceBalls, SphereBalls, State, Weights};
use crate::error::Result;
use crate::scalar::{Over, Scalar};

/// One of the constraints that are here, so that a list can hold different ones.
#[derive(Clone, Debug, PartialEq)]
pub enum BuiltIn<C: Scalar = f64> {
    /// Balls outside spheres.
    Spheres(SphereBalls<C>),
    /// Balls in a half-space.
    HalfSpace(HalfSpaceBalls<C>),
    /// Bounds on positions and velocities.
    Bounds(Bounds<C>),
}

/// Does the same with whichever it is.
macro_rules! each {
    ($of:expr, $it:ident => $what:expr) => {
        match $of {
            BuiltIn::Spheres($it) => $what,
            BuiltIn::HalfSpace($it) => $what,
            BuiltIn::Bounds($it) => $what,
        }
    };
}

impl<C: Scalar> Constraint<C> for BuiltIn<C> {
    fn rows(&self) -> usize {
        each!(self, it => it.rows())
    }

    fn value<S: Over<C>>(&self, at: &State<'_, C, S>, g: &mut [S]) -> Result<()> {
        each!(self, it => it.value(at, g))
    }

    fn slopes(&self, slopes: &mut [C]) {
        each!(self, it => it.slopes(slopes));
    }

    fn contract<S: Over<C>>(
        &self,
        at: &State<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut Contraction<S>,
    ) -> Result<()> {
        each!(self, it => it.contract(at, weights, out))
    }
}
