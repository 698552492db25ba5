//! Forward simulation: whether the control of a curve takes the robot to its goal.

use super::control::control_at;
use super::integrate::{Failure, Ode, Statistics, Tolerance, integrate};
use crate::dynamics::{Data, ForwardDynamicsDerivatives, aba, aba_derivatives};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::pseudospectral::Curve;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// Local error of the simulation, relative and absolute.
const TOLERANCE: Tolerance = Tolerance {
    relative: 1e-8,
    absolute: 1e-10,
};

/// The gains of the feedback $u - k_p (q - q_{des}) - k_v (v - v_{des})$.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feedback {
    /// $k_p$, N m/rad or N/m.
    pub kp: f64,
    /// $k_v$, N m s/rad or N s/m.
    pub kv: f64,
}

impl Feedback {
    /// No feedback: the control is applied open loop.
    pub const NONE: Self = Self { kp: 0.0, kv: 0.0 };
}

/// Where a simulation ended.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The state at the end of the horizon, $[q; v]$.
    pub state: Vec<f64>,
    /// The largest entry of the difference to the end of the curve, positions and velocities.
    pub error_inf: f64,
    /// What it cost.
    pub statistics: Statistics,
}

/// Applies the control of `curve` to the robot, from the start of the curve to its end, with an adaptive integrator.
///
/// The outer error is bad input; the inner one is a motion that could not be followed to the end.
///
/// # Errors
/// The curve is for another robot.
pub fn simulate(
    model: &Model,
    curve: &Curve,
    feedback: Feedback,
) -> Result<std::result::Result<Simulation, Box<Failure>>> {
    model.check("curve", curve.dof())?;
    let mut robot = ControlledRobot {
        model,
        curve,
        part: 0,
        feedback,
        data: Data::new(model),
        derivatives: ForwardDynamicsDerivatives::new(model.dof()),
        u: vec![0.0; model.dof()],
        error: None,
    };
    let x = curve.x();
    let goal = x.column(x.ncols() - 1);
    let mut state = x.column(0).as_slice().to_vec();
    let mut statistics = Statistics::default();
    // The control may jump where two parts meet, so no step goes across.
    for (part, ends) in curve.joints().windows(2).enumerate() {
        robot.part = part;
        let start = state.clone();
        let mut keep = |_: f64, y: &[f64]| state.copy_from_slice(y);
        let to = &ends[1..];
        let outcome = integrate(&mut robot, ends[0], &start, to, TOLERANCE, &mut keep);
        if let Some(error) = robot.error.take() {
            return Err(error);
        }
        match outcome {
            Ok(cost) => statistics += cost,
            Err(mut failure) => {
                statistics += failure.statistics;
                failure.statistics = statistics;
                return Ok(Err(Box::new(failure)));
            }
        }
    }
    Ok(Ok(Simulation {
        error_inf: (state.iter().zip(goal.iter())).fold(0.0, |m, (a, b)| m.max((a - b).abs())),
        state,
        statistics,
    }))
}

impl AddAssign for Statistics {
    fn add_assign(&mut self, other: Self) {
        self.steps += other.steps;
        self.rejected_steps += other.rejected_steps;
        self.rhs_evaluations += other.rhs_evaluations;
        self.jacobian_evaluations += other.jacobian_evaluations;
        self.factorisations += other.factorisations;
    }
}

/// The robot under its control, as the integrator sees it.
struct ControlledRobot<'a> {
    model: &'a Model,
    curve: &'a Curve,
    /// The part of the curve that is on.
    part: usize,
    feedback: Feedback,
    data: Data<f64>,
    derivatives: ForwardDynamicsDerivatives<f64>,
    u: Vec<f64>,
    error: Option<Error>,
}

impl ControlledRobot<'_> {
    /// The control at time `t` in state `y`.
    fn control(&mut self, t: f64, y: &[f64]) -> Result<()> {
        let n = self.model.dof();
        let (x, xdot) = self.curve.at_of(self.part, t);
        control_at(self.model, &mut self.data, &x, &xdot, &mut self.u)?;
        let Feedback { kp, kv } = self.feedback;
        for i in 0..n {
            self.u[i] -= kp * (y[i] - x[i]) + kv * (y[n + i] - x[n + i]);
        }
        Ok(())
    }

    fn rates(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<()> {
        let n = self.model.dof();
        self.control(t, y)?;
        dy[..n].copy_from_slice(&y[n..]);
        aba(
            self.model,
            &mut self.data,
            &y[..n],
            &y[n..],
            &self.u,
            &mut dy[n..],
        )
    }

    fn rates_jacobian(&mut self, t: f64, y: &[f64], jac: &mut DMatrix<f64>) -> Result<()> {
        let n = self.model.dof();
        self.control(t, y)?;
        let fd = &mut self.derivatives;
        aba_derivatives(self.model, &mut self.data, &y[..n], &y[n..], &self.u, fd)?;
        jac.fill(0.0);
        jac.view_mut((0, n), (n, n)).fill_with_identity();
        jac.view_mut((n, 0), (n, n))
            .copy_from(&(&fd.dq - &fd.h_inverse * self.feedback.kp));
        jac.view_mut((n, n), (n, n))
            .copy_from(&(&fd.dv - &fd.h_inverse * self.feedback.kv));
        Ok(())
    }
}

impl Ode for ControlledRobot<'_> {
    fn dim(&self) -> usize {
        2 * self.model.dof()
    }

    fn rhs(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
        if let Err(error) = self.rates(t, y, dy) {
            dy.fill(f64::NAN);
            self.error = Some(error);
        }
    }

    fn jacobian(&mut self, t: f64, y: &[f64], jac: &mut DMatrix<f64>) {
        if let Err(error) = self.rates_jacobian(t, y, jac) {
            jac.fill(f64::NAN);
            self.error = Some(error);
        }
    }
}
