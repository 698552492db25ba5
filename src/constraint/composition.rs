//! Tuples and lists of constraints as one constraint.

use super::{
    ActivePair, AnyConstraint, Constraint, PlacedState, RowLabel, RowList, RowSet, WeightedDerivatives, Weights,
};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};

/// No constraint.
impl<C: Scalar> Constraint<C> for () {
    fn dim(&self) -> usize {
        0
    }

    fn value<S: AlgebraOver<C>>(&self, _: &PlacedState<'_, C, S>, _: &mut [S]) -> Result<()> {
        Ok(())
    }
}

/// The rows of `A`, then those of `B`.
impl<C: Scalar, A: Constraint<C>, B: Constraint<C>> Constraint<C> for (A, B) {
    fn dim(&self) -> usize {
        self.0.dim() + self.1.dim()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        let (a, b) = g.split_at_mut(self.0.dim());
        let (at_a, at_b) = at.split_at(a.len());
        self.0.value(&at_a, a)?;
        self.1.value(&at_b, b)
    }

    fn row_set(&self, row: usize) -> RowSet<C> {
        match row.checked_sub(self.0.dim()) {
            None => self.0.row_set(row),
            Some(row) => self.1.row_set(row),
        }
    }

    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        match row.checked_sub(self.0.dim()) {
            None => self.0.label(row, model),
            Some(row) => self.1.label(row, model),
        }
    }

    fn value_of<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        rows: Option<RowList<'_>>,
        g: &mut [S],
        mut active_pairs: Option<&mut Vec<ActivePair<S>>>,
    ) -> Result<()> {
        let (a, b) = g.split_at_mut(self.0.dim());
        let (at_a, at_b) = at.split_at(a.len());
        let (of_a, of_b) = rows.map(|rows| rows.split_at(a.len())).unzip();
        self.0.value_of(&at_a, of_a, a, active_pairs.as_deref_mut())?;
        append(&self.1, (&at_b, of_b), (b, a.len()), active_pairs)
    }

    fn parts<'a>(&'a self, parts: &mut Vec<&'a AnyConstraint<C>>) -> bool {
        // Both append theirs.
        self.0.parts(parts) & self.1.parts(parts)
    }

    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let (a, b) = weights.split_at(self.0.dim());
        let (at_a, at_b) = at.split_at(self.0.dim());
        self.0.add_weighted_derivatives(&at_a, a, out)?;
        self.1.add_weighted_derivatives(&at_b, b, out)
    }
}

/// The rows of all, in order.
impl<C: Scalar, K: Constraint<C>> Constraint<C> for [K] {
    fn dim(&self) -> usize {
        self.iter().map(K::dim).sum()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, mut g: &mut [S]) -> Result<()> {
        let mut at = *at;
        for constraint in self {
            let (own, rest) = g.split_at_mut(constraint.dim());
            let (here, others) = at.split_at(own.len());
            constraint.value(&here, own)?;
            (at, g) = (others, rest);
        }
        Ok(())
    }

    fn row_set(&self, row: usize) -> RowSet<C> {
        owner(self, row).map_or_else(RowSet::at_most_zero, |(constraint, own)| constraint.row_set(own))
    }

    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        match owner(self, row) {
            Some((constraint, own)) => constraint.label(own, model),
            None => RowLabel::numbered(row),
        }
    }

    fn value_of<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        mut rows: Option<RowList<'_>>,
        mut g: &mut [S],
        mut active_pairs: Option<&mut Vec<ActivePair<S>>>,
    ) -> Result<()> {
        let (mut at, mut first) = (*at, 0);
        for constraint in self {
            let (own, rest) = g.split_at_mut(constraint.dim());
            let count = own.len();
            let (here, others) = at.split_at(count);
            let (listed, unlisted) = rows.map(|rows| rows.split_at(count)).unzip();
            append(constraint, (&here, listed), (own, first), active_pairs.as_deref_mut())?;
            (at, rows, first, g) = (others, unlisted, first + count, rest);
        }
        Ok(())
    }

    fn parts<'a>(&'a self, parts: &mut Vec<&'a AnyConstraint<C>>) -> bool {
        self.iter().fold(true, |all, constraint| constraint.parts(parts) & all)
    }

    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        mut weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let mut at = *at;
        for constraint in self {
            let (own, rest) = weights.split_at(constraint.dim());
            let (here, others) = at.split_at(constraint.dim());
            constraint.add_weighted_derivatives(&here, own, out)?;
            (at, weights) = (others, rest);
        }
        Ok(())
    }
}

/// Computes the rows of a constraint, the first of which has this number among all, and appends its active pairs.
fn append<C: Scalar, S: AlgebraOver<C>, K: Constraint<C>>(
    constraint: &K,
    (at, rows): (&PlacedState<'_, C, S>, Option<RowList<'_>>),
    (g, first): (&mut [S], usize),
    mut active_pairs: Option<&mut Vec<ActivePair<S>>>,
) -> Result<()> {
    let before = active_pairs.as_ref().map_or(0, |pairs| pairs.len());
    constraint.value_of(at, rows, g, active_pairs.as_deref_mut())?;
    for pair in active_pairs.into_iter().flat_map(|pairs| &mut pairs[before..]) {
        pair.row += first;
    }
    Ok(())
}

/// The constraint that contains a row of the combined rows, and the index of the row in it; `None` if there are fewer
/// rows.
fn owner<C: Scalar, K: Constraint<C>>(all: &[K], mut row: usize) -> Option<(&K, usize)> {
    for constraint in all {
        match row.checked_sub(constraint.dim()) {
            None => return Some((constraint, row)),
            Some(rest) => row = rest,
        }
    }
    None
}

/// Implements the trait for a pointer, a list or nested pairs by delegation. Nested pairs are temporary and so have no
/// parts.
macro_rules! delegate {
    ([$($generic:tt)*] $type:ty, $it:ident => $inner:expr $(, $parts:ident)?) => {
        impl<C: Scalar, $($generic)*> Constraint<C> for $type {
            fn dim(&self) -> usize {
                let $it = self;
                $inner.dim()
            }

            fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
                let $it = self;
                $inner.value(at, g)
            }

            fn row_set(&self, row: usize) -> RowSet<C> {
                let $it = self;
                $inner.row_set(row)
            }

            fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
                let $it = self;
                $inner.label(row, model)
            }

            fn value_of<S: AlgebraOver<C>>(
                &self,
                at: &PlacedState<'_, C, S>,
                rows: Option<RowList<'_>>,
                g: &mut [S],
                active_pairs: Option<&mut Vec<ActivePair<S>>>,
            ) -> Result<()> {
                let $it = self;
                $inner.value_of(at, rows, g, active_pairs)
            }

            $(fn $parts<'a>(&'a self, parts: &mut Vec<&'a AnyConstraint<C>>) -> bool {
                let $it = self;
                $inner.parts(parts)
            })?

            fn add_weighted_derivatives<S: AlgebraOver<C>>(
                &self,
                at: &PlacedState<'_, C, S>,
                weights: Weights<'_, S>,
                out: &mut WeightedDerivatives<S>,
            ) -> Result<()> {
                let $it = self;
                $inner.add_weighted_derivatives(at, weights, out)
            }
        }
    };
}

delegate!([K: Constraint<C> + ?Sized] &K, it => (**it), parts);
delegate!([K: Constraint<C>] Vec<K>, it => it.as_slice(), parts);
delegate!([K: Constraint<C>, const M: usize] [K; M], it => it.as_slice(), parts);
delegate!([K0: Constraint<C>, K1: Constraint<C>, K2: Constraint<C>] (K0, K1, K2), it => (&it.0, (&it.1, &it.2)));
