//! Forward simulation of the robot under the control of a curve.

use super::control::control_at;
use crate::curve::Curve;
use crate::dynamics::{Data, ForwardDynamicsDerivatives, aba, aba_derivatives};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::ode::{Bdf, Integrator, Ode, Statistics, Tolerance};
use nalgebra::{DMatrix, DVector, DVectorViewMut};
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// The relative and absolute local error of the simulation.
const TOLERANCE: Tolerance = Tolerance { relative: 1e-8, absolute: 1e-10 };

/// The gains of the feedback $u - k_p (q - q_{des}) - k_v (v - v_{des})$.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feedback {
    /// The position gain $k_p$, N m/rad or N/m.
    pub kp: f64,
    /// The velocity gain $k_v$, N m s/rad or N s/m.
    pub kv: f64,
}

impl Feedback {
    /// No feedback: the control is applied open loop.
    pub const NONE: Self = Self { kp: 0.0, kv: 0.0 };
}

/// The result of a simulation.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The last state, $[q; v]$.
    pub state: Vec<f64>,
    /// The reason if this is not the state at the end of the horizon, because the integrator failed before.
    pub failure: Option<String>,
    /// The largest absolute difference from the end of the curve, over positions and velocities; infinite if the
    /// simulation failed.
    pub error_inf: f64,
    /// The work of the integrator.
    pub statistics: Statistics,
}

/// Simulates the robot under the control of `curve`, from its start to its end, with [`Bdf`] as the integrator.
///
/// The joints with the indices `passive` move freely: their torque is zero, with neither control nor feedback.
///
/// # Errors
/// The curve has another number of joints than `model`, or an index is out of range. A simulation that fails before its
/// end is not an error: [`Simulation::failure`] has the reason.
pub fn simulate(model: &Model, curve: &Curve, feedback: Feedback, passive: &[usize]) -> Result<Simulation> {
    simulate_with(model, curve, feedback, passive, &mut Bdf)
}

/// Simulates like [`simulate`], but with any integrator.
///
/// # Errors
/// Those of [`simulate`].
pub fn simulate_with(
    model: &Model,
    curve: &Curve,
    feedback: Feedback,
    passive: &[usize],
    integrator: &mut dyn Integrator,
) -> Result<Simulation> {
    let mut robot = ControlledRobot::new(model, curve, feedback, passive)?;
    let x = curve.x();
    let goal = x.column(x.ncols() - 1);
    let mut state = x.column(0).as_slice().to_vec();
    let mut statistics = Statistics::default();
    // The control may jump at a breakpoint, so no step crosses one.
    for (segment, ends) in curve.breakpoints().windows(2).enumerate() {
        robot.segment = segment;
        let start = state.clone();
        let mut keep = |_: f64, y: &[f64]| state.copy_from_slice(y);
        let to = &ends[1..];
        let outcome = integrator.integrate(&mut robot, ends[0], &start, to, TOLERANCE, &mut keep);
        if let Some(error) = robot.error.take() {
            return Err(error);
        }
        match outcome {
            Ok(cost) => statistics += cost,
            Err(failure) => {
                statistics += failure.statistics;
                return Ok(Simulation {
                    error_inf: f64::INFINITY,
                    failure: Some(failure.to_string()),
                    state: failure.y,
                    statistics,
                });
            }
        }
    }
    Ok(Simulation {
        error_inf: (state.iter().zip(goal.iter())).fold(0.0, |m, (a, b)| m.max((a - b).abs())),
        failure: None,
        state,
        statistics,
    })
}

/// The largest deviation from the curve at the end of an interval between two nodes, for a robot that starts the
/// interval on the curve and is controlled by the polynomial through the control values at the nodes: the largest
/// absolute difference over positions and velocities. `None` if the simulation of an interval fails. The joints with
/// the indices `passive` get no torque.
///
/// Over a whole unstable motion the open-loop error grows exponentially at any degree; over one interval it measures
/// whether the degree resolves the control.
///
/// # Errors
/// Those of [`simulate`].
pub fn replay_error(model: &Model, curve: &Curve, passive: &[usize]) -> Result<Option<f64>> {
    let mut robot = ControlledRobot::new(model, curve, Feedback::NONE, passive)?;
    let mut worst = 0.0_f64;
    for (segment, begin) in curve.breakpoints()[..curve.segments()].iter().enumerate() {
        let chebyshev = curve.chebyshev(segment);
        let times: Vec<f64> = chebyshev.times().iter().map(|t| begin + t).collect();
        let mut nodes = DMatrix::zeros(model.dof(), times.len());
        for (i, t) in times.iter().enumerate() {
            let (x, xdot) = curve.at_in(segment, *t);
            let u = nodes.column_mut(i);
            control_at(model, &mut robot.data, &x, &xdot, u.data.into_slice_mut())?;
        }
        (robot.segment, robot.nodes) = (segment, Some(nodes));
        for (i, ends) in times.windows(2).enumerate() {
            let x = curve.segment(segment);
            let next = x.column(i + 1);
            let mut error = 0.0_f64;
            let mut compare = |_: f64, y: &[f64]| {
                error = (y.iter().zip(next.iter())).fold(0.0, |m, (a, b)| m.max((a - b).abs()));
            };
            let (start, to) = (x.column(i), &ends[1..]);
            let start = start.as_slice();
            let end = Bdf.integrate(&mut robot, ends[0], start, to, TOLERANCE, &mut compare);
            if let Some(error) = robot.error.take() {
                return Err(error);
            }
            if end.is_err() {
                return Ok(None);
            }
            worst = worst.max(error);
        }
    }
    Ok(Some(worst))
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

/// The controlled robot as a problem for the integrator.
struct ControlledRobot<'a> {
    model: &'a Model,
    curve: &'a Curve,
    /// The current segment of the curve.
    segment: usize,
    /// The control at the nodes of that segment, `N` by `p + 1`, if only these values are used.
    nodes: Option<DMatrix<f64>>,
    feedback: Feedback,
    /// The joints that get no torque.
    passive: &'a [usize],
    data: Data<f64>,
    derivatives: ForwardDynamicsDerivatives<f64>,
    u: Vec<f64>,
    error: Option<Error>,
}

impl<'a> ControlledRobot<'a> {
    fn new(model: &'a Model, curve: &'a Curve, feedback: Feedback, passive: &'a [usize]) -> Result<Self> {
        let n = model.dof();
        model.check("curve", curve.dof())?;
        if let Some(index) = passive.iter().find(|index| **index >= n) {
            let condition = format!("the robot has {n} joints, there is none with index {index}");
            return Err(Error::input(model.name(), "passive", condition));
        }
        Ok(Self {
            model,
            curve,
            segment: 0,
            nodes: None,
            feedback,
            passive,
            data: Data::new(model),
            derivatives: ForwardDynamicsDerivatives::new(n),
            u: vec![0.0; n],
            error: None,
        })
    }

    /// Computes the control at time `t` in state `y`.
    fn control(&mut self, t: f64, y: &[f64]) -> Result<()> {
        self.control_of_all(t, y)?;
        for i in self.passive {
            self.u[*i] = 0.0;
        }
        Ok(())
    }

    /// Computes the control as if every joint were actuated.
    fn control_of_all(&mut self, t: f64, y: &[f64]) -> Result<()> {
        let n = self.model.dof();
        if let Some(nodes) = &self.nodes {
            let mut weights = DVector::zeros(nodes.ncols());
            let own = t - self.curve.breakpoints()[self.segment];
            let chebyshev = self.curve.chebyshev(self.segment);
            chebyshev.interpolation(own, &mut weights);
            DVectorViewMut::from(&mut self.u[..]).gemv(1.0, nodes, &weights, 0.0);
            return Ok(());
        }
        let (x, xdot) = self.curve.at_in(self.segment, t);
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
        aba(self.model, &mut self.data, &y[..n], &y[n..], &self.u, &mut dy[n..])
    }

    fn rates_jacobian(&mut self, t: f64, y: &[f64], jac: &mut DMatrix<f64>) -> Result<()> {
        let n = self.model.dof();
        self.control(t, y)?;
        let fd = &mut self.derivatives;
        aba_derivatives(self.model, &mut self.data, &y[..n], &y[n..], &self.u, fd)?;
        // Passive joints have no feedback.
        for i in self.passive {
            fd.h_inverse.column_mut(*i).fill(0.0);
        }
        jac.fill(0.0);
        jac.view_mut((0, n), (n, n)).fill_with_identity();
        jac.view_mut((n, 0), (n, n)).copy_from(&(&fd.dq - &fd.h_inverse * self.feedback.kp));
        jac.view_mut((n, n), (n, n)).copy_from(&(&fd.dv - &fd.h_inverse * self.feedback.kv));
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
