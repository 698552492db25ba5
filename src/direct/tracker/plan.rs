//! A plan in time, and the command that follows it.

use super::TrackerOptions;
use crate::direct::minimise::Candidate;
use crate::dynamics::{Data, InverseDynamicsDerivatives, rnea_derivatives};
use crate::error::Result;
use crate::model::Model;
use crate::motion::PathMemory as Memory;
use nalgebra::DMatrix;

/// A motion that begins at a time and ends at rest.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub motion: Candidate,
    /// The time at which it begins, s.
    pub began: f64,
}

impl Plan {
    /// The time that is left, s, at least zero.
    pub fn left(&self, now: f64) -> f64 {
        (self.began + self.motion.horizons.whole() - now).max(0.0)
    }

    /// Sets `rest` to the rest of the motion with its multipliers, the same polynomial; near the end to all of the last
    /// `shortest` seconds.
    pub fn rest_in(&self, now: f64, shortest: f64, memory: &mut Memory, rest: &mut Self) {
        let (from, to) = (&self.motion, &mut rest.motion);
        let left = self.left(now).max(shortest).min(from.horizons.whole());
        to.multipliers.set(&from.multipliers);
        if left < from.horizons.whole() {
            let share = 1.0 - left / from.horizons.whole();
            from.path.after_in(share, memory, &mut to.path.coefficients);
            to.multipliers.begin_after(share);
        } else {
            to.path.coefficients.copy_from(&from.path.coefficients);
        }
        to.horizons.set(0, left);
        rest.began = now;
    }

    /// The rest of the motion; see [`rest_in`](Self::rest_in).
    pub fn rest(&self, now: f64, shortest: f64) -> Self {
        let mut rest = self.clone();
        self.rest_in(now, shortest, &mut Memory::default(), &mut rest);
        rest
    }

    /// Becomes another plan in the same basis.
    pub fn set(&mut self, other: &Self) {
        let (from, to) = (&other.motion, &mut self.motion);
        to.multipliers.set(&from.multipliers);
        to.path.coefficients.copy_from(&from.path.coefficients);
        to.horizons.assign(&from.horizons);
        self.began = other.began;
    }

    /// The configuration, velocity and acceleration at a time; after the end those of rest there.
    pub fn at(&self, now: f64) -> [Vec<f64>; 3] {
        let zeros = || vec![0.0; self.motion.path.coefficients.nrows()];
        let mut all = [zeros(), zeros(), zeros()];
        let [q, v, a] = &mut all;
        self.at_in(now, &mut Memory::default(), [q, v, a]);
        all
    }

    /// Computes configuration, velocity and acceleration at a time; see [`at`](Self::at).
    fn at_in(&self, now: f64, memory: &mut Memory, out: [&mut [f64]; 3]) {
        let (path, horizon) = (&self.motion.path, self.motion.horizons.whole());
        let left = self.left(now);
        let local = memory.evaluate(path, 1.0 - left / horizon);
        let moving = f64::from(u8::from(left > 0.0));
        let factors = [1.0, moving / horizon, moving / horizon.powi(2)];
        for ((out, x), factor) in out.into_iter().zip(local).zip(factors) {
            for (out, x) in out.iter_mut().zip(x) {
                *out = x * factor;
            }
        }
    }
}

/// The command at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// The configuration of the plan, rad or m, `N` entries.
    pub q: Vec<f64>,
    /// The velocity of the plan, per s.
    pub v: Vec<f64>,
    /// The acceleration of the plan, per s^2; at its end zero.
    pub a: Vec<f64>,
    /// The torque of the plan, $ID(q, v, a)$, N m or N.
    pub tau: Vec<f64>,
    /// The gain $K$ of the feedback, `N` by `2 N`.
    ///
    /// With $H = \partial ID / \partial a$ it is $[\omega^2 H - \partial ID / \partial q \quad 2 \omega H - \partial ID
    /// / \partial v]$ at the plan, so that with $u = \tau - K (x - x_{plan})$ and an exact model small deviations obey
    /// $\ddot e + 2 \omega \dot e + \omega^2 e = 0$: computed torque to first order (Siciliano, Sciavicco, Villani and
    /// Oriolo, *Robotics*, 2009, 8.5.2), critically damped.
    pub gain: DMatrix<f64>,
    /// The torque to apply at the measured state, $u = \tau - K (x - x_{plan})$. The limits of torques hold for `tau`.
    pub u: Vec<f64>,
}

/// A command with the workspace of its computation.
pub(super) struct Commander {
    pub command: Command,
    data: Data<f64>,
    derivatives: InverseDynamicsDerivatives,
    memory: Memory,
}

impl Commander {
    pub fn new(model: &Model) -> Self {
        let n = model.dof();
        let zeros = || vec![0.0; n];
        Self {
            command: Command {
                q: zeros(),
                v: zeros(),
                a: zeros(),
                tau: zeros(),
                gain: DMatrix::zeros(n, 2 * n),
                u: zeros(),
            },
            data: Data::new(model),
            derivatives: InverseDynamicsDerivatives::new(n),
            memory: Memory::default(),
        }
    }

    /// Sets the configuration, velocity and acceleration of the command.
    pub fn place(&mut self, plan: &Plan, now: f64) {
        let own = &mut self.command;
        plan.at_in(now, &mut self.memory, [&mut own.q, &mut own.v, &mut own.a]);
    }

    /// The largest distance of a joint from the command, rad or m.
    pub fn deviation(&self, state: &[f64]) -> f64 {
        let distances = self.command.q.iter().zip(state).map(|(a, b)| (a - b).abs());
        distances.fold(0.0, f64::max)
    }

    /// Computes torques and gain.
    pub fn command(&mut self, model: &Model, state: &[f64], options: &TrackerOptions) -> Result<()> {
        let (n, omega) = (model.dof(), options.bandwidth);
        let Self { command: own, data, derivatives: of, .. } = self;
        rnea_derivatives(model, data, &own.q, &own.v, &own.a, of)?;
        own.tau.copy_from_slice(of.tau.as_slice());
        for i in 0..n {
            own.u[i] = own.tau[i];
            for j in 0..n {
                let of_q = omega * omega * of.h[(i, j)] - of.dq[(i, j)];
                let of_v = 2.0 * omega * of.h[(i, j)] - of.dv[(i, j)];
                (own.gain[(i, j)], own.gain[(i, n + j)]) = (of_q, of_v);
                own.u[i] -= of_q * (state[j] - own.q[j]) + of_v * (state[n + j] - own.v[j]);
            }
        }
        Ok(())
    }
}
