//! Integrators of ordinary differential equations.
//!
//! An [`Integrator`] takes a system from its initial state through given outputs. [`Bdf`] and [`Esdirk34`] are thin layers over
//! diffsol, each in a file of its own; what they share is in `adapter.rs`. A page of the [guide](crate::guide::integrator) writes
//! another one.
//!
//! The same call in the same program gives the same bits: there are no threads, and no clocks but a system's own.

mod adapter;
mod bdf;
mod runge_kutta;

pub use adapter::STEP_LIMIT;
pub use bdf::Bdf;
pub use runge_kutta::Esdirk34;

use nalgebra::DMatrix;
use std::error::Error;
use std::fmt;

/// A system dy/ds = f(s, y) with a dense Jacobian.
pub trait Ode {
    /// Number of entries of y.
    fn dim(&self) -> usize;
    /// Writes f(s, y) to dy. A non-finite entry makes the integrator shorten its step.
    fn rhs(&mut self, s: f64, y: &[f64], dy: &mut [f64]);
    /// Writes df/dy, dim x dim. The matrix is zero on entry.
    fn jacobian(&mut self, s: f64, y: &[f64], jac: &mut DMatrix<f64>);
    /// Asked before each step: a reason to stop there, if there is one.
    fn stop(&mut self) -> Option<String> {
        None
    }
}

/// Local error tolerances, both positive.
///
/// A step is accepted when its local error estimate `e` satisfies
///
/// ```text
/// sqrt(1/n sum_i (e_i / (relative |y_i| + absolute))^2) <= 1
/// ```
///
/// with `y` the state at the start of the step: a weighted root mean square, so one of `n` entries may exceed its own
/// weight by up to `sqrt(n)`. This bounds the error of one step; that of the whole solution is typically one to two orders
/// of magnitude above the tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Tolerance relative to the size of each entry of y.
    pub relative: f64,
    /// Tolerance for entries of y near zero.
    pub absolute: f64,
}

/// The work that an integration took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: usize,
    /// Attempts at a step that were thrown away: error too large, or Newton did not converge.
    pub rejected_steps: usize,
    /// Calls of [`Ode::rhs`].
    pub rhs_evaluations: usize,
    /// Calls of [`Ode::jacobian`].
    pub jacobian_evaluations: usize,
    /// LU factorisations of the Newton matrix.
    pub factorisations: usize,
}

/// A point at which a right-hand side was not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonFinite {
    /// The `s` at which it was evaluated.
    pub s: f64,
    /// Index of the first non-finite entry of dy.
    pub entry: usize,
}

/// An integration that ended early: the place and the reason.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The last s reached.
    pub s: f64,
    /// The last accepted state, at `s`.
    pub y: Vec<f64>,
    /// The last non-finite right-hand side since the last accepted step, if any.
    pub non_finite: Option<NonFinite>,
    /// The reason, in diffsol's words where it is diffsol that gave up.
    pub reason: String,
    /// The cost up to here.
    pub statistics: Statistics,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "integration stopped at s = {}: {}", self.s, self.reason)?;
        if let Some(NonFinite { s, entry }) = self.non_finite {
            write!(f, " (entry {entry} of f not finite at s = {s})")?;
        }
        Ok(())
    }
}

impl Error for Failure {}

/// A method that integrates systems of ordinary differential equations.
pub trait Integrator {
    /// Integrates from `(s0, y0)` through all `outputs` (ascending, above `s0`) with `observe(s, y)` called at each in this order.
    /// The last output is the end of the last step, and the system is not evaluated beyond it. No outputs are no work.
    ///
    /// Before each step [`Ode::stop`] is asked; an entry of `f` that is not finite calls for a shorter step.
    ///
    /// # Errors
    /// Invalid input (nothing is evaluated then), an `f` that is not finite at `(s0, y0)`, a step size that has become too small, too
    /// many steps, or a system that asks to stop. What was observed until then is valid.
    fn integrate(
        &mut self,
        system: &mut dyn Ode,
        s0: f64,
        y0: &[f64],
        outputs: &[f64],
        tolerance: Tolerance,
        observe: &mut dyn FnMut(f64, &[f64]),
    ) -> Result<Statistics, Failure>;
}

crate::names::named_enum! {
/// The integrators that are built in.
pub enum IntegratorKind("integrator") {
    /// Backward differentiation formulas of order 1 to 5.
    Bdf = "bdf",
    /// A singly diagonally implicit Runge-Kutta method of order 3.
    Esdirk34 = "esdirk34",
}
}

impl IntegratorKind {
    /// The integrator.
    #[must_use]
    pub fn build(self) -> Box<dyn Integrator> {
        match self {
            Self::Bdf => Box::new(Bdf),
            Self::Esdirk34 => Box::new(Esdirk34),
        }
    }
}
