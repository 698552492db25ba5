//! Constraints behind pointers, so that one list can hold any types.

use super::{Constraint, PlacedState, RowLabel, RowSet, WeightedDerivatives, Weights};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar, Wide};
use num_dual::{Dual64, DualSVec64};
use std::any::{Any, type_name};
use std::fmt::Debug;

/// An object-safe [`Constraint`]: `Box<dyn DynConstraint>` implements [`Constraint`].
///
/// It is implemented for every constraint over `f64` constants that implements `Clone` and `Debug`. A generic method
/// cannot be called through a pointer, so a boxed constraint is evaluated only over the scalars of the flow, the
/// direct method and [`verify::duals`](crate::verify::duals) (`f64`, `Lanes<f64, 4>`, `Dual64` and `DualSVec64<8>`) and
/// returns an error for any other. The derivatives of the constraint itself are not restricted: they are computed
/// behind the pointer.
pub trait DynConstraint<C: Scalar = f64>: Debug + Send + Sync {
    /// [`Constraint::dim`].
    fn rows(&self) -> usize;

    /// [`Constraint::row_set`].
    fn set_of_row(&self, row: usize) -> RowSet<C>;

    /// [`Constraint::label`].
    fn row_label(&self, row: usize, model: &Model<C>) -> RowLabel;

    /// Fills `slot`, an `Option<Functions<C, S>>`, if `S` is one of the scalars.
    #[doc(hidden)]
    fn functions(&self, slot: &mut dyn Any);

    /// The constraint itself, for [`Functions`].
    #[doc(hidden)]
    fn constraint(&self) -> &dyn Any;

    /// A copy.
    #[doc(hidden)]
    fn boxed(&self) -> Box<dyn DynConstraint<C>>;
}

/// The generic functions of a constraint over one scalar; the first argument is the constraint.
#[doc(hidden)]
pub struct Functions<C: Scalar, S: Scalar> {
    value: Value<C, S>,
    add: AddWeightedDerivatives<C, S>,
}

type Value<C, S> = fn(&dyn Any, &PlacedState<'_, C, S>, &mut [S]) -> Result<()>;

type AddWeightedDerivatives<C, S> =
    fn(&dyn Any, &PlacedState<'_, C, S>, Weights<'_, S>, &mut WeightedDerivatives<S>) -> Result<()>;

impl<C: Scalar, S: AlgebraOver<C>> Functions<C, S> {
    /// The functions of `K`.
    fn of<K: Constraint<C> + 'static>() -> Self {
        Self {
            value: |constraint, at, g| known::<K>(constraint)?.value(at, g),
            add: |constraint, at, weights, out| known::<K>(constraint)?.add_weighted_derivatives(at, weights, out),
        }
    }

    /// The functions of a constraint behind a pointer.
    fn behind(constraint: &dyn DynConstraint<C>) -> Result<Self> {
        let mut slot: Option<Self> = None;
        constraint.functions(&mut slot);
        slot.ok_or_else(not_known::<S>)
    }
}

/// The constraint with its concrete type.
fn known<K: 'static>(constraint: &dyn Any) -> Result<&K> {
    constraint.downcast_ref().ok_or_else(not_known::<K>)
}

fn not_known<T>() -> Error {
    let condition = "a boxed constraint is evaluated over f64, Lanes<f64, 4>, Dual64 and DualSVec64<8> alone";
    Error::input("constraint", type_name::<T>(), condition)
}

impl<K: Constraint + Clone + Debug + Send + Sync + 'static> DynConstraint for K {
    fn rows(&self) -> usize {
        self.dim()
    }

    fn set_of_row(&self, row: usize) -> RowSet {
        self.row_set(row)
    }

    fn row_label(&self, row: usize, model: &Model) -> RowLabel {
        self.label(row, model)
    }

    fn functions(&self, slot: &mut dyn Any) {
        fill::<K, f64>(slot);
        fill::<K, Wide>(slot);
        fill::<K, Dual64>(slot);
        fill::<K, DualSVec64<8>>(slot);
    }

    fn constraint(&self) -> &dyn Any {
        self
    }

    fn boxed(&self) -> Box<dyn DynConstraint> {
        Box::new(self.clone())
    }
}

/// Fills the slot if its scalar is `S`.
fn fill<K: Constraint + 'static, S: AlgebraOver<f64>>(slot: &mut dyn Any) {
    if let Some(slot) = slot.downcast_mut() {
        *slot = Some(Functions::<f64, S>::of::<K>());
    }
}

impl<C: Scalar> Clone for Box<dyn DynConstraint<C>> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

impl<C: Scalar> Constraint<C> for Box<dyn DynConstraint<C>> {
    fn dim(&self) -> usize {
        (**self).rows()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        let constraint = &**self;
        (Functions::behind(constraint)?.value)(constraint.constraint(), at, g)
    }

    /// Without what needs the active pairs or lists of rows, which a pointer does not pass on.
    fn row_set(&self, row: usize) -> RowSet<C> {
        RowSet { cutoff: None, distance: None, ..(**self).set_of_row(row) }
    }

    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        (**self).row_label(row, model)
    }

    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let constraint = &**self;
        (Functions::behind(constraint)?.add)(constraint.constraint(), at, weights, out)
    }
}
