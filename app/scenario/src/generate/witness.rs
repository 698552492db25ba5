//! A known motion that proves that a scenario has a solution.

use crate::solve::preflight::slowest;
use aghf::dynamics::{Data, rnea};
use aghf::error::Result;
use aghf::model::Model;

/// The ratio of peak to mean velocity of [`progress`].
const PEAK: f64 = 1.25;
/// The largest share of the velocity limits that a known motion uses.
const VELOCITY_SHARE: f64 = 0.98;
/// The ratio of the horizon of a generated scenario to the shortest one that the velocity limits allow. [`PEAK`] is
/// smaller.
pub(super) const HORIZON_RATIO: f64 = 1.3;
/// The velocity limit of a joint that has none, rad/s or m/s.
const NOMINAL_SPEED: f64 = 3.0;
/// The number of times at which the limits are checked.
const SAMPLES: usize = 241;
/// The fractions of a bend tried until one satisfies all limits; the line is the last resort.
const PARTS: [f64; 8] = [1.0, 0.7, 0.5, 0.35, 0.25, 0.15, 0.08, 0.0];
/// The stride of the first pass over the times, which already rejects most motions that violate a limit.
const STRIDE: usize = 24;

/// A rest-to-rest motion $q(t) = q_0 + (q_1 - q_0) s(t / T) + b\\, h(t / T)$, a polynomial of degree 5 per joint, so
/// that the direct method can represent it.
pub(super) struct Witness<'a> {
    pub model: &'a Model,
    /// Its start and its end.
    pub ends: [Vec<f64>; 2],
    /// The distance of each joint from the line at half time.
    pub bend: Vec<f64>,
    /// Its duration, s.
    pub horizon: f64,
}

/// $s$, $s'$, $s''$: from 0 to 1 at the velocity $\tfrac54 (1 - x^4)$, $x = 2 \tau - 1$, which is nearly constant.
fn progress(tau: f64) -> [f64; 3] {
    let x = 2.0 * tau - 1.0;
    [0.5 + PEAK * (0.5 * x - 0.1 * x.powi(5)), PEAK * (1.0 - x.powi(4)), -8.0 * PEAK * x.powi(3)]
}

/// $h$, $h'$, $h''$ of $h = 16 \tau^2 (1 - \tau)^2$: one in the middle, at rest at both ends.
fn bump(tau: f64) -> [f64; 3] {
    let rest = 1.0 - tau;
    [16.0 * (tau * rest).powi(2), 32.0 * tau * rest * (rest - tau), 32.0 * (1.0 - 6.0 * tau * rest)]
}

/// The shortest horizon at the velocity limits; [`NOMINAL_SPEED`] is used for a joint without one.
pub(super) fn least_horizon(model: &Model, [start, goal]: &[Vec<f64>; 2]) -> f64 {
    let speed = |i: usize| {
        let limit = model.joints()[i].limits().velocity;
        if limit.is_finite() { limit } else { NOMINAL_SPEED }
    };
    slowest(start, goal, speed).map_or(0.0, |(_, time)| time)
}

impl<'a> Witness<'a> {
    /// Builds the motion with each joint bent by the largest part of `wish` that its limits of position and velocity
    /// allow.
    pub(super) fn bent(model: &'a Model, ends: [Vec<f64>; 2], wish: Vec<f64>, horizon: f64) -> Self {
        let mut witness = Self { model, ends, bend: wish, horizon };
        for i in 0..model.dof() {
            let wish = witness.bend[i];
            for part in PARTS {
                witness.bend[i] = part * wish;
                if (0..SAMPLES).all(|k| witness.joint_keeps(i, k)) {
                    break;
                }
            }
        }
        witness
    }

    /// Position, velocity and acceleration of a joint at the fraction `tau` of the horizon.
    pub(super) fn joint(&self, i: usize, tau: f64) -> [f64; 3] {
        let (s, h) = (progress(tau), bump(tau));
        let [start, goal] = [self.ends[0][i], self.ends[1][i]];
        let along = |k: usize| (goal - start) * s[k] + self.bend[i] * h[k];
        let rate = self.horizon.recip();
        [start + along(0), along(1) * rate, along(2) * rate * rate]
    }

    /// Returns true if a joint satisfies its limits of position and velocity at time `k` of [`SAMPLES`].
    fn joint_keeps(&self, i: usize, k: usize) -> bool {
        let [q, v, _] = self.joint(i, k as f64 / (SAMPLES - 1) as f64);
        let limits = self.model.joints()[i].limits();
        v.abs() <= VELOCITY_SHARE * limits.velocity && (limits.lower..=limits.upper).contains(&q)
    }

    /// Returns true if the motion satisfies all limits, those of the torques scaled by `torque`, and the torques can
    /// hold both ends at rest.
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
            for k in (0..SAMPLES).step_by(stride) {
                for i in 0..n {
                    [q[i], v[i], a[i]] = self.joint(i, k as f64 / (SAMPLES - 1) as f64);
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
