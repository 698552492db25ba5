//! A motion that is known, and shows that a scenario has a solution.

use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::model::Model;
use crate::scenario::preflight::slowest;

/// The peak of the velocity of [`progress`] over its mean.
const PEAK: f64 = 1.25;
/// The share of the velocity limits that a known motion takes at most.
const VELOCITY_SHARE: f64 = 0.98;
/// By how much the horizon of a generated scenario exceeds the least one of the velocity limits. [`PEAK`] is below it.
pub(super) const HORIZON_RATIO: f64 = 1.3;
/// The velocity limit of a joint that has none, rad/s or m/s.
const NOMINAL_SPEED: f64 = 3.0;
/// At how many times the limits are looked at.
const TIMES: usize = 241;
/// The parts of a bend that are tried until one breaks no limit; the line is the last resort.
const PARTS: [f64; 8] = [1.0, 0.7, 0.5, 0.35, 0.25, 0.15, 0.08, 0.0];
/// Every so many times first, where most motions that break a limit do so already.
const STRIDE: usize = 24;

/// A rest-to-rest motion $q(t) = q_0 + (q_1 - q_0) s(t / T) + b\\, h(t / T)$, a polynomial of degree 5 in every joint, so that the
/// relaxation has it among its motions.
pub(super) struct Witness<'a> {
    pub model: &'a Model,
    /// Its start and its end.
    pub ends: [Vec<f64>; 2],
    /// The distance of each joint from the line in the middle.
    pub bend: Vec<f64>,
    /// Its duration, s.
    pub horizon: f64,
}

/// $s$, $s'$, $s''$: from 0 to 1 at the velocity $\tfrac54 (1 - x^4)$, $x = 2 \tau - 1$, which is nearly constant.
fn progress(tau: f64) -> [f64; 3] {
    let x = 2.0 * tau - 1.0;
    [
        0.5 + PEAK * (0.5 * x - 0.1 * x.powi(5)),
        PEAK * (1.0 - x.powi(4)),
        -8.0 * PEAK * x.powi(3),
    ]
}

/// $h$, $h'$, $h''$ of $h = 16 \tau^2 (1 - \tau)^2$: one in the middle, at rest at both ends.
fn bump(tau: f64) -> [f64; 3] {
    let rest = 1.0 - tau;
    [
        16.0 * (tau * rest).powi(2),
        32.0 * tau * rest * (rest - tau),
        32.0 * (1.0 - 6.0 * tau * rest),
    ]
}

/// The least horizon at the velocity limits; a joint without one has [`NOMINAL_SPEED`].
pub(super) fn least_horizon(model: &Model, [start, goal]: &[Vec<f64>; 2]) -> f64 {
    let speed = |i: usize| {
        let limit = model.joints()[i].limits().velocity;
        if limit.is_finite() {
            limit
        } else {
            NOMINAL_SPEED
        }
    };
    slowest(start, goal, speed).map_or(0.0, |(_, time)| time)
}

impl<'a> Witness<'a> {
    /// That with each joint bent by as much of `wish` as its limits of position and velocity leave room for.
    pub(super) fn bent(
        model: &'a Model,
        ends: [Vec<f64>; 2],
        wish: Vec<f64>,
        horizon: f64,
    ) -> Self {
        let mut witness = Self {
            model,
            ends,
            bend: wish,
            horizon,
        };
        for i in 0..model.dof() {
            let wish = witness.bend[i];
            for part in PARTS {
                witness.bend[i] = part * wish;
                if (0..TIMES).all(|k| witness.joint_keeps(i, k)) {
                    break;
                }
            }
        }
        witness
    }

    /// Position, velocity and acceleration of a joint at the part `tau` of the horizon.
    pub(super) fn joint(&self, i: usize, tau: f64) -> [f64; 3] {
        let (s, h) = (progress(tau), bump(tau));
        let [start, goal] = [self.ends[0][i], self.ends[1][i]];
        let along = |k: usize| (goal - start) * s[k] + self.bend[i] * h[k];
        let rate = self.horizon.recip();
        [start + along(0), along(1) * rate, along(2) * rate * rate]
    }

    /// Tells whether a joint keeps its limits of position and velocity at the time `k` of [`TIMES`].
    fn joint_keeps(&self, i: usize, k: usize) -> bool {
        let [q, v, _] = self.joint(i, k as f64 / (TIMES - 1) as f64);
        let limits = self.model.joints()[i].limits();
        v.abs() <= VELOCITY_SHARE * limits.velocity && (limits.lower..=limits.upper).contains(&q)
    }

    /// Tells whether it keeps all limits, those of the torques with the share `torque` of them, and those torques hold both ends at rest.
    pub(super) fn keeps_limits(&self, torque: f64) -> Result<bool> {
        let mut data = Data::new(self.model);
        let n = self.model.dof();
        let rest = vec![0.0; n];
        let mut tau = vec![0.0; n];
        let mut strong = |q: &[f64], v: &[f64], a: &[f64]| -> Result<bool> {
            rnea(self.model, &mut data, q, v, a, &mut tau)?;
            let mut joints = self.model.joints().iter().zip(&tau);
            Ok(joints.all(|(joint, tau)| tau.abs() <= torque * joint.limits().effort))
        };
        for end in &self.ends {
            if !strong(end, &rest, &rest)? {
                return Ok(false);
            }
        }
        let [mut q, mut v, mut a] = [rest.clone(), rest.clone(), rest];
        for stride in [STRIDE, 1] {
            for k in (0..TIMES).step_by(stride) {
                for i in 0..n {
                    [q[i], v[i], a[i]] = self.joint(i, k as f64 / (TIMES - 1) as f64);
                }
                if !(0..n).all(|i| self.joint_keeps(i, k)) {
                    return Ok(false);
                }
                if !strong(&q, &v, &a)? {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }
}
