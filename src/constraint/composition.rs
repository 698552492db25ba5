//! Several constraints are one.

use super::{Constraint, Contraction, State, Weights};
use crate::error::Result;
use crate::scalar::{Over, Scalar};

/// No constraint.
impl<C: Scalar> Constraint<C> for () {
    fn rows(&self) -> usize {
        0
    }

    fn value<S: Over<C>>(&self, _: &State<'_, C, S>, _: &mut [S]) -> Result<()> {
        Ok(())
    }
}

/// The rows of `A`, then those of `B`.
impl<C: Scalar, A: Constraint<C>, B: Constraint<C>> Constraint<C> for (A, B) {
    fn rows(&self) -> usize {
        self.0.rows() + self.1.rows()
    }

    fn value<S: Over<C>>(&self, at: &State<'_, C, S>, g: &mut [S]) -> Result<()> {
        let (a, b) = g.split_at_mut(self.0.rows());
        self.0.value(at, a)?;
        self.1.value(at, b)
    }

    fn slopes(&self, slopes: &mut [C]) {
        let (a, b) = slopes.split_at_mut(self.0.rows());
        self.0.slopes(a);
        self.1.slopes(b);
    }

    fn contract<S: Over<C>>(
        &self,
        at: &State<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut Contraction<S>,
    ) -> Result<()> {
        let (a, b) = weights.split_at(self.0.rows());
        self.0.contract(at, a, out)?;
        self.1.contract(at, b, out)
    }
}

/// The rows of all, in order.
impl<C: Scalar, K: Constraint<C>> Constraint<C> for [K] {
    fn rows(&self) -> usize {
        self.iter().map(K::rows).sum()
    }

    fn value<S: Over<C>>(&self, at: &State<'_, C, S>, mut g: &mut [S]) -> Result<()> {
        for constraint in self {
            let (own, rest) = g.split_at_mut(constraint.rows());
            constraint.value(at, own)?;
            g = rest;
        }
        Ok(())
    }

    fn slopes(&self, mut slopes: &mut [C]) {
        for constraint in self {
            let (own, rest) = slopes.split_at_mut(constraint.rows());
            constraint.slopes(own);
            slopes = rest;
        }
    }

    fn contract<S: Over<C>>(
        &self,
        at: &State<'_, C, S>,
        mut weights: Weights<'_, S>,
        out: &mut Contraction<S>,
    ) -> Result<()> {
        for constraint in self {
            let (own, rest) = weights.split_at(constraint.rows());
            constraint.contract(at, own, out)?;
            weights = rest;
        }
        Ok(())
    }
}

/// Hands everything on to what is behind a pointer.
macro_rules! behind {
    ($type:ty, $parameter:ident $(: $bound:ident)?) => {
        impl<C: Scalar, $parameter: Constraint<C> $(+ ?$bound)?> Constraint<C> for $type {
            fn rows(&self) -> usize {
                (**self).rows()
            }

            fn value<S: Over<C>>(&self, at: &State<'_, C, S>, g: &mut [S]) -> Result<()> {
                (**self).value(at, g)
            }

            fn slopes(&self, slopes: &mut [C]) {
                (**self).slopes(slopes);
            }

            fn contract<S: Over<C>>(
                &self,
                at: &State<'_, C, S>,
                weights: Weights<'_, S>,
                out: &mut Contraction<S>,
            ) -> Result<()> {
                (**self).contract(at, weights, out)
            }
        }
    };
}

behind!(&K, K: Sized);
behind!(Vec<K>, K);
