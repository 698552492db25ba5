//! The barrier of a row that may be broken at a price.

use super::row::Kind;
use crate::relax::tuning::{APART, INSIDE};

/// A smooth exact penalty: what is left of the price $\nu$ of an excess $t$ and of the logarithmic barriers of weight $\mu$ of the
/// excess and of the slack $s$ of a row $h \le 0$, when both are chosen best,
///
/// $$ \psi(h) = \min_{s, t > 0} \{ \nu t - \mu \log s - \mu \log t : h + s = t \} . $$
///
/// The multiplier $\hat z = \psi'(h) \in (0, \nu)$ solves $h = \mu / (\nu - z) - \mu / z$, with $s = \mu / \hat z$ and
/// $t = \mu / (\nu - \hat z)$. Far inside $\psi$ is the usual barrier $-\mu \log(-h)$, far outside it is $\nu h$, and as $\mu \to 0$ it
/// becomes the exact penalty $\nu \max(0, h)$ (Gould, Orban and Toint, *An interior-point l1-penalty method for nonlinear
/// optimization*, 2015). A row $h = 0$ has multipliers in $(-\nu, \nu)$ instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// $\mu > 0$.
    pub mu: f64,
    /// $\nu > 0$.
    pub nu: f64,
}

/// The slack and the excess that are best for a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    slack: f64,
    excess: f64,
    /// $\mu$, and the bounds `a` and `b` of the multipliers.
    mu: f64,
    bounds: [f64; 2],
}

impl Barrier {
    /// The split of a row of the value `h`; nothing where no row is asked for.
    pub(super) fn split(&self, h: f64, kind: Kind) -> Option<Split> {
        let a = match kind {
            Kind::Inequality => 0.0,
            Kind::Equality => -self.nu,
            Kind::Idle => return None,
        };
        let (width, mu) = (self.nu - a, self.mu);
        let product = h * width;
        let root = (product * product + 4.0 * mu * mu).sqrt();
        // The root less the product and the root and the product, none of which loses digits.
        let large = root + product.abs();
        let small = 4.0 * mu * (mu / large);
        let (less, more) = if product > 0.0 {
            (small, large)
        } else {
            (large, small)
        };
        let half = 0.5 / width;
        Some(Split {
            slack: (2.0 * mu + less) * half,
            excess: (2.0 * mu + more) * half,
            mu,
            bounds: [a, self.nu],
        })
    }
}

impl Split {
    /// $\hat z = \psi'(h)$.
    pub fn multiplier(&self) -> f64 {
        let [a, b] = self.bounds;
        if self.slack > self.excess {
            a + self.mu / self.slack
        } else {
            b - self.mu / self.excess
        }
    }

    /// $\psi(h)$ without its logarithms, and what these are of: a product is one logarithm for many rows.
    pub fn value(&self) -> (f64, f64) {
        let [a, b] = self.bounds;
        (b * self.excess - a * self.slack, self.slack * self.excess)
    }

    /// The second derivative for a primal-dual iterate: with a multiplier `z` of its own in place of $\hat z$ in one factor of each term,
    /// $1 / (s / (z - a) + t / (b - z))$. For $z = \hat z$ it is $\psi''(h)$.
    pub fn curvature(&self, z: f64) -> f64 {
        let [a, b] = self.bounds;
        let (lower, upper) = (z - a, b - z);
        lower * upper / (self.slack * upper + self.excess * lower)
    }

    /// The multiplier nearest to `z` that is not too far from $\hat z$; some multiplier where rows that overflowed left none.
    pub fn safeguarded(&self, z: f64) -> f64 {
        let [a, b] = self.bounds;
        let width = b - a;
        if self.slack > self.excess {
            let lower = self.mu / self.slack;
            a + (z - a)
                .max(lower / APART)
                .min((lower * APART).min(0.5 * width))
        } else {
            let upper = self.mu / self.excess;
            b - (b - z).max(upper / APART).min((1.0 - INSIDE) * width)
        }
    }
}
