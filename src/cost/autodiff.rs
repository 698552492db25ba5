//! Derivatives of a closure by dual numbers.

use super::{HyperDual64, RunningCost, StageDerivatives, StageInput};
use crate::constraint::still;
use crate::error::Result;

/// A running cost given as a closure over dual numbers; see
/// [`CostThroughDynamics::new`](super::CostThroughDynamics::new).
#[derive(Clone, Copy, Debug)]
pub struct AutodiffCost<F>(pub(super) F);

impl<F: Fn(&StageInput<'_, HyperDual64>) -> HyperDual64> AutodiffCost<F> {
    /// The running cost computed by `value`.
    #[must_use]
    pub fn new(value: F) -> Self {
        Self(value)
    }

    fn at(&self, t: HyperDual64, y: &[HyperDual64]) -> HyperDual64 {
        (self.0)(&StageInput::of(t, y))
    }
}

impl<F: Fn(&StageInput<'_, HyperDual64>) -> HyperDual64> RunningCost for AutodiffCost<F> {
    fn value(&self, at: &StageInput<'_, f64>) -> Result<f64> {
        let (t, y) = still(at);
        Ok(self.at(t, &y).re)
    }

    fn derivatives(&self, at: &StageInput<'_, f64>, out: &mut StageDerivatives<f64>) -> Result<f64> {
        let (t, mut y) = still(at);
        let mut value = f64::NAN;
        for i in 0..y.len() {
            y[i].eps1 = 1.0;
            for j in 0..=i {
                y[j].eps2 = 1.0;
                let l = self.at(t, &y);
                y[j].eps2 = 0.0;
                out.hessian[(i, j)] = l.eps1eps2;
                out.hessian[(j, i)] = l.eps1eps2;
                (out.gradient[i], value) = (l.eps1, l.re);
            }
            y[i].eps1 = 0.0;
        }
        Ok(value)
    }

    fn time_rate(&self, at: &StageInput<'_, f64>) -> Result<f64> {
        let (mut t, y) = still(at);
        t.eps1 = 1.0;
        Ok(self.at(t, &y).eps1)
    }
}
