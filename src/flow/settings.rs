//! The parameters of the flow.

use super::jacobian::JacobianKind;
use crate::curve::Chebyshev;
use crate::error::{Error, Result, check_positive};
use crate::motion::{Guess, Interrupt};
use crate::ode::IntegratorKind;
use std::time::Duration;

/// The largest number of unknowns: one Jacobian of this size takes 800 MB, and there are three.
const MAX_UNKNOWNS: usize = 10_000;

/// The parameters of the flow.
#[derive(Clone, Debug)]
pub struct FlowSettings {
    /// The degree of the polynomial.
    pub degree: usize,
    /// The penalty on $\dot x_{P1} \ne x_{P2}$ in (11).
    pub k: f64,
    /// The value of `s` at which the flow stops.
    pub s_max: f64,
    /// Absolute and relative tolerance of the integrator.
    pub tolerance: f64,
    /// The initial curve, at `s = 0`.
    pub guess: Guess,
    /// The method of computing the Jacobian.
    pub jacobian: JacobianKind,
    /// The integrator over `s`.
    pub integrator: IntegratorKind,
    /// The wall time after which the flow fails.
    pub time_limit: Option<Duration>,
    /// The handle by which another thread stops the flow in the same way.
    pub interrupt: Interrupt,
}

impl FlowSettings {
    /// The paper's tolerance, which is the default.
    pub const TOLERANCE: f64 = 1e-4;

    /// Settings with the default tolerance, guess, Jacobian and integrator.
    #[must_use]
    pub fn new(degree: usize, k: f64, s_max: f64) -> Self {
        Self {
            degree,
            k,
            s_max,
            tolerance: Self::TOLERANCE,
            guess: Guess::default(),
            jacobian: JacobianKind::default(),
            integrator: IntegratorKind::default(),
            time_limit: None,
            interrupt: Interrupt::default(),
        }
    }

    /// Refuses values out of range.
    ///
    /// # Errors
    /// A number is out of range, or the Jacobian of a robot with `dof` joints does not fit into memory.
    pub fn check(&self, dof: usize) -> Result<()> {
        Chebyshev::check_degree(self.degree).map_err(|condition| Error::input("settings", "degree", condition))?;
        let (p, unknowns) = (self.degree, dof * 2 * self.degree.saturating_sub(1));
        if unknowns > MAX_UNKNOWNS {
            let condition = format!("it is {p}, with {dof} joints {unknowns} unknowns; at most {MAX_UNKNOWNS}");
            return Err(Error::input("settings", "degree", condition));
        }
        for (what, value) in [("k", self.k), ("s_max", self.s_max), ("tolerance", self.tolerance)] {
            check_positive("settings", what, value)?;
        }
        Ok(())
    }
}
