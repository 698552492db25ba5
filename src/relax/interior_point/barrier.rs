//! The barrier of a row that may be broken at a price.

use super::barrier_cost::Kind;

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

/// What a multiplier may be apart from the one that belongs to a row, in either direction.
const APART: f64 = 1e4;

impl Barrier {
    /// The bounds of the multipliers.
    fn bounds(&self, kind: Kind) -> [f64; 2] {
        [
            if kind == Kind::Inequality {
                0.0
            } else {
                -self.nu
            },
            self.nu,
        ]
    }

    /// $\hat z - a$ and $b - \hat z$ where `a` and `b` are the bounds of the multipliers.
    fn distances(&self, h: f64, kind: Kind) -> [f64; 2] {
        let [a, b] = self.bounds(kind);
        let (width, mu) = (b - a, self.mu);
        let product = h * width;
        let root = (product * product + 4.0 * mu * mu).sqrt();
        // The root less the product and the root and the product, none of which loses digits.
        let (less, more) = if product > 0.0 {
            (4.0 * mu * (mu / (root + product)), root + product)
        } else {
            (root - product, 4.0 * mu * (mu / (root - product)))
        };
        let lower = 2.0 * mu * width / (2.0 * mu + less);
        let upper = 2.0 * mu * width / (2.0 * mu + more);
        [lower, upper]
    }

    /// $\hat z = \psi'(h)$.
    pub(super) fn multiplier(&self, h: f64, kind: Kind) -> f64 {
        if kind == Kind::Idle {
            return 0.0;
        }
        let [a, b] = self.bounds(kind);
        let [lower, upper] = self.distances(h, kind);
        if lower < upper { a + lower } else { b - upper }
    }

    /// $\psi(h)$.
    pub(super) fn value(&self, h: f64, kind: Kind) -> f64 {
        if kind == Kind::Idle {
            return 0.0;
        }
        let [a, b] = self.bounds(kind);
        let [slack, excess] = self.distances(h, kind).map(|d| self.mu / d);
        b * excess - a * slack - self.mu * (slack * excess).ln()
    }

    /// The second derivative for a primal-dual iterate: with a multiplier `z` of its own in place of $\hat z$ in one factor of each term,
    /// $1 / (s / (z - a) + t / (b - z))$. For $z = \hat z$ it is $\psi''(h)$.
    pub(super) fn curvature(&self, h: f64, z: f64, kind: Kind) -> f64 {
        if kind == Kind::Idle {
            return 0.0;
        }
        let [a, b] = self.bounds(kind);
        let [slack, excess] = self.distances(h, kind).map(|d| self.mu / d);
        (slack / (z - a) + excess / (b - z)).recip()
    }

    /// The multiplier nearest to `z` that is not too far from $\hat z$.
    pub(super) fn safeguarded(&self, z: f64, h: f64, kind: Kind) -> f64 {
        if kind == Kind::Idle {
            return 0.0;
        }
        let [a, b] = self.bounds(kind);
        let [lower, upper] = self.distances(h, kind);
        let most = 0.5 * (b - a);
        if lower < upper {
            a + (z - a).clamp(lower / APART, (lower * APART).min(most))
        } else {
            b - (b - z).clamp(upper / APART, (1.0 - 1e-6) * (b - a))
        }
    }
}
