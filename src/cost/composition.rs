//! Compositions of running costs: weighted terms and sums.

use super::{RunningCost, StageDerivatives, StageInput};
use crate::error::Result;
use std::sync::Arc;

/// A running cost times a constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighted<R> {
    /// The constant.
    pub weight: f64,
    /// The cost.
    pub cost: R,
}

impl<R> Weighted<R> {
    /// `weight` times `cost`.
    #[must_use]
    pub fn new(weight: f64, cost: R) -> Self {
        Self { weight, cost }
    }
}

impl<R: RunningCost> RunningCost for Weighted<R> {
    fn value(&self, at: &StageInput<'_, f64>) -> Result<f64> {
        Ok(self.weight * self.cost.value(at)?)
    }

    fn derivatives(&self, at: &StageInput<'_, f64>, out: &mut StageDerivatives<f64>) -> Result<f64> {
        let value = self.cost.derivatives(at, out)?;
        out.gradient *= self.weight;
        out.hessian *= self.weight;
        Ok(self.weight * value)
    }

    fn time_rate(&self, at: &StageInput<'_, f64>) -> Result<f64> {
        Ok(self.weight * self.cost.time_rate(at)?)
    }
}

/// The sum of the terms; zero if there are none.
impl<R: RunningCost> RunningCost for [R] {
    fn value(&self, at: &StageInput<'_, f64>) -> Result<f64> {
        self.iter().map(|term| term.value(at)).sum()
    }

    fn derivatives(&self, at: &StageInput<'_, f64>, out: &mut StageDerivatives<f64>) -> Result<f64> {
        let Some((first, others)) = self.split_first() else {
            return Ok(0.0);
        };
        let mut value = first.derivatives(at, out)?;
        // A term finds zeros and may write its entries, or scale all of them.
        let mut own = StageDerivatives::new(if others.is_empty() { 0 } else { at.q.len() });
        for term in others {
            own.gradient.fill(0.0);
            own.hessian.fill(0.0);
            value += term.derivatives(at, &mut own)?;
            out.gradient += &own.gradient;
            out.hessian += &own.hessian;
        }
        Ok(value)
    }

    fn time_rate(&self, at: &StageInput<'_, f64>) -> Result<f64> {
        self.iter().map(|term| term.time_rate(at)).sum()
    }
}

/// Implements the trait for a pointer, a list or a tuple by delegation.
macro_rules! delegate {
    ([$($generic:tt)*] $type:ty, $it:ident => $inner:expr) => {
        impl<$($generic)*> RunningCost for $type {
            fn value(&self, at: &StageInput<'_, f64>) -> Result<f64> {
                let $it = self;
                $inner.value(at)
            }

            fn derivatives(
                &self,
                at: &StageInput<'_, f64>,
                out: &mut StageDerivatives<f64>,
            ) -> Result<f64> {
                let $it = self;
                $inner.derivatives(at, out)
            }

            fn time_rate(&self, at: &StageInput<'_, f64>) -> Result<f64> {
                let $it = self;
                $inner.time_rate(at)
            }
        }
    };
}

/// Any cost, for lists of mixed types.
type Term<'a> = &'a dyn RunningCost;

delegate!([R: RunningCost + ?Sized] &R, it => (**it));
delegate!([R: RunningCost + ?Sized] Arc<R>, it => (**it));
delegate!([R: RunningCost] Vec<R>, it => it.as_slice());
delegate!([R: RunningCost, const M: usize] [R; M], it => it.as_slice());
delegate!([A: RunningCost, B: RunningCost] (A, B), it => [&it.0 as Term<'_>, &it.1]);
delegate!(
    [A: RunningCost, B: RunningCost, D: RunningCost] (A, B, D),
    it => [&it.0 as Term<'_>, &it.1, &it.2]
);
delegate!(
    [A: RunningCost, B: RunningCost, D: RunningCost, E: RunningCost] (A, B, D, E),
    it => [&it.0 as Term<'_>, &it.1, &it.2, &it.3]
);
delegate!(
    [A: RunningCost, B: RunningCost, D: RunningCost, E: RunningCost, F: RunningCost] (A, B, D, E, F),
    it => [&it.0 as Term<'_>, &it.1, &it.2, &it.3, &it.4]
);
delegate!(
    [A: RunningCost, B: RunningCost, D: RunningCost, E: RunningCost, F: RunningCost, G: RunningCost] (A, B, D, E, F, G),
    it => [&it.0 as Term<'_>, &it.1, &it.2, &it.3, &it.4, &it.5]
);
