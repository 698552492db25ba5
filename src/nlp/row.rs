//! One row: its slack, elastic variable and multiplier, their steps, and its terms in the condensed equations.

/// The fraction of the penalty above which a multiplier shows that its row is violated because that is cheap.
const AT_PENALTY: f64 = 0.9;

/// A row of the working set.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The index among all rows.
    pub at: usize,
    /// The weight without the measure of the problem.
    pub weight: f64,
    /// True for an inequality that makes the Hessian indefinite by itself, such as a clearance: of its second
    /// derivatives the Hessian has [a part](super::Iterate::curvature_weight).
    pub is_curved: bool,
}

impl Row {
    /// A row all of whose second derivatives the Hessian has.
    #[must_use]
    pub const fn new(at: usize, weight: f64) -> Self {
        Self { at, weight, is_curved: false }
    }
}

/// A row that is an equality.
#[derive(Clone, Copy, Debug)]
pub struct Equality {
    pub row: Row,
    /// The penalty of its square without a search before.
    pub first: f64,
    /// The penalty $\rho$ of its square.
    pub penalty: f64,
    /// $\lambda$.
    pub multiplier: f64,
    /// The estimate $y$ of the multiplier that takes the Newton steps of the primal-dual equations.
    pub estimate: f64,
}

impl Equality {
    /// An equality with its first penalty, and `factor` times that to begin with.
    #[must_use]
    pub fn new(row: Row, first: f64, factor: f64) -> Self {
        Self { row, first, penalty: factor * first, multiplier: 0.0, estimate: 0.0 }
    }
}

/// The slack $s$, the elastic variable $t$, the multiplier $\lambda$ and the penalty $\nu$ of an inequality, with the
/// conditions $s \lambda = \mu$ and $t (\nu - \lambda) = \mu$.
#[derive(Clone, Copy, Debug)]
pub struct RowState {
    pub row: Row,
    pub slack: f64,
    pub elastic: f64,
    pub multiplier: f64,
    /// The penalty of its violation: not less than [that of all](super::Barrier::nu).
    pub penalty: f64,
}

/// The weights of a row in the condensed equations.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// The weight of its gradient.
    pub slope: f64,
    /// The weight of the product of its gradient with itself.
    pub curvature: f64,
    /// The weight of its second derivative: the multiplier.
    pub multiplier: f64,
    /// The terms of the row in the barrier function.
    pub cost: f64,
}

impl Term {
    /// The term times a factor.
    pub fn times(self, factor: f64) -> Self {
        Self {
            slope: factor * self.slope,
            curvature: factor * self.curvature,
            multiplier: factor * self.multiplier,
            cost: factor * self.cost,
        }
    }
}

/// A step of slack, elastic variable and multiplier.
#[derive(Clone, Copy, Debug)]
pub struct RowStep {
    pub slack: f64,
    pub elastic: f64,
    pub multiplier: f64,
}

impl RowState {
    /// Returns true if the multiplier has nearly reached the penalty.
    pub fn is_at_penalty(&self) -> bool {
        self.multiplier > AT_PENALTY * self.penalty
    }

    /// Returns true if the row is violated by more than `feasible` because its penalty is small.
    pub fn needs_penalty(&self, h: &[f64], feasible: f64) -> bool {
        h[self.row.at] > feasible && self.is_at_penalty()
    }

    /// The state after a fraction of a step; slack, elastic variable, multiplier and its distance from the penalty each
    /// keep at least $1 - \tau$ of their value: the fraction-to-the-boundary rule row by row (WB 15).
    #[inline]
    pub fn take(&self, step: &RowStep, fraction: f64, tau: f64) -> Self {
        let moved = |value: f64, by: f64| (value + by).max((1.0 - tau) * value);
        let (z, nu) = (self.multiplier, self.penalty);
        let by = moved(z, fraction * step.multiplier) - z;
        Self {
            slack: moved(self.slack, fraction * step.slack),
            elastic: moved(self.elastic, fraction * step.elastic),
            multiplier: nu - moved(nu - z, -by),
            ..*self
        }
    }

    /// Enlarges slack or elastic variable until $h + s = t$.
    #[inline]
    pub fn meet(&mut self, h: f64) {
        let excess = h + self.slack - self.elastic;
        if excess > 0.0 {
            self.elastic += excess;
        } else {
            self.slack -= excess;
        }
    }

    /// Keeps the multiplier within a factor `range` of the one that belongs to slack and elastic variable (WB 16).
    pub(super) fn safeguard(&mut self, mu: f64, range: f64) {
        let (s, t, nu) = (self.slack, self.elastic, self.penalty);
        let z = &mut self.multiplier;
        if s > t {
            let most = (mu / s * range).min((1.0 - f64::EPSILON) * nu);
            *z = z.max(mu / s / range).min(most);
        } else {
            // Not less than rounding leaves between a multiplier and the penalty.
            let least = (mu / t / range).max(f64::EPSILON * nu);
            let upper = (nu - *z).max(least).min((mu / t * range).max(least));
            *z = nu - upper.min((1.0 - f64::EPSILON) * nu);
        }
    }
}
