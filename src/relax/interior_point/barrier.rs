//! The barrier of a row that may be violated at a price.

use crate::relax::tuning::{APART, FAR, INSIDE};

/// A smooth exact penalty: the price $\nu$ of an excess $t$, together with logarithmic barriers of weight $\mu$ on the
/// excess and on the slack $s$ of a row $h \le 0$, minimised over both,
///
/// $$ \psi(h) = \min_{s, t > 0} \\{ \nu t - \mu \log s - \mu \log t : h + s = t \\} . $$
///
/// The multiplier $\hat z = \psi'(h) \in (0, \nu)$ solves $h = \mu / (\nu - z) - \mu / z$, with $s = \mu / \hat z$ and
/// $t = \mu / (\nu - \hat z)$. Far inside $\psi$ is the usual barrier $-\mu \log(-h)$, far outside it is $\nu h$, and
/// as $\mu \to 0$ it becomes the exact penalty $\nu \max(0, h)$ (Gould, Orban and Toint, *An interior-point l1-penalty
/// method for nonlinear optimization*, 2015).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// $\mu > 0$.
    pub mu: f64,
    /// $\nu > 0$.
    pub nu: f64,
}

/// The optimal slack and excess of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    slack: f64,
    excess: f64,
    mu: f64,
    nu: f64,
}

/// The term of a row in the merit function.
#[derive(Clone, Copy, Debug)]
pub(super) enum Term {
    /// The barrier of an inequality.
    Barrier(Split),
    /// The barrier of a clearance, which fades out as the distance approaches [`FAR`], with the distance relative to
    /// that.
    Fading(Split, f64),
    /// $\lambda h + \tfrac12 \rho h^2$ of an equality.
    Dual {
        /// $\lambda$.
        dual: f64,
        /// $\rho$.
        penalty: f64,
        h: f64,
    },
}

impl Barrier {
    /// The optimal split of a row of value `h`.
    #[inline]
    pub(super) fn split(&self, h: f64) -> Split {
        let Self { mu, nu } = *self;
        let product = h * nu;
        let root = (product * product + 4.0 * mu * mu).sqrt();
        // The root less the product and the root and the product, none of which loses digits.
        let large = root + product.abs();
        let small = 4.0 * mu * (mu / large);
        let (less, more) = if product > 0.0 {
            (small, large)
        } else {
            (large, small)
        };
        let half = 0.5 / nu;
        Split {
            slack: (2.0 * mu + less) * half,
            excess: (2.0 * mu + more) * half,
            mu,
            nu,
        }
    }
}

impl Split {
    /// $\hat z = \psi'(h)$.
    #[inline]
    fn multiplier(&self) -> f64 {
        if self.slack > self.excess {
            self.mu / self.slack
        } else {
            self.nu - self.mu / self.excess
        }
    }

    /// The multiplier nearest to `z` that is not too far from $\hat z$; an arbitrary one if the row has overflowed.
    #[inline]
    fn safeguarded(&self, z: f64) -> f64 {
        let nu = self.nu;
        if self.slack > self.excess {
            let lower = self.mu / self.slack;
            z.max(lower / APART).min((lower * APART).min(0.5 * nu))
        } else {
            let upper = self.mu / self.excess;
            nu - (nu - z).max(upper / APART).min((1.0 - INSIDE) * nu)
        }
    }
}

impl Term {
    /// The first derivative with respect to the row.
    #[inline]
    pub fn slope(&self) -> f64 {
        self.multiplier() - self.lift()
    }

    /// The part of the slope of a logarithm that a fading barrier lacks.
    #[inline]
    fn lift(&self) -> f64 {
        match self {
            Self::Fading(split, share) => (2.0 - share.max(0.0)) * split.mu / FAR,
            _ => 0.0,
        }
    }

    /// The multiplier of the row.
    #[inline]
    pub fn multiplier(&self) -> f64 {
        match self {
            Self::Barrier(split) | Self::Fading(split, _) => split.multiplier(),
            Self::Dual { dual, penalty, h } => dual + penalty * h,
        }
    }

    /// The value without its logarithms, and their argument: the product of arguments turns the logarithms of many rows
    /// into one.
    #[inline]
    pub fn value(&self) -> (f64, f64) {
        match self {
            Self::Barrier(split) => (split.nu * split.excess, split.slack * split.excess),
            Self::Fading(split, share) => {
                // Beyond the bound the rest is a line.
                let less = if *share > 0.0 {
                    (1.0 - share) * (1.5 - 0.5 * share)
                } else {
                    1.5 - 2.0 * share
                };
                let value = split.nu * split.excess - split.mu * less;
                (value, split.slack * split.excess)
            }
            Self::Dual { dual, penalty, h } => ((dual + 0.5 * penalty * h) * h, 1.0),
        }
    }

    /// The derivative of the multiplier with respect to the row at a primal-dual iterate: an independent multiplier `z`
    /// replaces $\hat z$ in one factor of each term of a barrier, $1 / (s / z + t / (\nu - z))$. For $z = \hat z$ it is
    /// $\psi''(h)$.
    #[inline]
    pub fn rate(&self, z: f64) -> f64 {
        match self {
            Self::Barrier(split) | Self::Fading(split, _) => {
                let upper = split.nu - z;
                z * upper / (split.slack * upper + split.excess * z)
            }
            Self::Dual { penalty, .. } => *penalty,
        }
    }

    /// The second derivative, with the same replacement.
    #[inline]
    pub fn curvature(&self, z: f64) -> f64 {
        match self {
            Self::Fading(split, share) if *share > 0.0 => {
                (self.rate(z) - split.mu / (FAR * FAR)).max(0.0)
            }
            _ => self.rate(z),
        }
    }

    /// The weight of the second derivatives of the row.
    #[inline]
    pub fn weight(&self, z: f64) -> f64 {
        match self {
            Self::Fading(..) => (z - self.lift()).max(0.0),
            _ => z,
        }
    }

    /// The admissible multiplier nearest to `z`.
    #[inline]
    pub fn safeguarded(&self, z: f64) -> f64 {
        match self {
            Self::Barrier(split) | Self::Fading(split, _) => split.safeguarded(z),
            Self::Dual { .. } => self.multiplier(),
        }
    }
}
