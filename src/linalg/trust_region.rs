//! Newton steps in a trust region.

use super::BlockTridiagonal;
use nalgebra::{DMatrix, DVector};

/// The smallest length of an acceptable step at the boundary of the region, relative to the radius.
const SHORT: f64 = 0.6;
const LONG: f64 = 1.3;
/// The largest number of multipliers tried for one step.
const TRIES: usize = 40;
/// The number of multipliers after which a step shorter than the region allows is accepted.
const PATIENCE: usize = 6;

/// A trust region about the current curve, and the multiplier of the last step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region {
    pub radius: f64,
    /// The multiplier $\lambda$.
    pub damping: f64,
    /// Typical value of `damping * radius`; the first guess for an indefinite Hessian.
    pub scale: f64,
    /// The growth factor of the radius after a step that achieved nearly all of the predicted decrease.
    pub growth: f64,
}

/// A step and its length.
pub(crate) struct Step {
    pub step: DVector<f64>,
    pub length: f64,
}

impl Default for Region {
    fn default() -> Self {
        Self {
            radius: 1.0,
            damping: 0.0,
            scale: 1.0,
            growth: 2.0,
        }
    }
}

impl Region {
    /// Minimises the quadratic model in the region, to within a third of its radius: the solution of
    /// $(B + \lambda D) d = -g$ with a multiplier $\lambda \ge 0$ that makes the matrix positive definite, and either
    /// $\lambda = 0$ and $|d|_D$ at most the radius or $|d|_D$ about the radius (Conn, Gould and Toint, *Trust-Region
    /// Methods*, chapter 7). `None` if there is no such multiplier among floating-point numbers.
    pub fn step(
        &mut self,
        gradient: &DVector<f64>,
        hessian: &BlockTridiagonal<f64>,
        norm: &BlockTridiagonal<f64>,
        factor: &mut BlockTridiagonal<f64>,
        factorisations: &mut usize,
    ) -> Option<Step> {
        // Multipliers at or below the lower bound leave the matrix indefinite or the step too long.
        let (mut lower, mut upper) = (None::<f64>, f64::INFINITY);
        for tries in 0..TRIES {
            *factorisations += 1;
            factor.set_sum(hessian, self.damping, norm);
            let next = if factor.factorise() {
                let mut step = -gradient;
                factor.solve(&mut step);
                let image = norm.product(&step);
                let length = step.dot(&image).sqrt();
                let ratio = length / self.radius;
                let long_enough = self.damping == 0.0 || ratio >= SHORT || tries > PATIENCE;
                if ratio <= LONG && long_enough {
                    return Some(Step { step, length });
                }
                if ratio > 1.0 {
                    lower = Some(self.damping);
                } else {
                    upper = self.damping;
                }
                // Newton's method for 1 / length = 1 / radius.
                let mut slope = image.clone();
                factor.solve(&mut slope);
                self.damping + (ratio - 1.0) * length * length / image.dot(&slope)
            } else {
                lower = Some(self.damping);
                (4.0 * self.damping).max(0.01 * self.scale / self.radius)
            };
            self.damping = match lower {
                _ if next > lower.unwrap_or(0.0) && next < upper => next,
                None if next <= 0.0 => 0.0,
                None => 0.1 * upper,
                Some(lower) if upper.is_finite() => (lower.max(1e-3 * upper) * upper).sqrt(),
                Some(lower) => 4.0 * lower,
            };
            if !self.damping.is_finite() {
                return None;
            }
        }
        None
    }

    /// Adapts the radius to the ratio `gain` of actual to predicted decrease of a step of this length.
    pub fn learn(&mut self, gain: f64, length: f64) {
        if gain > 0.75 && self.damping > 0.0 {
            let growth = if gain > 0.9 { self.growth } else { 2.0 };
            self.radius = self.radius.max(growth * length);
        } else if gain < 0.25 || gain.is_nan() {
            self.radius = 0.3 * length;
        }
    }
}

/// Adds a `share` of `step` to the entries of `from` from `first` on, column by column.
pub(crate) fn add_step(
    from: &DMatrix<f64>,
    first: usize,
    step: &DVector<f64>,
    share: f64,
    to: &mut DMatrix<f64>,
) {
    to.copy_from(from);
    let unknowns = &mut to.as_mut_slice()[first..first + step.len()];
    for (to, step) in unknowns.iter_mut().zip(step.iter()) {
        *to += share * step;
    }
}
