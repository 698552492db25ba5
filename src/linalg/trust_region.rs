//! Steps of Newton's method that stay where the quadratic model is worth something.

use super::BlockTridiagonal;
use nalgebra::{DMatrix, DVector};

/// A step is as long as the region allows within these factors of the radius.
const SHORT: f64 = 0.6;
const LONG: f64 = 1.3;
/// The number of multipliers that are tried for one step.
const TRIES: usize = 40;
/// The number of them that are tried before a step shorter than the region allows is good enough.
const PATIENCE: usize = 6;

/// A region about the present curve, and the multiplier with which the last step kept within it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region {
    pub radius: f64,
    /// $\lambda$.
    pub damping: f64,
    /// The size that multipliers have times that of the region.
    pub scale: f64,
    /// The factor by which the radius grows where a step gained nearly all that was predicted.
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
    /// The minimum of the quadratic model in the region, to within a third of its radius: the solution of
    /// $(B + \lambda D) d = -g$ with a multiplier $\lambda \ge 0$ that makes the matrix positive definite, and either $\lambda = 0$ and
    /// $|d|_D$ at most the radius or $|d|_D$ about the radius (Conn, Gould and Toint, *Trust-Region Methods*, chapter 7).
    /// `None` if there is no such multiplier among floating-point numbers.
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

    /// Adapts the radius to what a step of this length gained of what was predicted.
    pub fn learn(&mut self, gain: f64, length: f64) {
        if gain > 0.75 && self.damping > 0.0 {
            let growth = if gain > 0.9 { self.growth } else { 2.0 };
            self.radius = self.radius.max(growth * length);
        } else if gain < 0.25 || gain.is_nan() {
            self.radius = 0.3 * length;
        }
    }
}

/// `from` and a `share` of `step` added to its entries from `first` on, column by column.
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
