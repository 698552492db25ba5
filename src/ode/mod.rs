//! Integrators of ordinary differential equations.
//!
//! An [`Integrator`] advances a system from its initial state through given outputs. [`Bdf`] and [`Esdirk34`] are thin
//! layers over diffsol, each in a separate file; their common part is `adapter.rs`. The
//! [guide](crate::guide::integrator) implements another one.
//!
//! The same call in the same program gives the same bits: there are no threads, and no clock except that of a system.

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
    /// The number of entries of y.
    fn dim(&self) -> usize;
    /// Computes f(s, y) into dy. A non-finite entry makes the integrator shorten its step.
    fn rhs(&mut self, s: f64, y: &[f64], dy: &mut [f64]);
    /// Computes df/dy into `jac`, dim x dim, which is zero on entry.
    fn jacobian(&mut self, s: f64, y: &[f64], jac: &mut DMatrix<f64>);
    /// A reason to stop, if there is one; called before each step.
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
/// weight by up to `sqrt(n)`. This bounds the error of one step; that of the whole solution is typically one to two
/// orders of magnitude above the tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Tolerance relative to the size of each entry of y.
    pub relative: f64,
    /// Tolerance for entries of y near zero.
    pub absolute: f64,
}

/// The work of an integration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: usize,
    /// Rejected attempts at a step: error too large, or Newton did not converge.
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
    /// The value of `s`.
    pub s: f64,
    /// The index of the first non-finite entry of dy.
    pub entry: usize,
}

/// An integration that failed before its end, with the place and the reason.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The last s reached.
    pub s: f64,
    /// The last accepted state, at `s`.
    pub y: Vec<f64>,
    /// The last non-finite right-hand side since the last accepted step, if any.
    pub non_finite: Option<NonFinite>,
    /// The reason, in diffsol's words if diffsol gave up.
    pub reason: String,
    /// The work up to here.
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

/// A method for integrating systems of ordinary differential equations.
pub trait Integrator {
    /// Integrates from `(s0, y0)` through all `outputs` (ascending, above `s0`), and calls `observe(s, y)` at each in
    /// this order. The last output is the end of the last step, and the system is not evaluated beyond it. Without
    /// outputs nothing is evaluated.
    ///
    /// [`Ode::stop`] is called before each step; an entry of `f` that is not finite leads to a shorter step.
    ///
    /// # Errors
    /// Invalid input (nothing is evaluated then), an `f` that is not finite at `(s0, y0)`, a step size that has become
    /// too small, too many steps, or a system that requests a stop. All values observed before remain valid.
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
/// The built-in integrators.
pub enum IntegratorKind("integrator") {
    /// Backward differentiation formulas of order 1 to 5.
    Bdf = "bdf",
    /// A singly diagonally implicit Runge-Kutta method of order 3.
    Esdirk34 = "esdirk34",
}
}

impl IntegratorKind {
    /// Builds the integrator.
    #[must_use]
    pub fn build(self) -> Box<dyn Integrator> {
        match self {
            Self::Bdf => Box::new(Bdf),
            Self::Esdirk34 => Box::new(Esdirk34),
        }
    }
}
